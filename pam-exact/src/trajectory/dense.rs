//! A solution at any time, and its crossings.

use super::motion::ExactMotion;
use super::problem::ExactProblem;
use super::stored::StoredTrajectory;
use crate::step::propagator::Propagator;
use pam_solvers::TrajectoryFailure;

/// One trajectory in closed form, exact at any time and not only at the observations.
///
/// The state within a segment is the propagator's at the time since the segment's start; nothing is
/// interpolated.
#[derive(Debug)]
pub struct ExactTrajectory<'n> {
    stored: StoredTrajectory<'n>,
    /// Start of each segment, s.
    starts_s: Vec<f64>,
    t0: f64,
    t1: f64,
    y0: [f64; 2],
}

/// A sign change of a hidden unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Time, s.
    pub time_s: f64,
    /// Displacement (mm) and velocity (mm/s) there.
    pub state: [f64; 2],
    /// Hidden layer of the unit, from zero.
    pub layer: usize,
    /// The unit within its layer.
    pub unit: usize,
    /// True if the unit becomes active.
    pub activates: bool,
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
        let stored = StoredTrajectory::new(motion, problem)?;
        let mut starts_s = Vec::with_capacity(stored.segments.len());
        let (mut forcing, mut into_s) = (u32::MAX, 0.0);
        for s in &stored.segments {
            if s.forcing != forcing {
                (forcing, into_s) = (s.forcing, 0.0);
            }
            starts_s.push(stored.forcing[s.forcing as usize].start_s + into_s);
            into_s += s.length_s;
        }
        let ExactProblem { t0, t1, y0, .. } = *problem;
        Ok(Self { stored, starts_s, t0, t1, y0 })
    }

    /// Displacement (mm), velocity (mm/s) and acceleration (mm/s²) at a time; `None` before the start and
    /// after the end. Where the force jumps, the acceleration is the one after the jump.
    #[must_use]
    pub fn at(&self, time_s: f64) -> Option<[f64; 3]> {
        if !(time_s >= self.t0 && time_s <= self.t1) {
            return None;
        }
        let index = self.starts_s.partition_point(|&s| s <= time_s).checked_sub(1);
        let Some(index) = index else {
            return Some([self.y0[0], self.y0[1], f64::NAN]);
        };
        let stored = &self.stored;
        let segment = &stored.segments[index];
        let coefficients = &stored.regions.coefficients[segment.region as usize];
        let inverse_mass = 1.0 / stored.regions.motion.mass_kg;
        let rate = stored.forcing[segment.forcing as usize].rate_mn_s * inverse_mass;
        let forcing = (segment.force_mn - coefficients.offset_mn) * inverse_mass;
        let h = time_s - self.starts_s[index];
        let oscillator = coefficients.oscillator;
        let propagator = Propagator::new(oscillator, h, coefficients.terms_of(h));
        let end = propagator.advance(oscillator.kappa, [segment.x, segment.v], [forcing, rate]);
        Some([end[0], end[1], oscillator.acceleration(end, rate.mul_add(h, forcing))])
    }

    /// All sign changes in order of time. Units that change at the same instant have the same time; one
    /// that changes twice at an instant is left out.
    #[must_use]
    pub fn crossings(&self) -> Vec<Crossing> {
        let stored = &self.stored;
        let network = &stored.regions.motion.network;
        let mut out = Vec::new();
        for (pair, &time_s) in stored.segments.windows(2).zip(&self.starts_s[1..]) {
            let [before, after] = [&pair[0], &pair[1]];
            if before.region == after.region {
                continue;
            }
            let patterns = [before, after].map(|s| stored.regions.cache.pattern(s.region));
            for (word, (before, now)) in patterns[0].iter().zip(patterns[1]).enumerate() {
                let mut changed = before ^ now;
                while changed != 0 {
                    let bit = changed.trailing_zeros() as usize;
                    changed &= changed - 1;
                    let unit = 64 * word + bit;
                    let layer = network.layer_of(unit);
                    out.push(Crossing {
                        time_s,
                        state: [after.x, after.v],
                        layer,
                        unit: unit - network.start(layer),
                        activates: (now >> bit) & 1 == 1,
                    });
                }
            }
        }
        out
    }
}
