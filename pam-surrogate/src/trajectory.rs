//! One trajectory on its surface: steps forward, cotangents backward.
//!
//! Within a step from (x₀, v₀) the motion is split into the impulse of the force and the rest,
//!
//! ```text
//! x = w + β Z(τ)     Z = ∫∫ F dτ²      ẇ = u
//! v = u + β Ż(τ)     Ż = ∫ F dτ        u̇ = −β (f(x, v) + B v),   β = 1/m
//! ```
//!
//! and (w, u) take a Runge–Kutta step. The derivative at the end of a step is that at the start of the next one. Steps are
//! controlled by the embedded method and end at observations, or between two that are far apart. The backward pass is the
//! exact transpose of the steps, for the steps that were taken.

use crate::forcing::{Line, StepForcing};
use crate::method::{Method, STAGES};
use crate::nodes::NodeForce;
use crate::surface::{Surface, SurfaceWorkspace, TooRough};
use pam_core::JointModel;
use pulp::Simd;

/// The joint but for its learned force.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mechanics {
    /// 1/m, 1/kg.
    pub(crate) per_mass: f64,
    /// B, kg/s.
    pub(crate) damping_kg_s: f64,
    /// |x| at which the motion is given up, mm.
    pub(crate) limit_mm: f64,
}

impl Mechanics {
    /// Those of a joint.
    pub(crate) fn of<F>(model: &JointModel<f64, F>) -> Self {
        let physical = model.physical();
        Self {
            per_mass: physical.mass_kg.recip(),
            damping_kg_s: model.auxiliary_damping_kg_s,
            limit_mm: model.geometry.displacement_limit_mm(physical.deformation),
        }
    }
}

/// Control of the steps.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Control {
    /// Largest estimated error of a step, mm and (times [`RATE_PER_S`]) mm/s.
    pub(crate) error_mm: f64,
    /// Longest step, s.
    pub(crate) longest_s: f64,
    /// Most steps of a trajectory.
    pub(crate) most_steps: usize,
}

/// Velocity errors are weighed against displacement errors by the rate (1/s) at which a joint like the published one
/// responds: √(150 N/mm / 250 kg).
const RATE_PER_S: f64 = 25.0;
/// Bounds of the change of a step, and the share of the tolerance that is aimed at.
const LEAST_FACTOR: f64 = 0.2;
const MOST_FACTOR: f64 = 3.0;
const AIM: f64 = 0.8;
/// Shortest step relative to the longest one.
const SHORTEST: f64 = 1e-7;
/// Relative slack by which steps may be longer in order to end at an observation.
const SLACK: f64 = 1e-3;

/// A step that was taken.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Step {
    start_s: f64,
    length_s: f64,
    state: [f64; 2],
    /// u̇ at the stages.
    rates: [f64; STAGES],
    line: usize,
    /// First observation within the step, and their number.
    observed: usize,
    count: usize,
}

/// Why a trajectory stopped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Stop {
    Rough { time_s: f64 },
    NonFinite { time_s: f64, step_s: f64 },
    StepTooSmall { time_s: f64, step_s: f64 },
    TooManySteps { time_s: f64 },
}

/// Where a trajectory starts and ends, and when it is observed: after its start.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Course<'a> {
    pub(crate) start_s: f64,
    pub(crate) end_s: f64,
    pub(crate) state: [f64; 2],
    pub(crate) observe_s: &'a [f64],
}

/// Derivatives of a loss but for those by the surface.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct MotionSums {
    pub(crate) start: [f64; 2],
    pub(crate) per_mass: f64,
    pub(crate) damping: f64,
}

/// Slopes of the force at a point, and the patch there.
#[derive(Debug, Clone, Copy, Default)]
struct Slopes {
    patch: usize,
    by_x: f64,
    by_v: f64,
}

