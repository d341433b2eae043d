//! What moves a vector of numbers downhill.

mod adam;
mod clip;

pub use adam::{Adam, AdamSettings};
pub use clip::clip_to_norm;
