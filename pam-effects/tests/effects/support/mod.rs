//! Joints, runs and values that the tests share.

pub(crate) mod complex;
pub(crate) mod extended;
pub(crate) mod joint;
pub(crate) mod published;
pub(crate) mod values;
