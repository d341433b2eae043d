//! Effects in the gas.

pub mod geometry_coefficient;
pub mod leak;
pub mod polytropic_gas;
