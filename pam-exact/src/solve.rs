//! The forward solve: closed-form steps from piece to piece of the force, cut where a unit changes sign.

use crate::atlas::{NONE, Sides};
use crate::event::{COEFFICIENTS, Margin};
use crate::forcing::Piece;
use crate::fundamental::{spectral_bound, terms};
use crate::motion::{Law, Laws, WINDOW, jerk_bound};
use crate::network::LANES;
use pam_core::simd::arch;
use pam_solvers::FailureKind;
use pulp::{Simd, WithSimd};

/// One closed-form step inside a pattern.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Segment {
    pub(crate) x: f64,
    pub(crate) v: f64,
    /// Force at the start, mN.
    pub(crate) force_mn: f64,
    /// Length, s; zero stands for the usual one.
    pub(crate) length_s: f64,
    pub(crate) pattern: u32,
    pub(crate) piece: u32,
}

/// Counts of one solve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ExactStatistics {
    /// Closed-form steps.
    pub segments: usize,
    /// Sign changes of units.
    pub crossings: usize,
    /// Different patterns.
    pub patterns: usize,
}

/// A solve that stopped.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Stopped {
    pub(crate) kind: FailureKind,
    pub(crate) time_s: f64,
}

/// Sign changes without progress in time after which the state counts as being on the border: the field
/// is continuous, so it does not matter from which side it is followed.
const MOST_AT_ONCE: usize = 64;
/// Lengths that differ by less than this part are the same.
const SAME_LENGTH: f64 = 1e-9;

/// A solve in progress.
pub(crate) struct Solve<'a, 'n> {
    pub(crate) laws: &'a mut Laws<'n>,
    pub(crate) pieces: &'a [Piece],
    pub(crate) start: [f64; 2],
    /// Where the segments go if they are kept.
    pub(crate) segments: Option<&'a mut Vec<Segment>>,
    /// Observed states, `[observation, (x, ẋ)]`, from the first piece on.
    pub(crate) observed: &'a mut [f64],
    pub(crate) most_crossings: usize,
    pub(crate) statistics: &'a mut ExactStatistics,
}

impl Solve<'_, '_> {
    pub(crate) fn run(self) -> Result<(), Stopped> {
        arch().dispatch(self)
    }
}

impl WithSimd for Solve<'_, '_> {
    type Output = Result<(), Stopped>;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _simd: S) -> Result<(), Stopped> {
        self.all_pieces()
    }
}

/// Half of this times the square of the step bounds how far a function is from its chord.
#[inline(always)]
fn chord(h: f64) -> f64 {
    0.125 * h * h
}

/// Whether the margins of all sides stay positive over a step, and the margins at its end.
#[inline(always)]
fn stays(
    sides: &Sides,
    [x, v]: [f64; 2],
    [dx, dv]: [f64; 2],
    before: &[f64; LANES],
    after: &mut [f64; LANES],
) -> bool {
    let mut fails = 0_u32;
    for i in 0..LANES {
        let (alpha, beta, gamma) = (sides.alpha[i], sides.beta[i], sides.gamma[i]);
        let m = alpha + beta * x + gamma * v;
        after[i] = m;
        let least = if m < before[i] { m } else { before[i] };
        fails |= u32::from(least <= beta.abs() * dx + gamma.abs() * dv);
    }
    fails == 0
}

#[inline(always)]
fn margins(sides: &Sides, [x, v]: [f64; 2]) -> [f64; LANES] {
    std::array::from_fn(|i| sides.alpha[i] + sides.beta[i] * x + sides.gamma[i] * v)
}

