//! From a raw log to a recording, as the published loader does it.
//!
//! 1. The excitation starts at the first sample at or after row 2000 where |gradient(u)| > 0.01.
//! 2. The means over the 100 samples before are the sealed reading.
//! 3. From there on: time = (frame − frame₀)/1000, x = −deg2rad(angle) · 6.875 mm,
//!    F_e = −current · 25.5 · 36 / 6.875e-3 mN; x, F_e and the pressures are filtered forward and
//!    back by a first-order 20 Hz Butterworth; P = psi · 6.89476 + 101.325 kPa; ẋ is the
//!    central-difference gradient of the filtered x.
//!
//! Every constant is an option ([`RawLogOptions`]). Gaps in the frame counter split the recording
//! before filtering, so that no filter runs across a gap.

mod channels;
mod gradient;
mod low_pass;
mod options;
mod raw;

pub use channels::{Cutoffs, derivative_of, filtered, low_passed, refilter};
pub use gradient::{gradient, gradient_at_times};
pub use low_pass::LowPass;
pub use options::RawLogOptions;
pub use raw::recordings_from_raw_log;