/// A trajectory at work.
pub(crate) struct Motion<'m, 's, 'a> {
    pub(crate) method: &'m Method,
    pub(crate) mechanics: Mechanics,
    pub(crate) lines: &'m [Line],
    pub(crate) surface: &'s mut Surface<'a>,
    pub(crate) memory: &'s mut SurfaceWorkspace,
    pub(crate) force: &'s mut dyn NodeForce,
    pub(crate) forcing: &'s mut StepForcing,
    /// The patch in use.
    pub(crate) patch: usize,
}

// Sums over stages read best by their indices.
#[allow(clippy::needless_range_loop)]
impl Motion<'_, '_, '_> {
    /// Makes the patch at a point the one in use.
    #[inline(always)]
    fn enter(&mut self, at: [f64; 2]) -> Result<(), TooRough> {
        let inside = self.surface.patches.get(self.patch).is_some_and(|p| p.contains(at));
        if !inside {
            self.patch = self.surface.patch_at(at, self.memory, self.force)?;
        }
        Ok(())
    }

    #[inline(always)]
    fn rate<S: Simd>(&mut self, simd: S, at: [f64; 2]) -> Result<f64, TooRough> {
        self.enter(at)?;
        let force = self.surface.patches[self.patch].force_mn(simd, at);
        Ok(-self.mechanics.per_mass * (force + self.mechanics.damping_kg_s * at[1]))
    }

    /// Solves from start to end. Writes the state at each observation, keeps the steps, and counts rejected ones.
    #[inline(always)]
    pub(crate) fn forward<S: Simd>(
        &mut self,
        simd: S,
        course: &Course<'_>,
        control: &Control,
        states: &mut [[f64; 2]],
        steps: &mut Vec<Step>,
        rejected: &mut usize,
    ) -> Result<(), Stop> {
        steps.clear();
        let Course { start_s, end_s, observe_s, .. } = *course;
        let beta = self.mechanics.per_mass;
        let method = self.method;
        let (mut t, mut state) = (start_s, course.state);
        let (mut next, mut line) = (0, 0);
        let mut aimed_s = 0.25 * control.longest_s;
        let rough = |t: f64| move |_: TooRough| Stop::Rough { time_s: t };
        let mut first_rate = self.rate(simd, state).map_err(rough(t))?;
        while t < end_s {
            if steps.len() >= control.most_steps {
                return Err(Stop::TooManySteps { time_s: t });
            }
            while line + 1 < self.lines.len() && self.lines[line + 1].start_s() <= t {
                line += 1;
            }
            // To the last observation that is near enough, or a part of the way to the next one.
            let within = t + aimed_s * (1.0 + SLACK);
            let mut count = 0;
            while observe_s.get(next + count).is_some_and(|&o| o <= within) {
                count += 1;
            }
            let stop = if count > 0 {
                observe_s[next + count - 1]
            } else {
                observe_s.get(next).copied().unwrap_or(end_s)
            };
            let parts = ((stop - t) / aimed_s - SLACK).ceil().max(1.0);
            let whole = parts <= 1.0;
            let h = (stop - t) / parts;
            let end = if whole { stop } else { t + h };
            if count == 0 && whole {
                count = usize::from(next < observe_s.len());
            } else if !whole {
                count = 0;
            }
            if h < SHORTEST * control.longest_s {
                return Err(Stop::StepTooSmall { time_s: t, step_s: h });
            }
            self.forcing.take(self.lines, line, t, end);
            let mut rates = [0.0; STAGES + 1];
            let mut velocities = [0.0; STAGES + 1];
            (rates[0], velocities[0]) = (first_rate, state[1]);
            for i in 1..STAGES {
                let (mut w, mut u) = (0.0, 0.0);
                for j in 0..i {
                    w += method.a[i][j] * velocities[j];
                    u += method.a[i][j] * rates[j];
                }
                let (w, u) = (state[0] + h * w, state[1] + h * u);
                let [impulse, double] = self.forcing.integrals(method.c[i] * h);
                velocities[i] = u;
                rates[i] =
                    self.rate(simd, [w + beta * double, u + beta * impulse]).map_err(rough(t))?;
            }
            let (mut w, mut u) = (0.0, 0.0);
            for i in 0..STAGES {
                w += method.b[i] * velocities[i];
                u += method.b[i] * rates[i];
            }
            let (w, u) = (state[0] + h * w, state[1] + h * u);
            let [impulse, double] = self.forcing.integrals(h);
            let ahead = [w + beta * double, u + beta * impulse];
            if !(ahead[0].abs() < self.mechanics.limit_mm && ahead[1].is_finite()) {
                if h > 1e3 * SHORTEST * control.longest_s && !ahead[1].is_finite() {
                    aimed_s = 0.25 * h;
                    *rejected += 1;
                    continue;
                }
                return Err(Stop::NonFinite { time_s: t, step_s: h });
            }
            velocities[STAGES] = u;
            rates[STAGES] = self.rate(simd, ahead).map_err(rough(t))?;
            let (mut error_w, mut error_u) = (0.0, 0.0);
            for i in 0..=STAGES {
                error_w += method.error[i] * velocities[i];
                error_u += method.error[i] * rates[i];
            }
            let error = (h * error_w).abs().max((h * error_u).abs() / RATE_PER_S);
            let factor = AIM * (control.error_mm / error.max(f64::MIN_POSITIVE)).powf(0.2);
            let proposed = h * factor.clamp(LEAST_FACTOR, MOST_FACTOR);
            if error.is_nan() || error > control.error_mm {
                *rejected += 1;
                aimed_s =
                    if proposed.is_finite() { proposed.min(0.9 * h) } else { LEAST_FACTOR * h };
                continue;
            }
            aimed_s = proposed.min(control.longest_s);
            for k in next..next + count {
                let at = observe_s[k] - t;
                states[k] = if k + 1 == next + count && whole {
                    ahead
                } else {
                    let weights = method.weights(at / h);
                    let (mut w, mut u) = (0.0, 0.0);
                    for i in 0..=STAGES {
                        w += weights[i] * velocities[i];
                        u += weights[i] * rates[i];
                    }
                    let [impulse, double] = self.forcing.integrals(at);
                    [state[0] + h * w + beta * double, state[1] + h * u + beta * impulse]
                };
            }
            let kept: [f64; STAGES] = std::array::from_fn(|i| rates[i]);
            steps.push(Step {
                start_s: t,
                length_s: h,
                state,
                rates: kept,
                line,
                observed: next,
                count,
            });
            first_rate = rates[STAGES];
            next += count;
            (t, state) = (end, ahead);
        }
        // The rate at the very end is that of a further stage.
        steps.push(Step {
            start_s: t,
            length_s: 0.0,
            state,
            rates: [first_rate; STAGES],
            line,
            observed: next,
            count: 0,
        });
        Ok(())
    }

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

    /// The derivatives of a loss with these cotangents of the observed states.
    #[inline(always)]
    pub(crate) fn backward<S: Simd>(
        &mut self,
        simd: S,
        course: &Course<'_>,
        steps: &[Step],
        cotangents: &[[f64; 2]],
    ) -> Result<MotionSums, TooRough> {
        let beta = self.mechanics.per_mass;
        let method = self.method;
        let mut sums = MotionSums::default();
        // Cotangents of the state at the end of the step at work, and of the rate there.
        let mut state = [0.0; 2];
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
                let since = course.observe_s[k] - step.start_s;
                if k + 1 == step.observed + step.count && course.observe_s[k] == after.start_s {
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
                &mut sums,
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
                    self.pull_rate(simd, at[i], slopes[i], step.rates[i], of_rate[i], &mut sums);
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
            let [x, v] =
                self.pull_rate(simd, first.state, slopes, first.rates[0], end_rate, &mut sums);
            state[0] += x;
            state[1] += v;
        }
        sums.start = state;
        Ok(sums)
    }
}