impl Solve<'_, '_> {
    #[inline(always)]
    fn all_pieces(&mut self) -> Result<(), Stopped> {
        let usual_s = self.laws.usual_s;
        let inverse_mass = 1.0 / self.laws.motion.mass_kg;
        let mut state = self.start;
        let mut pattern = self.laws.at(state);
        let mut observation = 0;
        let mut index = 0;
        while index < self.pieces.len() {
            // As many whole steps of the usual length as fit into this pattern.
            let law = self.laws.laws[pattern as usize];
            let sides = self.laws.atlas.sides(self.laws.atlas.pattern(pattern));
            if law.longest_s >= usual_s && sides.len() == 1 {
                let sides = &sides[0];
                let mut before = margins(sides, state);
                let mut after = [0.0; LANES];
                while let Some(piece) = self.pieces.get(index) {
                    if (piece.length_s - usual_s).abs() > SAME_LENGTH * usual_s {
                        break;
                    }
                    let w0 = (piece.force_mn - law.offset_mn) * inverse_mass;
                    let w1 = piece.rate_mn_s * inverse_mass;
                    let a = w0 - law.kappa * state[0] - law.zeta * state[1];
                    let end = law.usual.advance(law.kappa, usual_s, state, a, w1);
                    let reach = chord(usual_s);
                    let jerk = law.jerk[0] * w1.abs()
                        + law.jerk[1] * state[1].abs()
                        + law.jerk[2] * a.abs();
                    let off = [reach * (a.abs() + usual_s * jerk), reach * jerk];
                    if !stays(sides, end, off, &before, &mut after) {
                        break;
                    }
                    if let Some(segments) = &mut self.segments {
                        segments.push(Segment {
                            x: state[0],
                            v: state[1],
                            force_mn: piece.force_mn,
                            length_s: 0.0,
                            pattern,
                            piece: index as u32,
                        });
                    }
                    self.statistics.segments += 1;
                    state = end;
                    before = after;
                    if piece.observed {
                        self.observed[2 * observation] = state[0];
                        self.observed[2 * observation + 1] = state[1];
                        observation += 1;
                    }
                    index += 1;
                }
            }
            let Some(piece) = self.pieces.get(index).copied() else { break };
            if !WINDOW.contains(state) {
                let kind = FailureKind::NonFinite { step_s: piece.length_s };
                return Err(Stopped { kind, time_s: piece.start_s });
            }
            self.one_piece(&piece, index as u32, &mut state, &mut pattern)?;
            if piece.observed {
                self.observed[2 * observation] = state[0];
                self.observed[2 * observation + 1] = state[1];
                observation += 1;
            }
            index += 1;
        }
        if WINDOW.contains(state) {
            return Ok(());
        }
        let (step_s, time_s) =
            self.pieces.last().map_or((usual_s, 0.0), |p| (p.length_s, p.start_s));
        Err(Stopped { kind: FailureKind::NonFinite { step_s }, time_s })
    }

    /// One piece with whatever crossings there are.
    #[inline(always)]
    fn one_piece(
        &mut self,
        piece: &Piece,
        index: u32,
        state: &mut [f64; 2],
        pattern: &mut u32,
    ) -> Result<(), Stopped> {
        let usual_s = self.laws.usual_s;
        let mass = self.laws.motion.mass_kg;
        let same = (piece.length_s - usual_s).abs() <= SAME_LENGTH * usual_s;
        let length_s = if same { usual_s } else { piece.length_s };
        let mut into_s = 0.0;
        let mut at_once = 0;
        let mut entered = NONE;
        while into_s < length_s {
            let law = self.laws.laws[*pattern as usize];
            let force_mn = piece.force_mn + piece.rate_mn_s * into_s;
            let w = [(force_mn - law.offset_mn) / mass, piece.rate_mn_s / mass];
            let a = w[0] - law.kappa * state[0] - law.zeta * state[1];
            let rest = length_s - into_s;
            let whole = rest <= law.longest_s;
            let h = if whole { rest } else { law.longest_s };
            let usual = h == usual_s;
            let terms = if h <= usual_s {
                law.terms as usize
            } else {
                terms(spectral_bound(law.kappa, law.zeta) * h)
            };
            let series = Series::new(&law, *state, a, w[1], terms.min(COEFFICIENTS));
            let end =
                if usual { law.usual.advance(law.kappa, h, *state, a, w[1]) } else { series.at(h) };
            let step = Step { law: &law, from: *state, end, a, rate: w[1], h, series };
            match self.first_exit(*pattern, &step, entered, at_once > MOST_AT_ONCE) {
                None => {
                    self.keep(*state, force_mn, if usual { 0.0 } else { h }, *pattern, index);
                    *state = end;
                    into_s = if whole { length_s } else { into_s + h };
                    at_once = 0;
                    entered = NONE;
                }
                Some(exit) => {
                    if exit.after_s > 0.0 {
                        self.keep(*state, force_mn, exit.after_s, *pattern, index);
                        *state = step.series.at(exit.after_s);
                        into_s += exit.after_s;
                        at_once = 0;
                    } else {
                        at_once += 1;
                    }
                    entered = exit.unit;
                    *pattern = self.laws.behind(*pattern, exit.block, exit.lane);
                    self.statistics.crossings += 1;
                }
            }
            let stopped = |kind| Err(Stopped { kind, time_s: piece.start_s + into_s });
            if !WINDOW.contains(*state) {
                return stopped(FailureKind::NonFinite { step_s: h });
            }
            if self.statistics.crossings > self.most_crossings {
                return stopped(FailureKind::TooManySteps { limit: self.most_crossings });
            }
        }
        Ok(())
    }

