//! The forward solve: closed-form steps from piece to piece of the force, cut where a unit changes sign.

use crate::atlas::NONE;
use crate::crossing::{Line, Step};
use crate::forcing::Piece;
use crate::fundamental::{Response, spectral_bound, terms};
use crate::hull::none;
use crate::motion::{Laws, WINDOW, jerk_bound};
use crate::network::LANES;
use crate::sides::Sides;
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
    let mut margins = [0.0; LANES];
    for (i, margin) in margins.iter_mut().enumerate() {
        *margin = sides.gamma[i].mul_add(v, sides.beta[i].mul_add(x, sides.alpha[i]));
    }
    margins
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
    let (x, v) = (simd.splat_f64s(end[0]), simd.splat_f64s(end[1]));
    let (off_x, off_v) = (simd.splat_f64s(off[0]), simd.splat_f64s(off[1]));
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
