//! A whole trajectory: segments of Adams steps and of Runge–Kutta steps, forward and backward.

use crate::adams::HISTORY;
use crate::adams_backward::Cotangents;
use crate::adams_forward::{AdamsEnd, AdamsSegment, MOST_INTERVALS, Points};
use crate::forward::Progress;
use crate::samples::{SampleForcing, equal_intervals};
use crate::surface::TooRough;
use crate::trajectory::{Control, Motion, MotionSums, Span, Step, Stop};
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
    Adams(AdamsSegment),
}

/// Record of the forward pass that the backward pass reads.
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
            Part::Adams(segment) => segment.steps().len(),
        };
        self.parts.iter().map(of).sum()
    }

    /// Bytes that the backward pass reads.
    pub(crate) fn bytes(&self) -> usize {
        let points: usize = self
            .parts
            .iter()
            .map(|part| if let Part::Adams(segment) = part { segment.points.len() } else { 0 })
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
        span: &Span<'_>,
        control: &Control,
        states: &mut [[f64; 2]],
        log: &mut Log,
    ) -> Result<(), Stop> {
        log.parts.clear();
        log.steps.clear();
        log.rejected = 0;
        let count = span.observe_s.len();
        let mut progress = Progress {
            time_s: span.start_s,
            state: span.state,
            aimed_s: 0.25 * control.longest_s,
            next: 0,
            until: count,
            rejected: 0,
        };
        let mut taken = 0;
        let mut most = 0;
        if equal_intervals(span.start_s, span.observe_s) {
            log.samples.take(self.lines, span.start_s, span.observe_s, self.forcing);
            most = MOST_INTERVALS.min((control.longest_s / log.samples.interval_s) as usize);
        }
        let (mut intervals, mut detour) = (FIRST_INTERVALS, DETOUR);
        loop {
            intervals = intervals.min(most);
            let worth = most > 0 && count - progress.next >= FEWEST_STEPS * intervals.max(1);
            let too_short = worth && intervals == 0;
            // Where Runge–Kutta steps lead: to the end, past a part where Adams steps are inaccurate, or to the first history.
            progress.until = if !worth {
                count
            } else if too_short {
                (progress.next + detour).min(count)
            } else {
                (HISTORY - 1) * intervals
            };
            if !worth || progress.next < progress.until {
                self.runge_kutta(simd, span, &mut progress, control, states, log)?;
            }
            if !worth {
                return Ok(());
            }
            if too_short {
                detour *= 2;
                intervals = 1;
                continue;
            }
            let Log { points, samples, .. } = &mut *log;
            // The history of the first step: states are known at all samples up to here.
            let first_sample = progress.next - (HISTORY - 1) * intervals;
            let mut segment =
                AdamsSegment { intervals, first_sample, points: taken..taken + HISTORY };
            for point in segment.points.clone() {
                let sample = segment.sample(point);
                let state = if sample == 0 { span.state } else { states[sample - 1] };
                self.remember(simd, samples, sample, state, points, point)
                    .map_err(|_: TooRough| Stop::Rough { time_s: progress.time_s })?;
            }
            let end = self
                .adams_forward(simd, samples, &mut segment, [count, most], control, points)
                .map_err(|_: TooRough| Stop::Rough { time_s: progress.time_s })?;
            let steps_taken = segment.steps().len();
            if steps_taken > 0 {
                self.read(simd, samples, &segment, points, states);
                let last = segment.points.end - 1;
                progress.next = segment.sample(last);
                progress.time_s = span.observe_s[progress.next - 1];
                progress.state = [points.x[last], points.v[last]];
                taken = segment.points.end;
                log.parts.push(Part::Adams(segment));
            }
            match end {
                AdamsEnd::Whole if progress.next == count => {
                    // The end may lie after the last observation.
                    if progress.time_s >= span.end_s {
                        return Ok(());
                    }
                }
                AdamsEnd::Whole => {}
                AdamsEnd::Longer(longer) => intervals = longer,
                AdamsEnd::Inaccurate(factor) => {
                    log.rejected += 1;
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

    /// A segment of Runge–Kutta steps.
    #[inline(always)]
    fn runge_kutta<S: Simd>(
        &mut self,
        simd: S,
        span: &Span<'_>,
        progress: &mut Progress,
        control: &Control,
        states: &mut [[f64; 2]],
        log: &mut Log,
    ) -> Result<(), Stop> {
        let from = log.steps.len();
        let done = self.forward(simd, span, progress, control, states, &mut log.steps);
        log.rejected += std::mem::take(&mut progress.rejected);
        log.parts.push(Part::RungeKutta(from..log.steps.len()));
        done
    }

    /// The derivatives of a loss with these cotangents of the observed states; they are used up.
    #[inline(always)]
    pub(crate) fn pull_back<S: Simd>(
        &mut self,
        simd: S,
        span: &Span<'_>,
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
                    self.backward(simd, span, steps, observed, state, &mut sums)?
                }
                Part::Adams(segment) => self.adams_backward(
                    simd, samples, segment, points, observed, cotangents, state, &mut sums,
                )?,
            };
        }
        sums.start[0] += state[0];
        sums.start[1] += state[1];
        Ok(sums)
    }
}
