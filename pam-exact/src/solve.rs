//! The forward solve: closed-form steps from piece to piece of the force, cut where a unit changes sign.

use crate::atlas::NONE;
use crate::event::{COEFFICIENTS, Margin};
use crate::forcing::Piece;
use crate::fundamental::{Response, spectral_bound, terms};
use crate::motion::{Law, Laws, WINDOW, jerk_bound};
use crate::network::LANES;
use crate::sides::{Sides, none};
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
    fn with_simd<S: Simd>(mut self, simd: S) -> Result<(), Stopped> {
        self.all_pieces(simd)
    }
}

/// Half of this times the square of the step bounds how far a function is from its chord.
#[inline(always)]
fn chord(h: f64) -> f64 {
    0.125 * h * h
}

/// Margins of all sides at a state.
#[inline(always)]
fn margins(sides: &Sides, [x, v]: [f64; 2]) -> [f64; LANES] {
    std::array::from_fn(|i| sides.gamma[i].mul_add(v, sides.beta[i].mul_add(x, sides.alpha[i])))
}

/// A place before which no side's margin may become negative over a step to the state `end`, along which
/// displacement and velocity stray from their chords by `off` at most; [`LANES`] if none may. The
/// margins at the end go to `after`.
#[inline(always)]
fn first_near<S: Simd>(
    simd: S,
    sides: &Sides,
    before: &[f64; LANES],
    end: [f64; 2],
    off: [f64; 2],
    after: &mut [f64; LANES],
) -> usize {
    let [x, v] = end.map(|c| simd.splat_f64s(c));
    let [off_x, off_v] = off.map(|c| simd.splat_f64s(c));
    let (alpha, beta) = (S::as_simd_f64s(&sides.alpha).0, S::as_simd_f64s(&sides.beta).0);
    let gamma = S::as_simd_f64s(&sides.gamma).0;
    let before = S::as_simd_f64s(before).0;
    let after = S::as_mut_simd_f64s(after).0;
    let mut first = LANES;
    for k in (0..alpha.len()).rev() {
        let (b, c) = (beta[k], gamma[k]);
        after[k] = simd.mul_add_f64s(c, v, simd.mul_add_f64s(b, x, alpha[k]));
        let least = simd.min_f64s(before[k], after[k]);
        let far = simd.mul_f64s(simd.abs_f64s(c), off_v);
        let far = simd.mul_add_f64s(simd.abs_f64s(b), off_x, far);
        if !none(simd, simd.less_than_or_equal_f64s(least, far)) {
            first = k * S::F64_LANES;
        }
    }
    first
}

