//! Runge–Kutta steps forward.

use crate::method::STAGES;
use crate::surface::TooRough;
use crate::trajectory::{Control, Motion, Span, Step, Stop};
use pulp::Simd;

/// Velocity errors are weighed against displacement errors by the rate (1/s) at which a joint like the published one
/// responds: √(150 N/mm / 250 kg).
pub(crate) const RATE_PER_S: f64 = 25.0;
/// Bounds of the change of a step, and the share of the tolerance that is aimed at.
const LEAST_FACTOR: f64 = 0.2;
const MOST_FACTOR: f64 = 3.0;
const AIM: f64 = 0.8;
/// Shortest step relative to the longest one.
const SHORTEST: f64 = 1e-7;
/// Relative slack by which steps may be longer in order to end at an observation.
const SLACK: f64 = 1e-3;

/// State of a solve between segments.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Progress {
    pub(crate) time_s: f64,
    pub(crate) state: [f64; 2],
    /// Length of the next step, s.
    pub(crate) aimed_s: f64,
    /// The next observation.
    pub(crate) next: usize,
    /// The observation after the last one to reach.
    pub(crate) until: usize,
    /// Steps that were rejected.
    pub(crate) rejected: usize,
}

// Sums over stages read best by their indices.
#[allow(clippy::needless_range_loop)]
impl Motion<'_, '_, '_> {
    /// Takes steps from a state up to an observation, or to the end if there is none left. Writes the state at each
    /// observation, adds the steps and at last one without length, and counts rejected ones.
    #[inline(always)]
    pub(crate) fn forward<S: Simd>(
        &mut self,
        simd: S,
        span: &Span<'_>,
        progress: &mut Progress,
        control: &Control,
        states: &mut [[f64; 2]],
        steps: &mut Vec<Step>,
    ) -> Result<(), Stop> {
        let beta = self.mechanics.per_mass;
        let method = self.method;
        let Progress { mut time_s, mut state, mut aimed_s, mut next, until, .. } = *progress;
        let observe_s = &span.observe_s[..until];
        let end_s = if until < span.observe_s.len() { observe_s[until - 1] } else { span.end_s };
        let mut line = self.lines.partition_point(|l| l.start_s() <= time_s).saturating_sub(1);
        let rough = |t: f64| move |_: TooRough| Stop::Rough { time_s: t };
        let mut first_rate = self.rate(simd, state).map_err(rough(time_s))?;
        while time_s < end_s {
            let t = time_s;
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
                    progress.rejected += 1;
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
                progress.rejected += 1;
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
            (time_s, state) = (end, ahead);
        }
        // The rate at the very end is that of a further stage.
        steps.push(Step {
            start_s: time_s,
            length_s: 0.0,
            state,
            rates: [first_rate; STAGES],
            line,
            observed: next,
            count: 0,
        });
        (progress.time_s, progress.state) = (time_s, state);
        (progress.aimed_s, progress.next) = (aimed_s, next);
        Ok(())
    }
}
