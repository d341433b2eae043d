//! A solution as an object: its state at any time, and its kinks.

use crate::fundamental::Response;
use crate::gradient::{ExactProblem, Follow};
use crate::motion::ExactMotion;
use pam_solvers::TrajectoryFailure;

/// One trajectory in closed form, exact at any time and not only where it is observed.
///
/// Within a segment the state is the propagator's at the time since the segment's start; nothing is
/// interpolated.
#[derive(Debug)]
pub struct ExactTrajectory<'n> {
    follow: Follow<'n>,
    /// Start of each segment, s.
    starts_s: Vec<f64>,
    span_s: [f64; 2],
    start: [f64; 2],
}

/// A unit of the network that changes its sign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// When, s.
    pub time_s: f64,
    /// Displacement (mm) and velocity (mm/s) there.
    pub state: [f64; 2],
    /// Hidden layer of the unit, from zero.
    pub layer: usize,
    /// The unit within its layer.
    pub unit: usize,
    /// Whether its argument becomes positive.
    pub rises: bool,
}

impl<'n> ExactTrajectory<'n> {
    /// Solves a problem and keeps all of it.
    ///
    /// # Errors
    /// [`TrajectoryFailure`] if the request is inconsistent or the solve stops early; its problem is 0.
    pub fn new(
        motion: &'n ExactMotion,
        problem: &ExactProblem<'_>,
    ) -> Result<Self, TrajectoryFailure> {
        let follow = Follow::new(motion, problem)?;
        let mut starts_s = Vec::with_capacity(follow.segments.len());
        let (mut piece, mut into_s) = (u32::MAX, 0.0);
        for s in &follow.segments {
            if s.piece != piece {
                (piece, into_s) = (s.piece, 0.0);
            }
            starts_s.push(follow.pieces[s.piece as usize].start_s + into_s);
            into_s += s.length_s;
        }
        Ok(Self { follow, starts_s, span_s: [problem.t0, problem.t1], start: problem.y0 })
    }

    /// Start and end, s.
    #[must_use]
    pub fn span_s(&self) -> [f64; 2] {
        self.span_s
    }

    /// Displacement (mm), velocity (mm/s) and acceleration (mm/s²) at a time; `None` outside of start and
    /// end. Where the force jumps the acceleration is that after the jump.
    #[must_use]
    pub fn at(&self, time_s: f64) -> Option<[f64; 3]> {
        if !(time_s >= self.span_s[0] && time_s <= self.span_s[1]) {
            return None;
        }
        let index = self.starts_s.partition_point(|&s| s <= time_s).checked_sub(1);
        let Some(index) = index else {
            return Some([self.start[0], self.start[1], f64::NAN]);
        };
        let follow = &self.follow;
        let segment = &follow.segments[index];
        let law = &follow.laws.laws[segment.pattern as usize];
        let inverse_mass = 1.0 / follow.laws.motion.mass_kg;
        let rate = follow.pieces[segment.piece as usize].rate_mn_s * inverse_mass;
        let forcing = (segment.force_mn - law.offset_mn) * inverse_mass;
        let h = time_s - self.starts_s[index];
        let state = [segment.x, segment.v];
        let response = Response::new(law.kappa, law.zeta, h, law.terms_of(h));
        let end = response.advance(law.kappa, state, [forcing, rate]);
        Some([end[0], end[1], law.acceleration(end, rate.mul_add(h, forcing))])
    }

    /// All changes of sign in the order of time. Units that change at the same instant have the same time;
    /// one that changes twice at an instant is left out.
    #[must_use]
    pub fn crossings(&self) -> Vec<Crossing> {
        let follow = &self.follow;
        let layers = &follow.laws.motion.network.hidden;
        let mut out = Vec::new();
        for (pair, &time_s) in follow.segments.windows(2).zip(&self.starts_s[1..]) {
            let [before, after] = [&pair[0], &pair[1]];
            if before.pattern == after.pattern {
                continue;
            }
            let bits = |pattern: u32| follow.laws.atlas.bits(pattern);
            let words = bits(before.pattern).iter().zip(bits(after.pattern));
            for (word, (before, now)) in words.enumerate() {
                let mut changed = before ^ now;
                while changed != 0 {
                    let bit = changed.trailing_zeros() as usize;
                    changed &= changed - 1;
                    let (mut layer, mut unit) = (0, 64 * word + bit);
                    while unit >= layers[layer].stride {
                        unit -= layers[layer].stride;
                        layer += 1;
                    }
                    let rises = (now >> bit) & 1 == 1;
                    let state = [after.x, after.v];
                    out.push(Crossing { time_s, state, layer, unit, rises });
                }
            }
        }
        out
    }
}
