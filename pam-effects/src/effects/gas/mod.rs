//! Effects in the air.

pub(super) mod geometry_coefficient;
pub(super) mod leak;
pub(super) mod polytropic_gas;
