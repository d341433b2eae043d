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

/// How far a solve has come.
#[derive(Debug, Clone, Copy)]
struct Progress {
    state: [f64; 2],
    pattern: u32,
    /// The next piece, and the next observation.
    piece: usize,
    observation: usize,
}

impl Solve<'_, '_> {
    #[inline(always)]
    fn all_pieces<S: Simd>(&mut self, simd: S) -> Result<(), Stopped> {
        let pattern = self.laws.at(self.start);
        let mut now = Progress { state: self.start, pattern, piece: 0, observation: 0 };
        let stopped =
            |now: &Progress, kind, time_s| Err(Stopped { kind, time_s, reached: now.observation });
        loop {
            let tried = self.whole_pieces(simd, &mut now);
            let Some(piece) = self.pieces.get(now.piece) else { break };
            if !WINDOW.contains(now.state) {
                let kind = FailureKind::NonFinite { step_s: piece.length_s };
                return stopped(&now, kind, piece.start_s);
            }
            if let Err((kind, time_s)) = self.one_piece(simd, &piece, tried, &mut now) {
                return stopped(&now, kind, time_s);
            }
            if piece.observed {
                self.observed[2 * now.observation] = now.state[0];
                self.observed[2 * now.observation + 1] = now.state[1];
                now.observation += 1;
            }
            now.piece += 1;
        }
        if WINDOW.contains(now.state) {
            return Ok(());
        }
        let last = self.pieces.len().checked_sub(1).and_then(|last| self.pieces.get(last));
        let (step_s, time_s) = last.map_or((self.laws.usual_s, 0.0), |p| (p.length_s, p.start_s));
        stopped(&now, FailureKind::NonFinite { step_s }, time_s)
    }

    /// As many whole pieces of the usual length as fit into the pattern. Returns the step over the next
    /// one if it comes near to a side.
    #[inline(always)]
    fn whole_pieces<S: Simd>(&mut self, simd: S, now: &mut Progress) -> Option<Step> {
        let (laws, pieces) = (&*self.laws, self.pieces);
        let usual_s = laws.usual_s;
        let law = &laws.laws[now.pattern as usize];
        if law.longest_s < usual_s || law.side_blocks != 1 {
            return None;
        }
        let sides = &laws.atlas.sides(law.sides, 1)[0];
        let inverse_mass = 1.0 / laws.motion.mass_kg;
        let observed = self.observed.as_chunks_mut::<2>().0;
        let Progress { mut state, pattern, mut piece, mut observation } = *now;
        let mut before = margins(sides, state);
        let mut after = [0.0; LANES];
        let mut tried = None;
        while let Some(next) = pieces.get(piece) {
            if !is_usual(&next, usual_s) {
                break;
            }
            let w0 = (next.force_mn - law.offset_mn) * inverse_mass;
            let step = Step::usual(law, state, [w0, next.rate_mn_s * inverse_mass]);
            if !none_near(simd, sides, &before, &step, &mut after) {
                tried = Some(step);
                break;
            }
            if let Some(segments) = &mut self.segments {
                segments.push(Segment {
                    x: state[0],
                    v: state[1],
                    force_mn: next.force_mn,
                    length_s: 0.0,
                    pattern,
                    piece: piece as u32,
                });
            }
            state = step.end;
            before = after;
            if next.observed {
                observed[observation] = state;
                observation += 1;
            }
            piece += 1;
        }
        self.statistics.segments += piece - now.piece;
        *now = Progress { state, pattern, piece, observation };
        tried
    }

    /// One piece with whatever crossings there are; `tried` is the step over all of it, if it was tried
    /// and comes near to a side. What fails says when, s.
    #[inline(always)]
    fn one_piece<S: Simd>(
        &mut self,
        simd: S,
        piece: &Piece,
        mut tried: Option<Step>,
        now: &mut Progress,
    ) -> Result<(), (FailureKind, f64)> {
        let usual_s = self.laws.usual_s;
        let inverse_mass = 1.0 / self.laws.motion.mass_kg;
        let length_s = if is_usual(piece, usual_s) { usual_s } else { piece.length_s };
        let mut into_s = 0.0;
        let mut at_once = 0;
        let mut entered = NONE;
        while into_s < length_s {
            let law = &self.laws.laws[now.pattern as usize];
            let force_mn = piece.force_mn + piece.rate_mn_s * into_s;
            let rest = length_s - into_s;
            // No closure: it might be compiled without the wide instructions.
            let step = match tried.take() {
                Some(step) => step,
                None => {
                    let w0 = (force_mn - law.offset_mn) * inverse_mass;
                    let w = [w0, piece.rate_mn_s * inverse_mass];
                    Step::up_to(law, rest, usual_s, now.state, w)
                }
            };
            let sides = self.laws.atlas.sides(law.sides, law.side_blocks);
            match Exit::first(simd, sides, &step, entered, at_once > MOST_AT_ONCE) {
                None => {
                    let length = if step.h == usual_s { 0.0 } else { step.h };
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
                    now.pattern = self.laws.behind(now.pattern, exit.block, exit.lane, now.state);
                    self.statistics.crossings += 1;
                }
            }
            let time_s = piece.start_s + into_s;
            if !WINDOW.contains(now.state) {
                return Err((FailureKind::NonFinite { step_s: step.h }, time_s));
            }
            if self.statistics.crossings > self.most_crossings {
                let limit = self.most_crossings;
                return Err((FailureKind::TooManySteps { limit }, time_s));
            }
        }
        Ok(())
    }

    #[inline(always)]
    fn keep(&mut self, now: &Progress, force_mn: f64, length_s: f64) {
        self.statistics.segments += 1;
        if let Some(segments) = &mut self.segments {
            let Progress { state: [x, v], pattern, piece, .. } = *now;
            segments.push(Segment { x, v, force_mn, length_s, pattern, piece: piece as u32 });
        }
    }
}

/// Whether a piece is as long as most are.
#[inline(always)]
fn is_usual(piece: &Piece, usual_s: f64) -> bool {
    (piece.length_s - usual_s).abs() <= SAME_LENGTH * usual_s
}
