//! Memory and air at the start of a part of a recording, from the motion that was measured before it.

use super::base::BaseForce;
use super::integrator::JointIntegrator;
use super::record::ResampledRecord;
use super::substep::{At, Substep};
use crate::effects::{Before, EffectScalar, MeasuredPoint, StepStart};

/// Time between two measured points before a part, s: that of the rows of a diagnosis. Memory that fades faster has forgotten
/// them at the part.
const STEP_S: f64 = 0.02;

impl ResampledRecord {
    /// What was measured up to a grid point; `None` if it is less than a step.
    pub(super) fn measured_before(&self, until: usize) -> Option<Before> {
        let stride = ((STEP_S / self.step_s).round() as usize).max(1);
        let first = until % stride;
        if until < stride {
            return None;
        }
        let [x, v, flexor, extensor] = &self.measured;
        let point = |k: usize| MeasuredPoint {
            displacement_mm: x[k],
            velocity_mm_s: v[k],
            pressures_kpa: [flexor[k], extensor[k]],
            force_mn: self.force_mn(k),
        };
        Some(Before {
            since_start_s: self.since_start_s + self.step_s * first as f64,
            step_s: self.step_s * stride as f64,
            points: (first..=until).step_by(stride).map(point).collect(),
        })
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
        for ((start_s, from), (_, to)) in before.timed().zip(before.timed().skip(1)) {
            (self.x, self.v) = (c(from.displacement_mm), c(from.velocity_mm_s));
            let middle_mn = 0.5 * (from.force_mn + to.force_mn);
            let step = Substep {
                start_s,
                grid_s: before.step_s,
                from: 0.0,
                to: 1.0,
                driving_mn: [from.force_mn, middle_mn, to.force_mn].map(c),
                start: StepStart {
                    displacement_mm: self.x,
                    velocity_mm_s: self.v,
                    driving_mn: c(from.force_mn),
                },
            };
            self.at_middle(&step);
            let air = force.sealed(self.air_g);
            let end = At { share: c(1.0), x: c(to.displacement_mm), v: c(to.velocity_mm_s) };
            self.remember(&air, &step, &end, before.step_s);
        }
        [self.x, self.v] = start;
    }
}
