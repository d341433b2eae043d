//! Stiffness and damping from the response to a pulse.
//!
//! With shut valves and M fixed, the response from the start of a pulse on is that of
//!
//! ```text
//! M (ẍ − ẍ0) + B (ẋ − ẋ0) + K (x − x0) = F_e
//! ```
//!
//! (Wang and Realmuto 2026, section IV-C), the joint's dynamics linearised about the state at the start. K
//! and B minimise the squared error of the displacement: a search over a coarse grid, a pattern search from
//! its best point, then Levenberg's and Marquardt's method with exact derivatives. Their covariance is the
//! sandwich with Bartlett weights over lags (Newey and West 1987), since residuals of neighbouring samples
//! are alike.
//!
//! ```
//! use pam_control::identification::{Response, identify, simulate};
//!
//! let force_n: Vec<f64> = (0..300).map(|k| if k < 150 { 90.0 } else { 0.0 }).collect();
//! let mut response = Response { mass_kg: 304.6, sample_s: 1e-3, force_n, ..Response::default() };
//! response.displacement_mm = simulate(&response, 150.0, 6500.0);
//! let found = identify(&response)?;
//! assert!((found.stiffness_n_mm - 150.0).abs() < 1e-6);
//! assert!((found.damping_kg_s - 6500.0).abs() < 1e-3);
//! # Ok::<(), pam_control::ControlError>(())
//! ```

mod fit;
mod recording;
mod response;
mod schedule;

pub use fit::{Estimate, identify};
pub use recording::pulses_in_recording;
pub use response::{Response, simulate};
pub use schedule::{cycling_pulses, staircase_pulses};
