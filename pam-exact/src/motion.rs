//! The motion of the joint inside each pattern.

use crate::atlas::{Atlas, AtlasMemory, Pattern};
use crate::cell::Window;
use crate::fundamental::{LONGEST, REACH, Response, Squared, spectral_bound, terms};
use crate::network::{PiecewiseNetwork, Plane};
use pam_core::simd::arch;
use pam_core::{ForceModel, JointModel, ModelError};
use pulp::{Simd, WithSimd};

/// Where trajectories are followed: far outside of anything the joint can do, so that a trajectory
/// that leaves it has diverged.
pub(crate) const WINDOW: Window = Window { first: [-1e5, 1e5], second: [-1e7, 1e7] };

/// A joint whose restoring force is a network of rectifiers, with sealed air: `m ẍ = u − f(x, ẋ) − B ẋ`.
#[derive(Debug, Clone)]
pub struct ExactMotion {
    /// The network.
    pub network: PiecewiseNetwork,
    /// Reflected mass m, kg.
    pub mass_kg: f64,
    /// Auxiliary damping B, kg/s.
    pub auxiliary_damping_kg_s: f64,
}

impl ExactMotion {
    /// The motion of a joint.
    ///
    /// # Errors
    /// [`ModelError::Shape`] if its force is no network of rectifiers.
    pub fn new<F: ForceModel<f64>>(model: &JointModel<f64, F>) -> Result<Self, ModelError> {
        Ok(Self {
            network: PiecewiseNetwork::new(&model.force)?,
            mass_kg: model.physical().mass_kg,
            auxiliary_damping_kg_s: model.auxiliary_damping_kg_s,
        })
    }
}

/// `ẍ + ζ ẋ + κ x = (u − a)/m` with all that a step needs.
///
/// What a step forward needs comes first, and together.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct Law {
    pub(crate) kappa: f64,
    pub(crate) zeta: f64,
    /// The constant part of the force, mN.
    pub(crate) offset_mn: f64,
    /// The longest step, s.
    pub(crate) longest_s: f64,
    /// The usual step.
    pub(crate) usual: Response,
    /// `|jerk| ≤ Σ of these × (|ẇ|, |v|, |acceleration|)` over the usual step.
    pub(crate) jerk: [f64; 3],
    /// First block of the pattern's sides, and how many there are; here too, so that a step need not look
    /// at the pattern.
    pub(crate) sides: u32,
    pub(crate) side_blocks: u32,
    /// Terms of the series for steps up to `covers_s`, the usual one or the longest.
    pub(crate) terms: u32,
    pub(crate) covers_s: f64,
    /// For the usual step, if anything is to be derived.
    pub(crate) squared: Squared,
}

/// Bound of the jerk over a step of length `h` from the forcing's slope, the velocity and the
/// acceleration at its start.
///
/// `j̇` aside, `|j| ≤ |w₁| + |κ||v| + |ζ||a|` at any time, with `|a| ≤ |a₀| + h j` and
/// `|v| ≤ |v₀| + h |a|`; solved for the largest `|j|`.
#[inline(always)]
pub(crate) fn jerk_bound(kappa: f64, zeta: f64, h: f64) -> [f64; 3] {
    let (k, z) = (kappa.abs(), zeta.abs());
    let scale = 1.0 / (1.0 - h * (k * h + z));
    [scale, scale * k, scale * (k * h + z)]
}

impl Law {
    #[inline(always)]
    fn new(motion: &ExactMotion, pattern: &Pattern, usual_s: f64, backward: bool) -> Self {
        let force = pattern.force;
        let kappa = force[1] / motion.mass_kg;
        let zeta = (force[2] + motion.auxiliary_damping_kg_s) / motion.mass_kg;
        let rho = spectral_bound(kappa, zeta);
        let longest_s = REACH / rho;
        let h = usual_s.min(longest_s);
        let terms = terms(rho * h);
        let squared = if backward {
            Response::with_square(kappa, zeta, h, terms).1
        } else {
            Squared::default()
        };
        Self {
            kappa,
            zeta,
            offset_mn: force[0],
            longest_s,
            usual: Response::new(kappa, zeta, h, terms),
            jerk: jerk_bound(kappa, zeta, h),
            sides: pattern.sides,
            side_blocks: pattern.side_blocks,
            terms: terms as u32,
            covers_s: h,
            squared,
        }
    }
}

