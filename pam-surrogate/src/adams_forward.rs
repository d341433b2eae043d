//! Adams steps forward.
//!
//! Grid points are samples an equal number of intervals apart, so each step takes one evaluation of the force: at the state
//! that the extrapolated rate leads to. One Newton step with the slopes found there solves for the new rate; its remainder is
//! of the order of the squared error of the extrapolation.

use crate::adams::{HISTORY, RATES, Weights};
use crate::forward::RATE_PER_S;
use crate::samples::SampleForcing;
use crate::surface::TooRough;
use crate::trajectory::{Control, Motion};
use pulp::Simd;
use std::ops::Range;

/// Most intervals of a step.
pub(crate) const MOST_INTERVALS: usize = 8;
/// Share of the difference of both orders that is taken for the error: the steps have the higher one, and noise of the force
/// that remains in the rates makes up more of the difference than of the error.
const ESTIMATE: f64 = 0.1;
/// Steps after which it is seen whether longer ones would do.
const REVIEW: usize = 64;
/// Share of the tolerance that longer steps may be expected to need.
const AIM: f64 = 0.3;
/// Grid points that are worked on at once where there is no order in time.
pub(crate) const CHUNK: usize = 16;

/// Motion at grid points.
#[derive(Debug, Default)]
pub(crate) struct Points {
    pub(crate) x: Vec<f64>,
    pub(crate) v: Vec<f64>,
    /// Rates u̇ (mm/s²) and their derivatives by x (1/s²) and ẋ (1/s).
    pub(crate) rate: Vec<f64>,
    pub(crate) by_x: Vec<f64>,
    pub(crate) by_v: Vec<f64>,
}

impl Points {
    fn reserve(&mut self, count: usize) {
        for values in [&mut self.x, &mut self.v, &mut self.rate, &mut self.by_x, &mut self.by_v] {
            if values.len() < count {
                values.resize(count, 0.0);
            }
        }
    }
}

/// Adams steps of one length, after the points of their history.
#[derive(Debug, Clone)]
pub(crate) struct AdamsSegment {
    /// Intervals of a step.
    pub(crate) intervals: usize,
    /// The sample of the first point of the history.
    pub(crate) first_sample: usize,
    /// Points, history included.
    pub(crate) points: Range<usize>,
}

impl AdamsSegment {
    pub(crate) fn sample(&self, point: usize) -> usize {
        self.first_sample + (point - self.points.start) * self.intervals
    }

    /// The points at the ends of the steps.
    pub(crate) fn steps(&self) -> Range<usize> {
        self.points.start + HISTORY..self.points.end
    }

    /// Weights at the samples within a step.
    pub(crate) fn between(&self) -> impl Iterator<Item = (usize, Weights)> + use<> {
        let q = self.intervals;
        (1..q).map(move |j| (j, Weights::at(j as f64 / q as f64)))
    }
}

/// Why equal steps came to an end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum AdamsEnd {
    /// No whole step is left.
    Whole,
    /// This many intervals would do for a step.
    Longer(usize),
    /// The error of a step is larger than the tolerance by this factor.
    Inaccurate(f64),
}

