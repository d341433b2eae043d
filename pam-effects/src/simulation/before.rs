//! What happened before a part of a recording: effects remember it.

use super::base::BaseForce;
use super::integrator::JointIntegrator;
use super::record::ResampledRecord;
use super::substep::{At, Substep};
use crate::effects::{EffectScalar, StepStart};

/// Time between two measured points before a part, s: that of the rows of a diagnosis. Memory that fades faster has forgotten
/// them at the part.
const STEP_S: f64 = 0.02;

/// The measured motion of a recording before a part of it, at equal distances, up to its first point.
#[derive(Debug, Clone, PartialEq)]
pub struct Before {
    /// Time from the start of the excitation to the first point, s.
    since_start_s: f64,
    step_s: f64,
    /// Displacement (mm), velocity (mm/s) and recorded force of the drive (mN).
    points: Vec<[f64; 3]>,
}

impl Before {
    /// The motion of a recording up to a grid point; `None` if it is less than a step.
    pub(super) fn of(record: &ResampledRecord, until: usize) -> Option<Self> {
        let stride = ((STEP_S / record.step_s).round() as usize).max(1);
        let first = until % stride;
        if until < stride {
            return None;
        }
        let [x, v, ..] = &record.measured;
        let own = (first..=until).step_by(stride).map(|k| [x[k], v[k], record.force_mn(k)]);
        Some(Self {
            since_start_s: record.since_start_s + record.step_s * first as f64,
            step_s: record.step_s * stride as f64,
            points: own.collect(),
        })
    }

    /// Displacement at the first point, mm.
    pub(super) fn start_mm(&self) -> f64 {
        self.points[0][0]
    }
}

impl<S: EffectScalar, F: BaseForce<S>> JointIntegrator<'_, S, F> {
    /// Moves air and memory along what was measured before the first point of a part.
    pub(super) fn remember_before(&mut self) {
        let Some(before) = self.record.before.as_deref().filter(|_| self.has_memory()) else {
            return;
        };
        let c = S::constant;
        let (start, force) = ([self.x, self.v], self.force);
        for (k, pair) in before.points.windows(2).enumerate() {
            let [x, v, force_mn] = pair[0];
            let [to_x, to_v, to_mn] = pair[1];
            (self.x, self.v) = (c(x), c(v));
            let step = Substep {
                start_s: before.since_start_s + before.step_s * k as f64,
                grid_s: before.step_s,
                from: 0.0,
                to: 1.0,
                driving_mn: [c(force_mn), c(0.5 * (force_mn + to_mn)), c(to_mn)],
                start: StepStart {
                    displacement_mm: self.x,
                    velocity_mm_s: self.v,
                    driving_mn: c(force_mn),
                },
            };
            self.at_middle(&step);
            let air = force.sealed(self.air_g);
            let end = At { share: c(1.0), x: c(to_x), v: c(to_v) };
            self.remember(&air, &step, &end, before.step_s);
        }
        [self.x, self.v] = start;
    }
}
