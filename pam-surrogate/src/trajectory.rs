//! One trajectory on its surface.
//!
//! Within a step from (x₀, v₀) the motion is split into the impulse of the force and the rest,
//!
//! ```text
//! x = w + β Z(τ)     Z = ∫∫ F dτ²      ẇ = u
//! v = u + β Ż(τ)     Ż = ∫ F dτ        u̇ = −β (f(x, v) + B v),   β = 1/m
//! ```
//!
//! and (w, u) take steps: where samples are equally far apart, Adams steps of a few intervals each, which take one evaluation
//! of the force; at the start of those and elsewhere Runge–Kutta steps. Both control their error. Runge–Kutta steps end at
//! observations, or between two that are far apart; the derivative at the end of one is that at the start of the next. The
//! backward pass is the exact transpose of the steps, for the steps that were taken.

use crate::adams::Adams;
use crate::forcing::{Line, StepForcing};
use crate::method::{Method, STAGES};
use crate::nodes::NodeForce;
use crate::surface::{Surface, SurfaceWorkspace, TooRough};
use pam_core::JointModel;
use pulp::Simd;

/// The joint but for its learned force.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mechanics {
    /// 1/m, 1/kg.
    pub(crate) per_mass: f64,
    /// B, kg/s.
    pub(crate) damping_kg_s: f64,
    /// |x| at which the motion is given up, mm.
    pub(crate) limit_mm: f64,
}

impl Mechanics {
    /// Those of a joint.
    pub(crate) fn of<F>(model: &JointModel<f64, F>) -> Self {
        let physical = model.physical();
        Self {
            per_mass: physical.mass_kg.recip(),
            damping_kg_s: model.auxiliary_damping_kg_s,
            limit_mm: model.geometry.displacement_limit_mm(physical.deformation),
        }
    }
}

/// Control of the steps.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Control {
    /// Largest estimated error of a step, mm; of a velocity at the rate of the joint.
    pub(crate) error_mm: f64,
    /// Longest step, s.
    pub(crate) longest_s: f64,
    /// Most steps of a trajectory.
    pub(crate) most_steps: usize,
}

/// A step that was taken.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Step {
    pub(crate) start_s: f64,
    pub(crate) length_s: f64,
    pub(crate) state: [f64; 2],
    /// u̇ at the stages.
    pub(crate) rates: [f64; STAGES],
    pub(crate) line: usize,
    /// First observation after the start of the step, and the number of those within it.
    pub(crate) observed: usize,
    pub(crate) count: usize,
}

/// Why a trajectory stopped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Stop {
    Rough { time_s: f64 },
    NonFinite { time_s: f64, step_s: f64 },
    StepTooSmall { time_s: f64, step_s: f64 },
    TooManySteps { time_s: f64 },
}

/// Where a trajectory starts and ends, and when it is observed: after its start.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Span<'a> {
    pub(crate) start_s: f64,
    pub(crate) end_s: f64,
    pub(crate) state: [f64; 2],
    pub(crate) observe_s: &'a [f64],
}

/// Derivatives of a loss but for those by the surface.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct MotionSums {
    pub(crate) start: [f64; 2],
    pub(crate) per_mass: f64,
    pub(crate) damping: f64,
}

/// A trajectory at work.
pub(crate) struct Motion<'m, 's, 'a> {
    pub(crate) method: &'m Method,
    pub(crate) adams: &'m Adams,
    pub(crate) mechanics: Mechanics,
    pub(crate) lines: &'m [Line],
    pub(crate) surface: &'s mut Surface<'a>,
    pub(crate) memory: &'s mut SurfaceWorkspace,
    pub(crate) force: &'s mut dyn NodeForce,
    pub(crate) forcing: &'s mut StepForcing,
    /// The patch in use.
    pub(crate) patch: usize,
}

impl Motion<'_, '_, '_> {
    /// Makes the patch at a point the one in use.
    #[inline(always)]
    pub(crate) fn enter(&mut self, at: [f64; 2]) -> Result<(), TooRough> {
        let inside = self.surface.patches.get(self.patch).is_some_and(|p| p.contains(at));
        if !inside {
            self.patch = self.surface.patch_at(at, self.memory, self.force)?;
        }
        Ok(())
    }

    #[inline(always)]
    pub(crate) fn rate<S: Simd>(&mut self, simd: S, at: [f64; 2]) -> Result<f64, TooRough> {
        self.enter(at)?;
        let [force, ..] = self.surface.patches[self.patch].force_and_slopes(simd, at);
        Ok(-self.mechanics.per_mass * (force + self.mechanics.damping_kg_s * at[1]))
    }
}
