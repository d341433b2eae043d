//! The forward solve.

use super::forcing::{ForcingSegment, ForcingSegments};
use super::motion::{LIMITS, MotionRegions};
use crate::regions::facets::NONE;
use crate::simd::LANES;
use crate::step::closed_form::Step;
use crate::step::exit::RegionExit;
use pam_core::simd::arch;
use pam_solvers::{FailureKind, StepBudget};
use pulp::{Simd, WithSimd};

/// One closed-form step within a region and a forcing segment.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Segment {
    pub(crate) x: f64,
    pub(crate) v: f64,
    /// Force at the start, mN.
    pub(crate) force_mn: f64,
    /// Length, s; zero stands for the nominal step.
    pub(crate) length_s: f64,
    pub(crate) region: u32,
    /// Index of the forcing segment.
    pub(crate) forcing: u32,
}

/// Counts of one solve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ExactStatistics {
    /// Closed-form steps.
    pub segments: usize,
    /// Region crossings: sign changes of units.
    pub crossings: usize,
    /// Different linear regions.
    pub regions: usize,
}

/// A solve that stopped early.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Stopped {
    pub(crate) kind: FailureKind,
    pub(crate) time_s: f64,
    /// Observations before it.
    pub(crate) reached: usize,
}

/// Steps that a sign change counts as: it costs a search of the next region.
const STEPS_PER_CROSSING: usize = 10;
/// Largest number of regions of one trajectory, which are kept in memory; the published network has a thousand.
const MAX_REGIONS: usize = 50_000;
/// Sign changes without progress in time after which the state counts as lying on the facet: the field is
/// continuous, so either side gives the same motion.
const MAX_AT_ONCE: usize = 64;
/// Lengths that differ by less than this part are the same.
const SAME_LENGTH: f64 = 1e-9;

/// A solve in progress.
pub(crate) struct ForwardSolve<'a, 'n> {
    pub(crate) regions: &'a mut MotionRegions<'n>,
    pub(crate) forcing: ForcingSegments<'a>,
    pub(crate) start: [f64; 2],
    /// Receives the segments, if they are kept.
    pub(crate) segments: Option<&'a mut Vec<Segment>>,
    /// Observed states, `[observation, (x, ẋ)]`, from the first forcing segment on.
    pub(crate) observed: &'a mut [f64],
    pub(crate) statistics: &'a mut ExactStatistics,
}

/// The largest number of steps.
#[derive(Debug, Clone, Copy)]
struct Budget {
    start_s: f64,
    most: usize,
}

impl Budget {
    #[inline(always)]
    fn until(&self, time_s: f64) -> usize {
        StepBudget::CLOSED_FORM.until(time_s - self.start_s).min(self.most)
    }
}

/// How far a solve has come.
#[derive(Debug, Clone, Copy)]
struct Progress {
    state: [f64; 2],
    region: u32,
    /// The next forcing segment and the next observation.
    forcing: usize,
    observation: usize,
}

impl Progress {
    fn stopped(&self, kind: FailureKind, time_s: f64) -> Stopped {
        Stopped { kind, time_s, reached: self.observation }
    }

    /// Fails if the state has left the [`LIMITS`].
    #[inline(always)]
    fn check_limits(&self, step_s: f64, time_s: f64) -> Result<(), Stopped> {
        if LIMITS.contains(self.state) {
            return Ok(());
        }
        Err(self.stopped(FailureKind::NonFinite { step_s }, time_s))
    }
}

impl ForwardSolve<'_, '_> {
    pub(crate) fn run(self) -> Result<(), Stopped> {
        arch().dispatch(self)
    }
}

impl WithSimd for ForwardSolve<'_, '_> {
    type Output = Result<(), Stopped>;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> Result<(), Stopped> {
        let region = self.regions.locate(self.start);
        let budget = Budget {
            start_s: self.forcing.get(0).map_or(0.0, |first| first.start_s),
            most: StepBudget::CLOSED_FORM.steps(self.forcing.length_s(), self.forcing.len()),
        };
        let mut now = Progress { state: self.start, region, forcing: 0, observation: 0 };
        loop {
            let tried = self.uncrossed_segments(simd, &mut now);
            let Some(forcing) = self.forcing.get(now.forcing) else { break };
            now.check_limits(forcing.length_s, forcing.start_s)?;
            self.crossed_segment(simd, &forcing, tried, budget, &mut now)?;
            if forcing.observed {
                self.observed[2 * now.observation] = now.state[0];
                self.observed[2 * now.observation + 1] = now.state[1];
                now.observation += 1;
            }
            now.forcing += 1;
        }
        let last = self.forcing.len().checked_sub(1).and_then(|last| self.forcing.get(last));
        let (step_s, time_s) =
            last.map_or((self.regions.nominal_step_s, 0.0), |s| (s.length_s, s.start_s));
        now.check_limits(step_s, time_s)
    }
}