impl Motion<'_, '_, '_> {
    /// The rate at a grid point with its slopes: at a velocity with the excess of the impulse.
    #[inline(always)]
    fn rate_and_slopes<S: Simd>(&mut self, simd: S, at: [f64; 2]) -> Result<[f64; 3], TooRough> {
        self.enter(at)?;
        let [force, by_x, by_v] = self.surface.patches[self.patch].force_and_slopes(simd, at);
        let (beta, damping) = (self.mechanics.per_mass, self.mechanics.damping_kg_s);
        Ok([-beta * (force + damping * at[1]), -beta * by_x, -beta * (by_v + damping)])
    }

    /// Adds a point of a history.
    #[inline(always)]
    pub(crate) fn remember<S: Simd>(
        &mut self,
        simd: S,
        samples: &SampleForcing,
        sample: usize,
        [x, v]: [f64; 2],
        points: &mut Points,
        point: usize,
    ) -> Result<(), TooRough> {
        points.reserve(point + 1);
        let excess = self.mechanics.per_mass * samples.excess[sample];
        let [rate, by_x, by_v] = self.rate_and_slopes(simd, [x, v + excess])?;
        (points.x[point], points.v[point], points.rate[point]) = (x, v, rate);
        (points.by_x[point], points.by_v[point]) = (by_x, by_v);
        Ok(())
    }

    /// Steps on from a history up to a sample at most, and adds the points; longer steps than so many intervals are not asked
    /// for.
    #[inline(always)]
    pub(crate) fn adams_forward<S: Simd>(
        &mut self,
        simd: S,
        samples: &SampleForcing,
        segment: &mut AdamsSegment,
        [last_sample, most_intervals]: [usize; 2],
        control: &Control,
        points: &mut Points,
    ) -> Result<AdamsEnd, TooRough> {
        let q = segment.intervals;
        let adams = self.adams;
        let beta = self.mechanics.per_mass;
        let h = samples.interval_s * q as f64;
        let (h_x, h_v) = (h * h * adams.end.displacement[0], h * adams.end.velocity[0]);
        // A velocity error counts by the rate of the joint.
        let per_difference =
            ESTIMATE * (h * h * adams.error[0]).max(h * adams.error[1] / RATE_PER_S);
        let mut n = segment.points.end;
        let mut sample = segment.sample(n - 1);
        let whole = (last_sample - sample) / q;
        points.reserve(n + whole);
        let Points { x: xs, v: vs, rate: rates, by_x: along_x, by_v: along_v } = points;
        let (mut x, mut v) = (xs[n - 1], vs[n - 1]);
        let mut worst: f64 = 0.0;
        let mut end = AdamsEnd::Whole;
        for count in 1..=whole {
            let [impulse, double] = samples.over(sample, q);
            let history: &[f64; HISTORY] =
                rates[n - HISTORY..n].first_chunk().expect("a whole history");
            let (mut extrapolated, mut of_x, mut of_v) = (0.0, 0.0, 0.0);
            // The newest last: what waits for it is one operation.
            for i in (0..HISTORY).rev() {
                let rate = history[HISTORY - 1 - i];
                extrapolated += adams.extrapolation[i] * rate;
                of_x += adams.end.displacement[i + 1] * rate;
                of_v += adams.end.velocity[i + 1] * rate;
            }
            // The impulse at the grid points, less a smooth curve: at the new point, and on average over the step. By the slope
            // at the last point it changes the rate alike, so that rates with noise of the force are extrapolated and
            // integrated like those without.
            let next = sample + q;
            let total = &samples.total;
            let (mut smooth, mut mean) = (0.0, adams.end.velocity[0] * total[next]);
            for i in 0..HISTORY {
                let total = total[next - (i + 1) * q];
                smooth += adams.extrapolation[i] * total;
                mean += adams.end.velocity[i + 1] * total;
            }
            let start = total[sample] - samples.excess[sample];
            let defect = beta * (double - h * (mean - start));
            let slope = along_v[n - 1];
            extrapolated += slope * beta * (total[next] - smooth);
            let x_ahead = x + h * v + beta * double + h * h * of_x + h_x * extrapolated;
            let v_ahead = v + beta * impulse + h * of_v + h_v * extrapolated;
            let excess = beta * samples.excess[next];
            let [rate, by_x, by_v] = self.rate_and_slopes(simd, [x_ahead, v_ahead + excess])?;
            let difference = (rate - extrapolated) / (1.0 - by_x * h_x - by_v * h_v);
            let error =
                per_difference * difference.abs() + ((by_v - slope) * defect).abs() / RATE_PER_S;
            let (x_new, v_new) = (x_ahead + h_x * difference, v_ahead + h_v * difference);
            let fine = error <= control.error_mm && x_new.abs() < self.mechanics.limit_mm;
            if !fine {
                end = AdamsEnd::Inaccurate(error / control.error_mm);
                break;
            }
            (x, v) = (x_new, v_new);
            rates[n] = extrapolated + difference;
            (xs[n], vs[n], along_x[n], along_v[n]) = (x, v, by_x, by_v);
            n += 1;
            sample = next;
            worst = worst.max(error);
            if count % REVIEW == 0 {
                let longer = (2 * q).min(most_intervals);
                let expected = worst * ((longer / q) as f64).powi(RATES as i32);
                if longer > q
                    && expected <= AIM * control.error_mm
                    && last_sample - sample > REVIEW * longer
                {
                    end = AdamsEnd::Longer(longer);
                    break;
                }
                worst = 0.0;
            }
        }
        segment.points.end = n;
        Ok(end)
    }

    /// Writes the states at the samples that the steps pass; `states` starts with the sample after the first one.
    #[inline(always)]
    pub(crate) fn read<S: Simd>(
        &self,
        _simd: S,
        samples: &SampleForcing,
        segment: &AdamsSegment,
        points: &Points,
        states: &mut [[f64; 2]],
    ) {
        let q = segment.intervals;
        let beta = self.mechanics.per_mass;
        let h = samples.interval_s * q as f64;
        for n in segment.steps() {
            states[segment.sample(n) - 1] = [points.x[n], points.v[n]];
        }
        let between: Vec<(usize, Weights)> = segment.between().collect();
        let mut first = segment.steps().start;
        while first < segment.points.end {
            let count = CHUNK.min(segment.points.end - first);
            for (j, weights) in &between {
                let (mut of_x, mut of_v) = ([0.0; CHUNK], [0.0; CHUNK]);
                for i in 0..RATES {
                    let rates = &points.rate[first - i..first - i + count];
                    let (by_x, by_v) = (weights.displacement[i], weights.velocity[i]);
                    if let Some(rates) = rates.first_chunk::<CHUNK>() {
                        for l in 0..CHUNK {
                            of_x[l] += by_x * rates[l];
                            of_v[l] += by_v * rates[l];
                        }
                    } else {
                        for (l, rate) in rates.iter().enumerate() {
                            of_x[l] += by_x * rate;
                            of_v[l] += by_v * rate;
                        }
                    }
                }
                let since = samples.interval_s * *j as f64;
                for l in 0..count {
                    let before = first + l - 1;
                    let sample = segment.sample(before);
                    let [impulse, double] = samples.over(sample, *j);
                    let (x, v) = (points.x[before], points.v[before]);
                    states[sample + j - 1] = [
                        x + since * v + beta * double + h * h * of_x[l],
                        v + beta * impulse + h * of_v[l],
                    ];
                }
            }
            first += count;
        }
    }
}
