use super::forcing::{ForcingSegment, ForcingSegments};
use super::forward::{ExactStatistics, ForwardSolve, Segment};
use super::motion::{ExactMotion, MotionRegions, MotionWorkspace};
use super::problem::ExactProblem;
use pam_solvers::{FailureKind, TrajectoryFailure};

/// A solved trajectory with all its segments.
#[derive(Debug)]
pub(crate) struct StoredTrajectory<'n> {
    pub(crate) regions: MotionRegions<'n>,
    pub(crate) forcing: Vec<ForcingSegment>,
    pub(crate) segments: Vec<Segment>,
}

impl<'n> StoredTrajectory<'n> {
    /// Solves a problem and keeps all of it. A failure has the problem index 0.
    pub(crate) fn new(
        motion: &'n ExactMotion,
        problem: &ExactProblem<'_>,
    ) -> Result<Self, TrajectoryFailure> {
        let failed = |kind, time_s| TrajectoryFailure { problem: 0, kind, time_s };
        problem.check().map_err(|why| failed(FailureKind::Request(why), problem.t0))?;
        let mut cut = Vec::new();
        let forcing: Vec<_> = problem.forcing_segments(&mut cut).iter().collect();
        let all = ForcingSegments::of(&forcing);
        let nominal_s = all.nominal_length_s();
        let workspace = MotionWorkspace::default();
        let mut regions =
            MotionRegions::new(motion, problem.masses_g(), nominal_s, true, workspace);
        let mut segments = Vec::new();
        ForwardSolve {
            regions: &mut regions,
            forcing: all,
            start: problem.y0,
            segments: Some(&mut segments),
            observed: &mut vec![0.0; 2 * problem.observe_s.len()],
            statistics: &mut ExactStatistics::default(),
        }
        .run()
        .map_err(|stopped| failed(stopped.kind, stopped.time_s))?;
        Ok(Self { regions, forcing, segments })
    }
}