impl ForwardSolve<'_, '_> {
    /// Follows as many forcing segments of nominal length as end within the region. Returns the step over
    /// the next one if it comes near to a facet.
    #[inline(always)]
    fn uncrossed_segments<S: Simd>(&mut self, simd: S, now: &mut Progress) -> Option<Step> {
        let (regions, forcing) = (&*self.regions, self.forcing);
        let nominal_s = regions.nominal_step_s;
        let coefficients = &regions.coefficients[now.region as usize];
        if coefficients.max_step_s < nominal_s || coefficients.facets.blocks != 1 {
            return None;
        }
        let facets = &regions.cache.facets(coefficients.facets)[0];
        let inverse_mass = 1.0 / regions.motion.mass_kg;
        let observed = self.observed.as_chunks_mut::<2>().0;
        let Progress { mut state, region, forcing: mut index, mut observation } = *now;
        let mut before = facets.margins(state);
        let mut after = [0.0; LANES];
        let mut tried = None;
        while let Some(next) = forcing.get(index) {
            if !is_nominal(&next, nominal_s) {
                break;
            }
            let w0 = (next.force_mn - coefficients.offset_mn) * inverse_mass;
            let step = Step::nominal(coefficients, state, [w0, next.rate_mn_s * inverse_mass]);
            if !step.clears(simd, facets, &before, &mut after) {
                tried = Some(step);
                break;
            }
            if let Some(segments) = &mut self.segments {
                segments.push(Segment {
                    x: state[0],
                    v: state[1],
                    force_mn: next.force_mn,
                    length_s: 0.0,
                    region,
                    forcing: index as u32,
                });
            }
            state = step.end;
            before = after;
            if next.observed {
                observed[observation] = state;
                observation += 1;
            }
            index += 1;
        }
        self.statistics.segments += index - now.forcing;
        *now = Progress { state, region, forcing: index, observation };
        tried
    }

    /// Follows one forcing segment with its crossings. `tried` is the step over all of it, if it comes near
    /// to a facet.
    #[inline(always)]
    fn crossed_segment<S: Simd>(
        &mut self,
        simd: S,
        forcing: &ForcingSegment,
        mut tried: Option<Step>,
        budget: Budget,
        now: &mut Progress,
    ) -> Result<(), Stopped> {
        let nominal_s = self.regions.nominal_step_s;
        let inverse_mass = 1.0 / self.regions.motion.mass_kg;
        let length_s = if is_nominal(forcing, nominal_s) { nominal_s } else { forcing.length_s };
        let mut into_s = 0.0;
        let mut at_once = 0;
        let mut entered = NONE;
        while into_s < length_s {
            let coefficients = &self.regions.coefficients[now.region as usize];
            let force_mn = forcing.force_mn + forcing.rate_mn_s * into_s;
            let rest = length_s - into_s;
            // No closure: it might be compiled without the wide instructions.
            let step = match tried.take() {
                Some(step) => step,
                None => {
                    let w0 = (force_mn - coefficients.offset_mn) * inverse_mass;
                    let w = [w0, forcing.rate_mn_s * inverse_mass];
                    Step::up_to(coefficients, rest, now.state, w)
                }
            };
            let facets = self.regions.cache.facets(coefficients.facets);
            match RegionExit::first(simd, facets, &step, entered, at_once > MAX_AT_ONCE) {
                None => {
                    let length = if step.h == nominal_s { 0.0 } else { step.h };
                    self.keep(now, force_mn, length);
                    now.state = step.end;
                    into_s = if step.h == rest { length_s } else { into_s + step.h };
                    at_once = 0;
                    entered = NONE;
                }
                Some(exit) => {
                    if exit.after_s > 0.0 {
                        self.keep(now, force_mn, exit.after_s);
                        now.state = exit.state;
                        into_s += exit.after_s;
                        at_once = 0;
                    } else {
                        at_once += 1;
                    }
                    entered = exit.unit;
                    now.region = self.regions.neighbour(now.region, exit.facet, now.state);
                    self.statistics.crossings += 1;
                }
            }
            let time_s = forcing.start_s + into_s;
            now.check_limits(step.h, time_s)?;
            let ExactStatistics { segments, crossings, .. } = *self.statistics;
            let most = budget.until(time_s);
            if segments + STEPS_PER_CROSSING * crossings > most {
                let kind = FailureKind::TooManySteps { limit: most };
                return Err(now.stopped(kind, time_s));
            }
            if self.regions.coefficients.len() > MAX_REGIONS {
                let kind = FailureKind::TooManySteps { limit: MAX_REGIONS };
                return Err(now.stopped(kind, time_s));
            }
        }
        Ok(())
    }

    #[inline(always)]
    fn keep(&mut self, now: &Progress, force_mn: f64, length_s: f64) {
        self.statistics.segments += 1;
        if let Some(segments) = &mut self.segments {
            let Progress { state: [x, v], region, forcing, .. } = *now;
            segments.push(Segment { x, v, force_mn, length_s, region, forcing: forcing as u32 });
        }
    }
}

/// True if a segment is as long as most are.
#[inline(always)]
fn is_nominal(forcing: &ForcingSegment, nominal_s: f64) -> bool {
    (forcing.length_s - nominal_s).abs() <= SAME_LENGTH * nominal_s
}