impl Solve<'_, '_> {
    #[inline(always)]
    fn all_pieces<S: Simd>(&mut self, simd: S) -> Result<(), Stopped> {
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
                let reach = chord(usual_s);
                let mut before = margins(sides, state);
                let mut after = [0.0; LANES];
                while let Some(piece) = self.pieces.get(index) {
                    if (piece.length_s - usual_s).abs() > SAME_LENGTH * usual_s {
                        break;
                    }
                    let w0 = (piece.force_mn - law.offset_mn) * inverse_mass;
                    let w1 = piece.rate_mn_s * inverse_mass;
                    let a = law.acceleration(state, w0);
                    let end = law.usual.advance(law.kappa, usual_s, state, a, w1);
                    let [a_most, jerk_most] = law.bounds(usual_s, law.jerk, state[1], a, w1);
                    let off = [reach * a_most, reach * jerk_most];
                    if first_near(simd, sides, &before, end, off, &mut after) < LANES {
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
            self.one_piece(simd, &piece, index as u32, &mut state, &mut pattern)?;
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
    fn one_piece<S: Simd>(
        &mut self,
        simd: S,
        piece: &Piece,
        index: u32,
        state: &mut [f64; 2],
        pattern: &mut u32,
    ) -> Result<(), Stopped> {
        let usual_s = self.laws.usual_s;
        let inverse_mass = 1.0 / self.laws.motion.mass_kg;
        let same = (piece.length_s - usual_s).abs() <= SAME_LENGTH * usual_s;
        let length_s = if same { usual_s } else { piece.length_s };
        let mut into_s = 0.0;
        let mut at_once = 0;
        let mut entered = NONE;
        while into_s < length_s {
            let law = self.laws.laws[*pattern as usize];
            let force_mn = piece.force_mn + piece.rate_mn_s * into_s;
            let w = [(force_mn - law.offset_mn) * inverse_mass, piece.rate_mn_s * inverse_mass];
            let a = law.acceleration(*state, w[0]);
            let rest = length_s - into_s;
            let whole = rest <= law.longest_s;
            let h = if whole { rest } else { law.longest_s };
            let usual = h == usual_s;
            let (response, bound) = if usual {
                (law.usual, law.jerk)
            } else if h <= usual_s {
                (Response::new(law.kappa, law.zeta, h, law.terms as usize), law.jerk)
            } else {
                let terms = terms(spectral_bound(law.kappa, law.zeta) * h);
                let bound = jerk_bound(law.kappa, law.zeta, h);
                (Response::new(law.kappa, law.zeta, h, terms), bound)
            };
            let end = response.advance(law.kappa, h, *state, a, w[1]);
            let most = law.bounds(h, bound, state[1], a, w[1]);
            let step = Step { law: &law, from: *state, end, a, w, h, most };
            match self.first_exit(simd, *pattern, &step, entered, at_once > MOST_AT_ONCE) {
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
                        *state = exit.state;
                        into_s += exit.after_s;
                        at_once = 0;
                    } else {
                        at_once += 1;
                    }
                    entered = exit.unit;
                    *pattern = self.laws.behind(*pattern, exit.block, exit.lane, *state);
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
    fn first_exit<S: Simd>(
        &self,
        simd: S,
        pattern: u32,
        step: &Step<'_>,
        entered: u32,
        on_border: bool,
    ) -> Option<Exit> {
        let reach = chord(step.h);
        let off = [reach * step.most[0], reach * step.most[1]];
        let mut found: Option<Exit> = None;
        let blocks = self.laws.atlas.sides(self.laws.atlas.pattern(pattern));
        for (block, sides) in blocks.iter().enumerate() {
            let before = margins(sides, step.from);
            let mut after = [0.0; LANES];
            let first = first_near(simd, sides, &before, step.end, off, &mut after);
            for lane in first..LANES {
                let [b, c] = [sides.beta[lane].abs(), sides.gamma[lane].abs()];
                let far = b.mul_add(off[0], c * off[1]);
                if before[lane].min(after[lane]) > far {
                    continue;
                }
                let line = Line {
                    alpha: sides.alpha[lane],
                    beta: sides.beta[lane],
                    gamma: sides.gamma[lane],
                    before: before[lane],
                    after: after[lane],
                    entered: sides.unit[lane] == entered,
                };
                let limit = found.as_ref().map_or(step.h, |f| f.after_s);
                let exit = step.exit(&line, limit, on_border);
                if let Some((after_s, state)) = exit.filter(|e| e.0 < limit || found.is_none()) {
                    found = Some(Exit { after_s, state, block, lane, unit: sides.unit[lane] });
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
    state: [f64; 2],
    block: usize,
    lane: usize,
    unit: u32,
}

/// A step whose crossings are looked for.
struct Step<'a> {
    law: &'a Law,
    from: [f64; 2],
    end: [f64; 2],
    /// Acceleration at the start.
    a: f64,
    /// Forcing `w₀ + w₁ τ`.
    w: [f64; 2],
    h: f64,
    /// Bounds of acceleration and jerk.
    most: [f64; 2],
}

/// A side that the motion may cross.
struct Line {
    alpha: f64,
    beta: f64,
    gamma: f64,
    /// Margins at both ends of the step.
    before: f64,
    after: f64,
    /// Whether the motion comes from it.
    entered: bool,
}

/// A crossing's time is found to this part of the step. The field is continuous across the border, so
/// what the state loses by an error `δ` of the time is of the order of `δ²`.
const ROOT_TOLERANCE: f64 = 1e-13;
/// Newton steps before the root is bracketed.
const NEWTON_STEPS: usize = 6;

impl Step<'_> {
    /// Time and state of the first exit across a line up to `limit`.
    ///
    /// A margin that falls throughout the step, by a bound of its curvature, has its root found by
    /// Newton's method on the motion itself; one that rises throughout has none. Any other goes the
    /// long way.
    #[inline(always)]
    fn exit(&self, line: &Line, limit: f64, on_border: bool) -> Option<(f64, [f64; 2])> {
        let [x, v] = self.from;
        let curvature = line.beta.abs().mul_add(self.most[0], line.gamma.abs() * self.most[1]);
        let slope = line.beta.mul_add(v, line.gamma * self.a);
        let noise = 4.0
            * f64::EPSILON
            * (line.alpha.abs() + (line.beta * x).abs() + (line.gamma * v).abs());
        // The tables of two patterns agree on their common border to rounding only.
        let start = if line.entered { 0.0 } else { line.before };
        if start > noise || (line.entered && slope > 0.0) {
            if slope > curvature * self.h {
                return None;
            }
            if slope < -curvature * self.h {
                if line.after >= 0.0 {
                    return None;
                }
                if let Some(root) = self.root(line, start, slope, curvature) {
                    return (root.0 <= limit).then_some(root);
                }
            }
        }
        self.long_way(line, limit, on_border)
    }

    /// The root of a margin that falls throughout the step to a negative value.
    #[inline(always)]
    fn root(&self, line: &Line, start: f64, slope: f64, curvature: f64) -> Option<(f64, [f64; 2])> {
        let law = self.law;
        let [x, v] = self.from;
        let terms = law.terms_of(self.h);
        let jerk = (-law.kappa).mul_add(v, (-law.zeta).mul_add(self.a, self.w[1]));
        let bend = line.beta.mul_add(self.a, line.gamma * jerk);
        let square = slope.mul_add(slope, -2.0 * bend * start);
        let mut t = 2.0 * start / (square.max(0.0).sqrt() - slope);
        for _ in 0..NEWTON_STEPS {
            if !(t >= 0.0 && t <= self.h) {
                return None;
            }
            let response = Response::new(law.kappa, law.zeta, t, terms);
            let [xt, vt] = response.advance(law.kappa, t, [x, v], self.a, self.w[1]);
            let at = law.acceleration([xt, vt], self.w[1].mul_add(t, self.w[0]));
            let margin = line.gamma.mul_add(vt, line.beta.mul_add(xt, line.alpha));
            let slope = line.beta.mul_add(vt, line.gamma * at);
            let dt = -margin / slope;
            t += dt;
            if curvature * dt * dt <= ROOT_TOLERANCE * self.h * slope.abs() {
                // Two terms of Taylor's series are enough for so small a change.
                let jerk = (-law.kappa).mul_add(vt, (-law.zeta).mul_add(at, self.w[1]));
                let state =
                    [dt.mul_add(vt + 0.5 * dt * at, xt), dt.mul_add(at + 0.5 * dt * jerk, vt)];
                return (t > 0.0 && t <= self.h).then_some((t, state));
            }
        }
        None
    }

    /// The exit of a margin that may turn within the step.
    #[cold]
    #[inline(never)]
    fn long_way(&self, line: &Line, limit: f64, on_border: bool) -> Option<(f64, [f64; 2])> {
        arch().dispatch(LongWay { step: self, line, limit, on_border })
    }
}

struct LongWay<'a, 's> {
    step: &'a Step<'s>,
    line: &'a Line,
    limit: f64,
    on_border: bool,
}

impl WithSimd for LongWay<'_, '_> {
    type Output = Option<(f64, [f64; 2])>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Option<(f64, [f64; 2])> {
        let Self { step, line, limit, on_border } = self;
        let len = step.law.terms_of(step.h).min(COEFFICIENTS);
        let series = Series::new(step.law, step.from, step.a, step.w[1], len);
        let mut margin = Margin::new([line.alpha, line.beta, line.gamma], &series.d, series.len);
        if line.entered {
            margin.start_at_zero();
        }
        if on_border && line.before <= 64.0 * margin.noise() {
            return None;
        }
        margin.first_exit(limit).map(|t| (t, series.at(t)))
    }
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
