//! Effects in the air.

mod geometry_coefficient;
mod leak;
mod polytropic_gas;

pub use geometry_coefficient::GeometryCoefficient;
pub use leak::Leak;
pub use polytropic_gas::PolytropicGas;
