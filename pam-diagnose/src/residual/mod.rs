//! What is wrong: the residual against the noise, and what it goes with.

mod dependence;
mod spectrum;
mod story;
mod timing;

pub(crate) use dependence::correlation_ratio;
pub use dependence::{Dependence, FACTORS};
pub use spectrum::{Line, Spectrum};
pub use story::{ChannelStory, ResidualStory};
pub use timing::{Jump, TimeProfile};
