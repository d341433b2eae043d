//! Recordings and their preprocessing.

mod preprocess {
    mod gradient;
    mod low_pass;
    mod options;
}
mod recording;