impl Law {
    /// Acceleration at a state under the forcing `w`.
    #[inline(always)]
    pub(crate) fn acceleration(&self, [x, v]: [f64; 2], w: f64) -> f64 {
        (-self.zeta).mul_add(v, (-self.kappa).mul_add(x, w))
    }

    /// Bounds of acceleration and jerk over a step of length `h` that begins with velocity `v` and
    /// acceleration `a`, from [`jerk_bound`].
    #[inline(always)]
    pub(crate) fn bounds(&self, h: f64, bound: [f64; 3], v: f64, a: f64, rate: f64) -> [f64; 2] {
        let a = a.abs();
        let jerk = bound[2].mul_add(a, bound[1].mul_add(v.abs(), bound[0] * rate.abs()));
        [h.mul_add(jerk, a), jerk]
    }

    /// Both families of functions over a segment, for which zero stands for the usual length.
    #[inline(always)]
    pub(crate) fn responses(&self, length_s: f64) -> (Response, Squared) {
        if length_s == 0.0 {
            return (self.usual, self.squared);
        }
        Response::with_square(self.kappa, self.zeta, length_s, self.terms_of(length_s))
    }

    /// Terms of the series for a step of this length.
    #[inline(always)]
    pub(crate) fn terms_of(&self, h: f64) -> usize {
        if h <= self.covers_s { self.terms as usize } else { LONGEST }
    }
}

/// The patterns of one recording and the law of motion in each.
#[derive(Debug)]
pub(crate) struct Laws<'n> {
    pub(crate) motion: &'n ExactMotion,
    pub(crate) atlas: Atlas<'n>,
    pub(crate) laws: Vec<Law>,
    /// The length of most pieces, s.
    pub(crate) usual_s: f64,
    /// Whether derivatives are wanted too.
    backward: bool,
}

#[derive(Debug, Default)]
pub(crate) struct LawMemory {
    atlas: AtlasMemory,
    laws: Vec<Law>,
}

impl<'n> Laws<'n> {
    pub(crate) fn new(
        motion: &'n ExactMotion,
        masses_g: [f64; 2],
        usual_s: f64,
        backward: bool,
        memory: LawMemory,
    ) -> Self {
        let LawMemory { atlas, mut laws } = memory;
        laws.clear();
        let atlas = Atlas::new(&motion.network, Plane::of_motion(masses_g), WINDOW, atlas);
        Self { motion, atlas, laws, usual_s, backward }
    }

    pub(crate) fn into_memory(self) -> LawMemory {
        LawMemory { atlas: self.atlas.into_memory(), laws: self.laws }
    }

    /// Adds the laws of new patterns.
    #[inline(always)]
    fn catch_up(&mut self) {
        if self.laws.len() < self.atlas.len() {
            self.add_laws();
        }
    }

    #[cold]
    #[inline(never)]
    fn add_laws(&mut self) {
        arch().dispatch(AddLaws(self));
    }
}

struct AddLaws<'a, 'n>(&'a mut Laws<'n>);

impl WithSimd for AddLaws<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self(laws) = self;
        for id in laws.laws.len()..laws.atlas.len() {
            let pattern = laws.atlas.pattern(id as u32);
            let law = Law::new(laws.motion, pattern, laws.usual_s, laws.backward);
            laws.laws.push(law);
        }
    }
}

impl Laws<'_> {
    pub(crate) fn at(&mut self, point: [f64; 2]) -> u32 {
        let id = self.atlas.at(point);
        self.catch_up();
        id
    }

    #[inline(always)]
    pub(crate) fn behind(&mut self, id: u32, block: usize, lane: usize, entry: [f64; 2]) -> u32 {
        let new = self.atlas.behind(id, block, lane, Some(entry));
        self.catch_up();
        new
    }
}
