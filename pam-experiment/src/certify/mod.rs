//! How far to trust a diagnosis on one rig.

mod certificate;

pub use certificate::{Certificate, Trust};
