//! Losses, metrics and engines against differences and closed forms.

mod engine {
    mod exact;
    mod surrogate;
}
mod loss {
    mod any;
    mod closures;
    mod huber;
    mod masked;
    mod normalised;
    mod own;
    mod pointwise;
    mod spec;
    mod squared;
    mod testing;
}
mod metrics;
