//! The backward pass in time: costates by the transposed propagators, moments pattern by pattern.

use crate::forcing::Pieces;
use crate::fundamental::StepMoments;
use crate::motion::Laws;
use crate::solve::Segment;
use pam_core::simd::arch;
use pulp::{Simd, WithSimd};

/// Integrals of the velocity's costate times `1`, `x` and `ẋ` over all the time spent in a pattern.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PatternMoments {
    pub(crate) one: f64,
    pub(crate) x: f64,
    pub(crate) v: f64,
}

/// What the backward pass gives besides the moments.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct AdjointSums {
    /// With respect to the state at the start.
    pub(crate) start: [f64; 2],
    /// With respect to m and B.
    pub(crate) mass: f64,
    pub(crate) damping: f64,
}

/// The backward pass of one trajectory.
pub(crate) struct Adjoint<'a, 'n> {
    pub(crate) laws: &'a Laws<'n>,
    pub(crate) pieces: Pieces<'a>,
    pub(crate) segments: &'a [Segment],
    /// Cotangents of the observed states, `[observation, (x, ẋ)]`.
    pub(crate) cotangents: &'a [f64],
    /// One for each pattern, zeros on entry.
    pub(crate) moments: &'a mut [PatternMoments],
}

impl Adjoint<'_, '_> {
    pub(crate) fn run(self) -> AdjointSums {
        arch().dispatch(self)
    }
}

impl WithSimd for Adjoint<'_, '_> {
    type Output = AdjointSums;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> AdjointSums {
        let mass = self.laws.motion.mass_kg;
        let inverse_mass = 1.0 / mass;
        let mut costate = [0.0; 2];
        let mut sums = AdjointSums::default();
        let mut piece_index = u32::MAX;
        let mut observation = self.cotangents.len() / 2;
        let (mut force, mut along_v) = (0.0, 0.0);
        let mut end = self.segments.len();
        while end > 0 {
            // The run of segments of one pattern.
            let pattern = self.segments[end - 1].pattern;
            let law = &self.laws.laws[pattern as usize];
            let mut own = PatternMoments::default();
            while end > 0 && self.segments[end - 1].pattern == pattern {
                let s = &self.segments[end - 1];
                end -= 1;
                let piece = self.pieces.get(s.piece as usize).expect("segments lie in pieces");
                if s.piece != piece_index {
                    piece_index = s.piece;
                    if piece.observed {
                        observation -= 1;
                        costate[0] += self.cotangents[2 * observation];
                        costate[1] += self.cotangents[2 * observation + 1];
                    }
                }
                let w =
                    [(s.force_mn - law.offset_mn) * inverse_mass, piece.rate_mn_s * inverse_mass];
                let (e, q) = law.responses(s.length_s);
                let m = StepMoments::new((&e, &q), (law.kappa, law.zeta), [s.x, s.v], w, costate);
                costate = e.pull_back(law.kappa, costate);
                own.one += m.one;
                own.x += m.x;
                own.v += m.v;
                force += w[0] * m.one + w[1] * m.time;
            }
            force -= law.kappa * own.x + law.zeta * own.v;
            along_v += own.v;
            let total = &mut self.moments[pattern as usize];
            total.one += own.one;
            total.x += own.x;
            total.v += own.v;
        }
        sums.start = costate;
        // ẍ = (u − f − B ẋ)/m: its derivatives are −ẍ/m and −ẋ/m.
        sums.mass = -force * inverse_mass;
        sums.damping = -along_v * inverse_mass;
        sums
    }
}
