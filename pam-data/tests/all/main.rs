//! Recordings and their preprocessing.

mod preprocess {
    mod gradient;
    mod low_pass;
    mod options;
}
mod document;
mod fingerprint;
mod mat_time;
mod numpy_and_matlab;
mod recording;
mod rig_file;
