//! Desired motions and stiffnesses over time.
//!
//! A [`Motion`] gives displacement, velocity and acceleration at any time; a [`StiffnessProfile`] the
//! stiffness. Both can be written in words ([`MotionSpec`], [`StiffnessProfile::parse`]):
//!
//! | text | motion |
//! |---|---|
//! | `sine:A=1,f=0.1` | `x = x0 + A sin(2π f t)` |
//! | `triangle:A=1,f=0.1` | the same turning points, straight lines between them |
//! | `minimum-jerk:from=0,to=1,T=0.5` | one reach (Flash and Hogan 1985), then rest |
//! | `hold:x=0.5` | rest |
//! | `FILE.csv` | columns `time_s, displacement_mm`, see [`table`] |
//!
//! Every built-in motion takes `x0` (mm), about which it moves, and `duration` (s).

mod minimum_jerk;
mod periodic;
mod spec;
mod stiffness;
pub mod table;

pub use minimum_jerk::MinimumJerk;
pub use periodic::{Hold, Sine, Triangle};
pub use spec::MotionSpec;
pub use stiffness::StiffnessProfile;

/// A point of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionPoint {
    /// Displacement x, mm.
    pub displacement_mm: f64,
    /// Velocity ẋ, mm/s.
    pub velocity_mm_s: f64,
    /// Acceleration ẍ, mm/s².
    pub acceleration_mm_s2: f64,
}

/// A desired motion.
pub trait Motion {
    /// Where the joint shall be at a time (s).
    fn at(&self, time_s: f64) -> MotionPoint;
}
