//! The forward solve: closed-form steps from piece to piece of the force, cut where a unit changes sign.

use crate::atlas::NONE;
use crate::crossing::Exit;
use crate::forcing::{Piece, Pieces};
use crate::motion::{Laws, WINDOW};
use crate::network::LANES;
use crate::step::{Step, margins, none_near};
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
    /// Observations before it.
    pub(crate) reached: usize,
}

/// Sign changes without progress in time after which the state counts as being on the border: the field
/// is continuous, so it does not matter from which side it is followed.
const MOST_AT_ONCE: usize = 64;
/// Lengths that differ by less than this part are the same.
const SAME_LENGTH: f64 = 1e-9;

/// A solve in progress.
pub(crate) struct Solve<'a, 'n> {
    pub(crate) laws: &'a mut Laws<'n>,
    pub(crate) pieces: Pieces<'a>,
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
            let law = &self.laws.laws[pattern as usize];
            let mut tried = None;
            if law.longest_s >= usual_s && law.side_blocks == 1 {
                let sides = &self.laws.atlas.sides(law.sides, 1)[0];
                let mut before = margins(sides, state);
                let mut after = [0.0; LANES];
                while let Some(piece) = self.pieces.get(index) {
                    if !is_usual(&piece, usual_s) {
                        break;
                    }
                    let w0 = (piece.force_mn - law.offset_mn) * inverse_mass;
                    let step = Step::usual(law, state, [w0, piece.rate_mn_s * inverse_mass]);
                    if !none_near(simd, sides, &before, &step, &mut after) {
                        tried = Some(step);
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
                    state = step.end;
                    before = after;
                    if piece.observed {
                        self.observed[2 * observation] = state[0];
                        self.observed[2 * observation + 1] = state[1];
                        observation += 1;
                    }
                    index += 1;
                }
            }
            let Some(piece) = self.pieces.get(index) else { break };
            if !WINDOW.contains(state) {
                let kind = FailureKind::NonFinite { step_s: piece.length_s };
                return Err(Stopped { kind, time_s: piece.start_s, reached: observation });
            }
            self.one_piece(simd, &piece, index as u32, tried, &mut state, &mut pattern)
                .map_err(|stopped| Stopped { reached: observation, ..stopped })?;
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
        let last = self.pieces.len().checked_sub(1).and_then(|last| self.pieces.get(last));
        let (step_s, time_s) = last.map_or((usual_s, 0.0), |p| (p.length_s, p.start_s));
        let kind = FailureKind::NonFinite { step_s };
        Err(Stopped { kind, time_s, reached: observation })
    }

    /// One piece with whatever crossings there are; `tried` is the step over all of it, if it was tried
    /// and comes near to a side.
    #[inline(always)]
    fn one_piece<S: Simd>(
        &mut self,
        simd: S,
        piece: &Piece,
        index: u32,
        mut tried: Option<Step>,
        state: &mut [f64; 2],
        pattern: &mut u32,
    ) -> Result<(), Stopped> {
        let usual_s = self.laws.usual_s;
        let inverse_mass = 1.0 / self.laws.motion.mass_kg;
        let length_s = if is_usual(piece, usual_s) { usual_s } else { piece.length_s };
        let mut into_s = 0.0;
        let mut at_once = 0;
        let mut entered = NONE;
        while into_s < length_s {
            let law = &self.laws.laws[*pattern as usize];
            let force_mn = piece.force_mn + piece.rate_mn_s * into_s;
            let rest = length_s - into_s;
            let step = tried.take().unwrap_or_else(|| {
                let w0 = (force_mn - law.offset_mn) * inverse_mass;
                Step::up_to(law, rest, usual_s, *state, [w0, piece.rate_mn_s * inverse_mass])
            });
            let sides = self.laws.atlas.sides(law.sides, law.side_blocks);
            match Exit::first(simd, sides, &step, entered, at_once > MOST_AT_ONCE) {
                None => {
                    let length = if step.h == usual_s { 0.0 } else { step.h };
                    self.keep(*state, force_mn, length, *pattern, index);
                    *state = step.end;
                    into_s = if step.h == rest { length_s } else { into_s + step.h };
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
            let stopped = |kind| Err(Stopped { kind, time_s: piece.start_s + into_s, reached: 0 });
            if !WINDOW.contains(*state) {
                return stopped(FailureKind::NonFinite { step_s: step.h });
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
}

/// Whether a piece is as long as most are.
#[inline(always)]
fn is_usual(piece: &Piece, usual_s: f64) -> bool {
    (piece.length_s - usual_s).abs() <= SAME_LENGTH * usual_s
}
