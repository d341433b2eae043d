//! Where a recording becomes residuals, and what they look like before any name: size over noise, dependence on factors,
//! spectrum, time profile, and a description in sentences.

mod dependence;
mod spectrum;
mod summary;
mod timing;

pub use dependence::Dependence;
pub use spectrum::{Line, Spectrum};
pub use summary::{ChannelResidual, ResidualSummary};
pub use timing::{Jump, TimeProfile};
