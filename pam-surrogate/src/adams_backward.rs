//! Adams steps backward: their transpose.

use crate::adams::{HISTORY, RATES, Weights};
use crate::adams_forward::{AdamsSegment, CHUNK, Points};
use crate::samples::SampleForcing;
use crate::surface::TooRough;
use crate::trajectory::{Motion, MotionSums};
use pulp::Simd;

/// Memory for cotangents along the steps.
#[derive(Debug, Default)]
pub(crate) struct Cotangents {
    /// Of rates, by what lies between grid points.
    rates: Vec<f64>,
    /// Of the states before the rate is added, times the squared step and the step.
    ahead: [Vec<f64>; 2],
    /// Of a sample within each step, times the same.
    within: [Vec<f64>; 2],
}

impl Motion<'_, '_, '_> {
    /// Pulls cotangents back through Adams steps. `state` is the cotangent of the state at the last point, without the part of
    /// the observation there. Returns the cotangent of the state at the last point of the history, also without its
    /// observation. Cotangents of the other points of the history are added to those of the observed states, or of the start.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    pub(crate) fn adams_backward<S: Simd>(
        &mut self,
        simd: S,
        samples: &SampleForcing,
        segment: &AdamsSegment,
        points: &Points,
        observed: &mut [[f64; 2]],
        memory: &mut Cotangents,
        state: [f64; 2],
        sums: &mut MotionSums,
    ) -> Result<[f64; 2], TooRough> {
        let (q, adams) = (segment.intervals, self.adams);
        let h = samples.interval_s * q as f64;
        let weights = &adams.end;
        let (h_x, h_v) = (h * h * weights.displacement[0], h * weights.velocity[0]);
        let base = segment.points.start;
        let count = segment.points.len();
        // Zeros after the end: the last points have fewer steps after them.
        let len = count + RATES + CHUNK;
        memory.between(segment, samples, len, observed);
        let Cotangents { rates, ahead: [ahead_x, ahead_v], .. } = memory;
        for values in [&mut *ahead_x, &mut *ahead_v] {
            values.clear();
            values.resize(len, 0.0);
        }
        let [mut x, mut v] = state;
        for k in (HISTORY..count).rev() {
            let point = base + k;
            let sample = segment.sample(point);
            let [seen_x, seen_v] = observed[sample - 1];
            x += seen_x;
            v += seen_v;
            let (by_x, by_v) = (points.by_x[point], points.by_v[point]);
            let inverse = 1.0 / (1.0 - by_x * h_x - by_v * h_v);
            let of_rate = rates[k] + by_later_steps(weights, [ahead_x, ahead_v], k);
            let of_rate = (of_rate + h_x * x + h_v * v) * inverse;
            self.pull_point(simd, samples, points, point, sample, of_rate, sums)?;
            x += of_rate * by_x;
            v += of_rate * by_v;
            ahead_x[k] = h * h * x;
            ahead_v[k] = h * v;
            let before = sample - q;
            let [impulse, double] = samples.over(before, q);
            sums.per_mass += double * x + impulse * v;
            v += h * x;
            let (mut impulse, mut double) = (0.0, 0.0);
            for j in 1..q {
                double += samples.interval_s * impulse + samples.double[before + j - 1];
                impulse += samples.impulse[before + j - 1];
                let [seen_x, seen_v] = observed[before + j - 1];
                sums.per_mass += double * seen_x + impulse * seen_v;
                x += seen_x;
                v += seen_v + samples.interval_s * j as f64 * seen_x;
            }
        }
        for k in (0..HISTORY).rev() {
            let point = base + k;
            let sample = segment.sample(point);
            let of_rate = rates[k] + by_later_steps(weights, [ahead_x, ahead_v], k);
            self.pull_point(simd, samples, points, point, sample, of_rate, sums)?;
            let of_state = [of_rate * points.by_x[point], of_rate * points.by_v[point]];
            let to = if k + 1 == HISTORY {
                x += of_state[0];
                v += of_state[1];
                continue;
            } else if sample == 0 {
                &mut sums.start
            } else {
                &mut observed[sample - 1]
            };
            to[0] += of_state[0];
            to[1] += of_state[1];
        }
        Ok([x, v])
    }

    /// Pulls the cotangent of the rate at a grid point back to the surface and to the sums.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    fn pull_point<S: Simd>(
        &mut self,
        simd: S,
        samples: &SampleForcing,
        points: &Points,
        point: usize,
        sample: usize,
        cotangent: f64,
        sums: &mut MotionSums,
    ) -> Result<(), TooRough> {
        let beta = self.mechanics.per_mass;
        let excess = samples.excess[sample];
        let at = [points.x[point], points.v[point] + beta * excess];
        let of_force = -beta * cotangent;
        self.enter(at)?;
        self.surface.patches[self.patch].accumulate(simd, at, of_force);
        sums.damping += of_force * at[1];
        sums.per_mass += cotangent * (points.rate[point] / beta + points.by_v[point] * excess);
        Ok(())
    }
}

/// Cotangent of the rate at a point from the steps after it. A closure would be compiled without vector instructions.
#[inline(always)]
fn by_later_steps(weights: &Weights, of: [&[f64]; 2], point: usize) -> f64 {
    let of_x = of[0][point..].first_chunk::<RATES>().expect("zeros at the end");
    let of_v = of[1][point..].first_chunk::<RATES>().expect("zeros at the end");
    let (mut x, mut v) = (0.0, 0.0);
    for i in (1..RATES).rev() {
        x += weights.displacement[i] * of_x[i];
        v += weights.velocity[i] * of_v[i];
    }
    x + v
}

impl Cotangents {
    /// Cotangents of the rates by the samples between grid points.
    #[inline(always)]
    fn between(
        &mut self,
        segment: &AdamsSegment,
        samples: &SampleForcing,
        len: usize,
        observed: &[[f64; 2]],
    ) {
        let Self { rates, within: [within_x, within_v], .. } = self;
        rates.clear();
        rates.resize(len, 0.0);
        let h = samples.interval_s * segment.intervals as f64;
        let count = segment.points.len();
        for (j, weights) in segment.between() {
            for values in [&mut *within_x, &mut *within_v] {
                values.clear();
                values.resize(len, 0.0);
            }
            let first = segment.first_sample + (HISTORY - 1) * segment.intervals + j - 1;
            let seen = observed[first..].iter().step_by(segment.intervals);
            for (k, [x, v]) in (HISTORY..count).zip(seen) {
                within_x[k] = h * h * x;
                within_v[k] = h * v;
            }
            for first in (0..count).step_by(CHUNK) {
                let mut sums = [0.0; CHUNK];
                for i in 0..RATES {
                    let (by_x, by_v) = (weights.displacement[i], weights.velocity[i]);
                    let x = within_x[first + i..].first_chunk::<CHUNK>().expect("zeros at the end");
                    let v = within_v[first + i..].first_chunk::<CHUNK>().expect("zeros at the end");
                    for l in 0..CHUNK {
                        sums[l] += by_x * x[l] + by_v * v[l];
                    }
                }
                for (rate, sum) in rates[first..first + CHUNK].iter_mut().zip(&sums) {
                    *rate += sum;
                }
            }
        }
    }
}
