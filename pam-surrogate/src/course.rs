//! A whole trajectory: stretches of Adams steps and of Runge–Kutta steps, forward and backward.

use crate::adams::HISTORY;
use crate::forward::Stretch;
use crate::march::{MOST_INTERVALS, March, MarchEnd, Points};
use crate::retreat::Cotangents;
use crate::samples::{SampleForcing, equal_intervals};
use crate::surface::TooRough;
use crate::trajectory::{Control, Course, Motion, MotionSums, Step, Stop};
use pulp::Simd;
use std::ops::Range;

/// Intervals of the first Adams steps.
const FIRST_INTERVALS: usize = 1;
/// Samples that Runge–Kutta steps pass where even short Adams steps are inaccurate; twice as many each time.
const DETOUR: usize = 8;
/// Fewest Adams steps that are worth their start.
const FEWEST_STEPS: usize = 24;
/// How the error of a step grows with its length, and the share of the tolerance that is aimed at.
const ORDER: f64 = HISTORY as f64 + 1.0;
const AIM: f64 = 0.5;

/// Steps of one kind.
#[derive(Debug, Clone)]
pub(crate) enum Part {
    RungeKutta(Range<usize>),
    Adams(March),
}

/// What was done on the way, for the backward pass.
#[derive(Debug, Default)]
pub(crate) struct Log {
    pub(crate) parts: Vec<Part>,
    pub(crate) steps: Vec<Step>,
    pub(crate) points: Points,
    pub(crate) samples: SampleForcing,
    pub(crate) cotangents: Cotangents,
    pub(crate) rejected: usize,
}

impl Log {
    /// Accepted steps.
    pub(crate) fn accepted(&self) -> usize {
        let of = |part: &Part| match part {
            Part::RungeKutta(steps) => steps.len().saturating_sub(1),
            Part::Adams(march) => march.steps().len(),
        };
        self.parts.iter().map(of).sum()
    }

    /// Bytes that the backward pass reads.
    pub(crate) fn bytes(&self) -> usize {
        let points: usize = self
            .parts
            .iter()
            .map(|part| if let Part::Adams(march) = part { march.points.len() } else { 0 })
            .sum();
        size_of_val(&self.steps[..]) + 5 * points * size_of::<f64>()
    }
}

impl Motion<'_, '_, '_> {
    /// Solves from start to end, and writes the state at each observation.
    #[inline(always)]
    pub(crate) fn solve<S: Simd>(
        &mut self,
        simd: S,
        course: &Course<'_>,
        control: &Control,
        states: &mut [[f64; 2]],
        log: &mut Log,
    ) -> Result<(), Stop> {
        let Log { parts, steps, points, samples, rejected, .. } = log;
        parts.clear();
        steps.clear();
        let count = course.observe_s.len();
        let mut stretch = Stretch {
            time_s: course.start_s,
            state: course.state,
            aimed_s: 0.25 * control.longest_s,
            next: 0,
            until: count,
            rejected: 0,
        };
        *rejected = 0;
        let mut taken = 0;
        let mut most = 0;
        if equal_intervals(course.start_s, course.observe_s) {
            samples.take(self.lines, course.start_s, course.observe_s, self.forcing);
            most = MOST_INTERVALS.min((control.longest_s / samples.interval_s) as usize);
        }
        let (mut intervals, mut detour) = (FIRST_INTERVALS, DETOUR);
        loop {
            intervals = intervals.min(most);
            let worth = most > 0 && count - stretch.next >= FEWEST_STEPS * intervals.max(1);
            if !worth || intervals == 0 {
                // Runge–Kutta steps to the end, or past what is hard for Adams steps.
                stretch.until = if worth { (stretch.next + detour).min(count) } else { count };
                self.runge_kutta(
                    simd,
                    course,
                    &mut stretch,
                    control,
                    states,
                    steps,
                    parts,
                    rejected,
                )?;
                if !worth {
                    return Ok(());
                }
                detour *= 2;
                intervals = 1;
                continue;
            }
            if stretch.next < (HISTORY - 1) * intervals {
                stretch.until = (HISTORY - 1) * intervals;
                self.runge_kutta(
                    simd,
                    course,
                    &mut stretch,
                    control,
                    states,
                    steps,
                    parts,
                    rejected,
                )?;
            }
            // The history of the first step: states are known at all samples up to here.
            let first_sample = stretch.next - (HISTORY - 1) * intervals;
            let mut march = March { intervals, first_sample, points: taken..taken + HISTORY };
            for point in march.points.clone() {
                let sample = march.sample(point);
                let state = if sample == 0 { course.state } else { states[sample - 1] };
                self.remember(simd, samples, sample, state, points, point)
                    .map_err(|_: TooRough| Stop::Rough { time_s: stretch.time_s })?;
            }
            let end = self
                .march(simd, samples, &mut march, [count, most], control, points)
                .map_err(|_: TooRough| Stop::Rough { time_s: stretch.time_s })?;
            let steps_taken = march.steps().len();
            if steps_taken > 0 {
                self.read(simd, samples, &march, points, states);
                let last = march.points.end - 1;
                stretch.next = march.sample(last);
                stretch.time_s = course.observe_s[stretch.next - 1];
                stretch.state = [points.x[last], points.v[last]];
                taken = march.points.end;
                parts.push(Part::Adams(march));
            }
            match end {
                MarchEnd::Whole if stretch.next == count => {
                    // The end may lie after the last observation.
                    if stretch.time_s >= course.end_s {
                        return Ok(());
                    }
                }
                MarchEnd::Whole => {}
                MarchEnd::Longer(longer) => intervals = longer,
                MarchEnd::Inaccurate(factor) => {
                    *rejected += 1;
                    let share = (AIM / factor).powf(1.0 / ORDER);
                    // Not a number: as short as can be.
                    let shorter = (intervals as f64 * share) as usize;
                    intervals = shorter.min(intervals / 2);
                    if steps_taken >= FEWEST_STEPS {
                        detour = DETOUR;
                    }
                }
            }
        }
    }

    /// A stretch of Runge–Kutta steps.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    fn runge_kutta<S: Simd>(
        &mut self,
        simd: S,
        course: &Course<'_>,
        stretch: &mut Stretch,
        control: &Control,
        states: &mut [[f64; 2]],
        steps: &mut Vec<Step>,
        parts: &mut Vec<Part>,
        rejected: &mut usize,
    ) -> Result<(), Stop> {
        let from = steps.len();
        let done = self.forward(simd, course, stretch, control, states, steps);
        *rejected += std::mem::take(&mut stretch.rejected);
        parts.push(Part::RungeKutta(from..steps.len()));
        done
    }

    /// The derivatives of a loss with these cotangents of the observed states; they are used up.
    #[inline(always)]
    pub(crate) fn pull_back<S: Simd>(
        &mut self,
        simd: S,
        course: &Course<'_>,
        observed: &mut [[f64; 2]],
        log: &mut Log,
    ) -> Result<MotionSums, TooRough> {
        let Log { parts, steps, points, samples, cotangents, .. } = log;
        let mut sums = MotionSums::default();
        let mut state = [0.0; 2];
        for part in parts.iter().rev() {
            state = match part {
                Part::RungeKutta(range) => {
                    let steps = &steps[range.clone()];
                    self.backward(simd, course, steps, observed, state, &mut sums)?
                }
                Part::Adams(march) => self.retreat(
                    simd, samples, march, points, observed, cotangents, state, &mut sums,
                )?,
            };
        }
        sums.start[0] += state[0];
        sums.start[1] += state[1];
        Ok(sums)
    }
}
