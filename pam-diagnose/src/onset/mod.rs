//! Causes that begin, end or grow at a time.
//!
//! After a set of causes is found that are always there, every candidate is tried from every time on, and up to every time:
//!
//! 1. **Scan.** To first order, a candidate that begins at a time has the direction of the one that is always there, from that
//!    time on. Its score is the drop of the whitened squared residual; the largest score over all candidates and times is
//!    compared with what chance makes of it, by random signs of blocks of time, as the null test of the candidates is
//!    (the supremum of score statistics over an unknown time: Andrews 1993).
//! 2. **Fit.** The best candidates are fitted through the simulation with their times as parameters; the effect comes and goes
//!    by a smooth step ([`pam_vocabulary::course`]), so that derivatives by the times are exact.
//! 3. **Choice.** Sets compete by their posterior odds; a time costs its parameter and the number of times it was chosen from.
//!    Members are taken out, added, made constant or made to grow or end, as long as the odds rise.
//! 4. **Interval.** The 95 % interval of a time is that of the profile likelihood (`time_interval`): all that tells it lies
//!    within a fraction of a second, so a covariance over blocks does not know it.
//!
//! Recordings may share the time, or it comes once in their order, or each has its own: [`Pattern`]. What begins in the test data
//! only is reported by itself ([`LateFault`]).

mod cells;
mod draws;
mod each;
mod fits;
mod interval;
mod late;
mod scan;
mod scanned;
mod schedule;
mod search;
mod starts;
mod times;
mod variants;

pub(crate) use each::with_own_times;
pub(crate) use fits::moved_in_time;
pub(crate) use interval::time_interval;
pub use late::LateFault;
pub(crate) use late::late_fault;
pub use scan::OnsetTest;
pub use schedule::{Acts, Pattern, Schedule};
pub(crate) use search::{TimedSet, search};
pub use times::{RecordingTimes, Times};
