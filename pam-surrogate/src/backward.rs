//! Runge–Kutta steps backward: their transpose.

use crate::method::STAGES;
use crate::surface::TooRough;
use crate::trajectory::{Mechanics, Motion, MotionSums, Span, Step};
use pulp::Simd;

/// Slopes of the force at a point, and the patch there.
#[derive(Debug, Clone, Copy, Default)]
struct Slopes {
    patch: usize,
    by_x: f64,
    by_v: f64,
}

// Sums over stages read best by their indices.
#[allow(clippy::needless_range_loop)]
impl Motion<'_, '_, '_> {
    /// The patch at a point, and the slopes of the force there by x (mN/mm) and ẋ (kg/s).
    #[inline(always)]
    fn slopes<S: Simd>(&mut self, simd: S, at: [f64; 2]) -> Result<Slopes, TooRough> {
        self.enter(at)?;
        let [_, by_x, by_v] = self.surface.patches[self.patch].force_and_slopes(simd, at);
        Ok(Slopes { patch: self.patch, by_x, by_v })
    }

    /// Pulls a cotangent of the rate u̇ at a point back: to the state, to the surface, and to the sums.
    #[inline(always)]
    fn pull_rate<S: Simd>(
        &mut self,
        simd: S,
        at: [f64; 2],
        slopes: Slopes,
        rate: f64,
        cotangent: f64,
        sums: &mut MotionSums,
    ) -> [f64; 2] {
        let Mechanics { per_mass, damping_kg_s, .. } = self.mechanics;
        let of_force = -per_mass * cotangent;
        self.surface.patches[slopes.patch].accumulate(simd, at, of_force);
        sums.damping += of_force * at[1];
        sums.per_mass += cotangent * rate / per_mass;
        [of_force * slopes.by_x, of_force * (slopes.by_v + damping_kg_s)]
    }

    /// Pulls cotangents back over steps that follow each other. `state` is the cotangent of the state at their end, without what
    /// is observed there; the result that of the state at their start.
    #[inline(always)]
    pub(crate) fn backward<S: Simd>(
        &mut self,
        simd: S,
        span: &Span<'_>,
        steps: &[Step],
        cotangents: &[[f64; 2]],
        mut state: [f64; 2],
        sums: &mut MotionSums,
    ) -> Result<[f64; 2], TooRough> {
        let beta = self.mechanics.per_mass;
        let method = self.method;
        // Cotangent of the rate at the end of the step at work.
        let mut end_rate = 0.0;
        for pair in steps.windows(2).rev() {
            let (step, after) = (&pair[0], &pair[1]);
            let h = step.length_s;
            self.forcing.take(self.lines, step.line, step.start_s, step.start_s + h);
            // Stages again.
            let mut at = [[0.0; 2]; STAGES];
            let mut integrals = [[0.0; 2]; STAGES];
            let mut velocities = [0.0; STAGES];
            at[0] = step.state;
            velocities[0] = step.state[1];
            for i in 1..STAGES {
                let (mut w, mut u) = (0.0, 0.0);
                for j in 0..i {
                    w += method.a[i][j] * velocities[j];
                    u += method.a[i][j] * step.rates[j];
                }
                let (w, u) = (step.state[0] + h * w, step.state[1] + h * u);
                let [impulse, double] = self.forcing.integrals(method.c[i] * h);
                integrals[i] = [impulse, double];
                velocities[i] = u;
                at[i] = [w + beta * double, u + beta * impulse];
            }
            // They do not depend on each other, nor on the cotangents: worked out at once.
            let mut slopes = [Slopes::default(); STAGES + 1];
            for i in 1..STAGES {
                slopes[i] = self.slopes(simd, at[i])?;
            }
            slopes[STAGES] = self.slopes(simd, after.state)?;
            let mut of_rate = [0.0; STAGES + 1];
            let mut of_velocity = [0.0; STAGES + 1];
            // Cotangent of the state at the start of the step.
            let mut before = [0.0; 2];
            of_rate[STAGES] = end_rate;
            for k in step.observed..step.observed + step.count {
                let [x, v] = cotangents[k];
                let since = span.observe_s[k] - step.start_s;
                if k + 1 == step.observed + step.count && span.observe_s[k] == after.start_s {
                    state[0] += x;
                    state[1] += v;
                    continue;
                }
                let weights = method.weights(since / h);
                for i in 0..=STAGES {
                    of_velocity[i] += h * weights[i] * x;
                    of_rate[i] += h * weights[i] * v;
                }
                before[0] += x;
                before[1] += v;
                let [impulse, double] = self.forcing.integrals(since);
                sums.per_mass += double * x + impulse * v;
            }
            // The stage at the end, at the state there.
            let [x, v] = self.pull_rate(
                simd,
                after.state,
                slopes[STAGES],
                after.rates[0],
                of_rate[STAGES],
                sums,
            );
            state[0] += x;
            state[1] += v;
            let [impulse, double] = self.forcing.integrals(h);
            sums.per_mass += double * state[0] + impulse * state[1];
            // The velocity of the end stage is u there.
            let of_u = state[1] + of_velocity[STAGES];
            before[0] += state[0];
            before[1] += of_u;
            for i in 0..STAGES {
                of_velocity[i] += h * method.b[i] * state[0];
                of_rate[i] += h * method.b[i] * of_u;
            }
            for i in (1..STAGES).rev() {
                let [x, v] =
                    self.pull_rate(simd, at[i], slopes[i], step.rates[i], of_rate[i], sums);
                let [impulse, double] = integrals[i];
                sums.per_mass += double * x + impulse * v;
                let of_u = v + of_velocity[i];
                before[0] += x;
                before[1] += of_u;
                for j in 0..i {
                    of_velocity[j] += h * method.a[i][j] * x;
                    of_rate[j] += h * method.a[i][j] * of_u;
                }
            }
            before[1] += of_velocity[0];
            (state, end_rate) = (before, of_rate[0]);
        }
        if let Some(first) = steps.first() {
            let slopes = self.slopes(simd, first.state)?;
            let [x, v] = self.pull_rate(simd, first.state, slopes, first.rates[0], end_rate, sums);
            state[0] += x;
            state[1] += v;
        }
        Ok(state)
    }
}
