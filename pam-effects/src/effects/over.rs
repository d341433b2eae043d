//! Effects behind a pointer: the generic hooks of [`Effect`] for each scalar that the diagnosis runs
//! with.

use super::{Absorbed, ChamberLaw, DataScales, Effect, EffectInfo, Observed, Point, Rest};
use pam_autodiff::{Chunk, Var};
use pam_core::{AnyForce, JointModel, Scalar};

/// Number of derivatives that one simulation carries.
pub const WIDTH: usize = 8;

/// The scalar of sensitivities.
pub type Derivatives = Chunk<WIDTH>;

/// The hooks of an [`Effect`] for one scalar. Every effect has them.
pub trait EffectOver<S> {
    /// Memory of a joint that rests at `x`.
    fn begin(&self, p: &[S], x: S, memory: &mut [S]);
    /// Turns measured readings at rest into true ones.
    fn rest(&self, p: &[S], rest: &mut Rest<S>);
    /// The real force for a commanded one, mN.
    fn drive(&self, p: &[S], force_mn: S) -> S;
    /// Delay of the real force, s.
    fn delay_s(&self, p: &[S]) -> S;
    /// Force in the direction of +x, mN.
    fn force_mn(&self, p: &[S], at: &Point<'_, S>, memory: &[S]) -> S;
    /// Largest dry friction, mN.
    fn dry_friction_mn(&self, p: &[S], v: S) -> S;
    /// Mass that moves with the joint, kg.
    fn inertia_kg(&self, p: &[S]) -> S;
    /// Changes the gas law.
    fn chamber(&self, p: &[S], law: &mut ChamberLaw<S>);
    /// Moves the memory over a step.
    fn advance(&self, p: &[S], step_s: f64, from: S, to: S, memory: &mut [S]);
    /// Turns true series into measured ones.
    fn observe(&self, p: &[S], seen: &mut Observed<'_, S>);
}

impl<E: Effect, S: Scalar> EffectOver<S> for E {
    fn begin(&self, p: &[S], x: S, memory: &mut [S]) {
        Effect::begin(self, p, x, memory);
    }
    fn rest(&self, p: &[S], rest: &mut Rest<S>) {
        Effect::rest(self, p, rest);
    }
    fn drive(&self, p: &[S], force_mn: S) -> S {
        Effect::drive(self, p, force_mn)
    }
    fn delay_s(&self, p: &[S]) -> S {
        Effect::delay_s(self, p)
    }
    fn force_mn(&self, p: &[S], at: &Point<'_, S>, memory: &[S]) -> S {
        Effect::force_mn(self, p, at, memory)
    }
    fn dry_friction_mn(&self, p: &[S], v: S) -> S {
        Effect::dry_friction_mn(self, p, v)
    }
    fn inertia_kg(&self, p: &[S]) -> S {
        Effect::inertia_kg(self, p)
    }
    fn chamber(&self, p: &[S], law: &mut ChamberLaw<S>) {
        Effect::chamber(self, p, law);
    }
    fn advance(&self, p: &[S], step_s: f64, from: S, to: S, memory: &mut [S]) {
        Effect::advance(self, p, step_s, from, to, memory);
    }
    fn observe(&self, p: &[S], seen: &mut Observed<'_, S>) {
        Effect::observe(self, p, seen);
    }
}

/// An effect of any kind.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no effect",
    label = "an effect is needed here",
    note = "implement `Effect` for it, which makes it an `AnyEffect` as well"
)]
pub trait AnyEffect:
    EffectOver<f64> + EffectOver<Derivatives> + EffectOver<Var> + Send + Sync
{
    /// Id, parameters, words.
    fn info(&self) -> &'static EffectInfo;
    /// Values from which a fit may start.
    fn starts(&self, evidence: &DataScales) -> Vec<Vec<f64>>;
    /// Whether fitted values still are this effect.
    fn stands(&self, values: &[f64], evidence: &DataScales) -> bool;
    /// Number of remembered values.
    fn memory_len(&self) -> usize;
    /// Whether the effect depends on what was before.
    fn remembers(&self) -> bool;
    /// Moves the effect into a model without effects, where that can hold it.
    fn absorb(&self, values: &[f64], joint: &mut JointModel<f64, AnyForce<f64>>) -> Absorbed;
}

impl<E: Effect> AnyEffect for E {
    fn info(&self) -> &'static EffectInfo {
        Effect::info(self)
    }
    fn starts(&self, evidence: &DataScales) -> Vec<Vec<f64>> {
        Effect::starts(self, evidence)
    }
    fn stands(&self, values: &[f64], evidence: &DataScales) -> bool {
        Effect::stands(self, values, evidence)
    }
    fn memory_len(&self) -> usize {
        Effect::memory_len(self)
    }
    fn remembers(&self) -> bool {
        Effect::remembers(self)
    }
    fn absorb(&self, values: &[f64], joint: &mut JointModel<f64, AnyForce<f64>>) -> Absorbed {
        Effect::absorb(self, values, joint)
    }
}

/// A scalar that effects behind a pointer can run with.
pub trait EffectScalar: Scalar {
    /// The effect's hooks for this scalar.
    fn over(effect: &dyn AnyEffect) -> &dyn EffectOver<Self>;
}

impl EffectScalar for f64 {
    fn over(effect: &dyn AnyEffect) -> &dyn EffectOver<Self> {
        effect
    }
}

impl EffectScalar for Derivatives {
    fn over(effect: &dyn AnyEffect) -> &dyn EffectOver<Self> {
        effect
    }
}

/// For reverse sweeps: training.
impl EffectScalar for Var {
    fn over(effect: &dyn AnyEffect) -> &dyn EffectOver<Self> {
        effect
    }
}

impl std::fmt::Debug for dyn AnyEffect + '_ {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.info().id)
    }
}