    #[inline(always)]
    fn keep(&mut self, [x, v]: [f64; 2], force_mn: f64, length_s: f64, pattern: u32, piece: u32) {
        self.statistics.segments += 1;
        if let Some(segments) = &mut self.segments {
            segments.push(Segment { x, v, force_mn, length_s, pattern, piece });
        }
    }

    /// The first side that the motion crosses in a step. `entered` is the unit whose border was crossed
    /// just before.
    #[inline(always)]
    fn first_exit(
        &self,
        pattern: u32,
        step: &Step<'_>,
        entered: u32,
        on_border: bool,
    ) -> Option<Exit> {
        let law = step.law;
        let bound = jerk_bound(law.kappa, law.zeta, step.h);
        let jerk =
            bound[0] * step.rate.abs() + bound[1] * step.from[1].abs() + bound[2] * step.a.abs();
        let reach = chord(step.h);
        let off = [reach * (step.a.abs() + step.h * jerk), reach * jerk];
        let mut found: Option<Exit> = None;
        let mut limit = step.h;
        for (block, sides) in
            self.laws.atlas.sides(self.laws.atlas.pattern(pattern)).iter().enumerate()
        {
            let before = margins(sides, step.from);
            let after = margins(sides, step.end);
            for lane in 0..LANES {
                let least = before[lane].min(after[lane]);
                let far = sides.beta[lane].abs() * off[0] + sides.gamma[lane].abs() * off[1];
                if least > far {
                    continue;
                }
                let line = [sides.alpha[lane], sides.beta[lane], sides.gamma[lane]];
                let mut margin = Margin::new(line, &step.series.d, step.series.len);
                if sides.unit[lane] == entered {
                    // The tables of two patterns agree on their common border to rounding only.
                    margin.start_at_zero();
                }
                if on_border && before[lane] <= 64.0 * margin.noise() {
                    continue;
                }
                let exit = margin.first_exit(limit);
                if let Some(after_s) = exit.filter(|t| found.is_none_or(|f| *t < f.after_s)) {
                    found = Some(Exit { after_s, block, lane, unit: sides.unit[lane] });
                    limit = after_s;
                    if after_s == 0.0 {
                        return found;
                    }
                }
            }
        }
        found
    }
}

#[derive(Debug, Clone, Copy)]
struct Exit {
    after_s: f64,
    block: usize,
    lane: usize,
    unit: u32,
}

/// A step whose crossings are looked for.
struct Step<'a> {
    law: &'a Law,
    from: [f64; 2],
    end: [f64; 2],
    a: f64,
    rate: f64,
    h: f64,
    series: Series,
}

/// The displacement as a power series in the time from the start of a step.
struct Series {
    /// Derivatives over factorials; one more than `len`.
    d: [f64; COEFFICIENTS + 1],
    len: usize,
}

impl Series {
    #[inline(always)]
    fn new(law: &Law, [x, v]: [f64; 2], a: f64, rate: f64, len: usize) -> Self {
        let (kappa, zeta) = (law.kappa, law.zeta);
        let mut d = [0.0; COEFFICIENTS + 1];
        let (mut two_before, mut before) = (a, rate - kappa * v - zeta * a);
        d[0] = x;
        d[1] = v;
        d[2] = 0.5 * a;
        d[3] = INVERSE_FACTORIAL[3] * before;
        for n in 4..=len {
            (two_before, before) = (before, (-zeta).mul_add(before, -kappa * two_before));
            d[n] = INVERSE_FACTORIAL[n] * before;
        }
        Self { d, len }
    }

    /// Displacement and velocity after `t`.
    #[inline(always)]
    fn at(&self, t: f64) -> [f64; 2] {
        let (mut x, mut v) = (0.0_f64, 0.0_f64);
        for &d in self.d[..=self.len].iter().rev() {
            v = v.mul_add(t, x);
            x = x.mul_add(t, d);
        }
        [x, v]
    }
}

/// `1 / n!`.
const INVERSE_FACTORIAL: [f64; COEFFICIENTS + 1] = {
    let mut inverse = [1.0; COEFFICIENTS + 1];
    let mut n = 1;
    while n < inverse.len() {
        inverse[n] = inverse[n - 1] / n as f64;
        n += 1;
    }
    inverse
};
