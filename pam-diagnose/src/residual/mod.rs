//! Where a recording becomes residuals, and what they look like before any name: size over noise, dependence on factors,
//! spectrum, time profile, and a description in sentences. [`FlexibleModel`] tells what of it can be learned at all.

mod dependence;
pub(crate) mod flexible;
mod spectrum;
mod summary;
mod timing;

pub use dependence::Dependence;
pub(crate) use dependence::Factors;
pub use flexible::{FeatureRows, FlexibleModel};
pub use spectrum::{Line, Spectrum};
pub use summary::{ChannelResidual, ResidualSummary};
pub use timing::{Jump, TimeProfile};
