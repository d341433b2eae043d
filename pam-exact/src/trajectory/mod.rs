//! Trajectories: closed-form steps from forcing segment to forcing segment, cut where a unit changes sign.
//!
//! The force between two samples is a straight line, one *forcing segment*. Each is solved by steps within
//! linear regions; the state at the end of a region is the start in its neighbour. Several crossings at one
//! instant follow one another without time passing.
//!
//! | file | holds |
//! |---|---|
//! | `motion` | the equation of motion, and the coefficients of all regions met |
//! | `problem` | the request: masses, force, span, initial state, observation times |
//! | `forcing` | the sampled force cut into segments |
//! | `forward` | the forward solve |
//! | `stored` | a solve that keeps all segments |
//! | `dense` | the solution at any time, and its crossings |

mod dense;
pub(crate) mod forcing;
pub(crate) mod forward;
pub(crate) mod motion;
mod problem;
pub(crate) mod stored;

pub use dense::{Crossing, ExactTrajectory};
pub use forward::ExactStatistics;
pub use motion::ExactMotion;
pub use pam_solvers::ForceSignal;
pub use problem::ExactProblem;
