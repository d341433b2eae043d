//! Dynamic dispatch: effects of any type in one list, for the scalars that simulations run with.
//!
//! The hooks of [`Effect`] are generic over the scalar, so there is no `dyn Effect`. [`AnyEffect`] offers them
//! for plain numbers, [`Derivatives`] and tape variables; every [`Effect`] implements it, and so does an effect with a
//! [course in time](super::Timed).

use super::timed::Timed;
use super::{
    Absorbed, ChamberLaw, Command, DataScales, Effect, EffectInfo, Hooks, MemoryStart, Observed,
    Point, Rest,
};
use pam_autodiff::{Chunk, Var};
use pam_core::{AnyForce, JointModel, Scalar};

/// Number of derivatives that one simulation carries.
pub const WIDTH: usize = 12;

/// The scalar of sensitivities.
pub type Derivatives = Chunk<WIDTH>;

/// Number of derivatives of the narrower scalar.
pub const NARROW: usize = 4;

/// The scalar of a few sensitivities, which takes about two thirds of the time.
pub type FewDerivatives = Chunk<NARROW>;

/// Number of derivatives of the wider scalar.
pub const WIDE: usize = 36;

/// The scalar of many sensitivities: what does not depend on their number, such as the slopes of long expressions, is worked out
/// once for all of them.
pub type ManyDerivatives = Chunk<WIDE>;

/// Declares an object-safe trait with methods of [`Effect`] and implements it for every effect.
macro_rules! dispatch {
    ([$($declared:tt)*] [$($implemented:tt)*] {
        $(fn $hook:ident(&$this:ident $(, $argument:ident: $type:ty)*) $(-> $out:ty)?;)+
    } { $($more:tt)* } { $($more_implemented:tt)* }) => {
        $($declared)* {
            $($more)*
            $(
                #[doc = concat!("See [`Effect::", stringify!($hook), "`].")]
                fn $hook(&$this $(, $argument: $type)*) $(-> $out)?;
            )+
        }

        $($implemented)* {
            $($more_implemented)*
            $(fn $hook(&$this $(, $argument: $type)*) $(-> $out)? {
                Effect::$hook($this $(, $argument)*)
            })+
        }
    };
}

dispatch! {
    [
        /// The hooks of an [`Effect`] for one scalar.
        pub trait EffectHooks<S>
    ]
    [impl<E: Effect, S: Scalar> EffectHooks<S> for E] {
        fn begin(&self, p: &[S], at: &MemoryStart<S>, memory: &mut [S]);
        fn rest(&self, p: &[S], rest: &mut Rest<S>);
        fn drive(&self, p: &[S], command: &Command<S>, memory: &mut [S]) -> S;
        fn force_mn(&self, p: &[S], at: &Point<'_, S>, memory: &[S]) -> S;
        fn dry_friction_mn(&self, p: &[S], at: &Point<'_, S>, memory: &[S]) -> S;
        fn air_g_s(&self, p: &[S], at: &Point<'_, S>, memory: &[S]) -> [S; 2];
        fn advance(&self, p: &[S], end: &Point<'_, S>, memory: &mut [S]);
        fn observe(&self, p: &[S], seen: &mut Observed<'_, S>);
    }
    {
        /// See [`Effect::delay_s`]; at a time since the excitation began (s), on which it depends for an effect that
        /// [changes in time](AnyEffect::changes_in_time) alone.
        fn delay_s(&self, p: &[S], time_s: f64) -> S;
        /// See [`Effect::inertia_kg`]; at a time, as [`delay_s`](Self::delay_s).
        fn inertia_kg(&self, p: &[S], time_s: f64) -> S;
        /// See [`Effect::chamber`]; at a time, as [`delay_s`](Self::delay_s).
        fn chamber(&self, p: &[S], time_s: f64, law: &mut ChamberLaw<S>);
        /// The share of the effect that is there at a time.
        fn share(&self, p: &[S], time_s: f64) -> f64;
    }
    {
        fn share(&self, _p: &[S], _time_s: f64) -> f64 {
            1.0
        }
        fn delay_s(&self, p: &[S], _time_s: f64) -> S {
            Effect::delay_s(self, p)
        }
        fn inertia_kg(&self, p: &[S], _time_s: f64) -> S {
            Effect::inertia_kg(self, p)
        }
        fn chamber(&self, p: &[S], _time_s: f64, law: &mut ChamberLaw<S>) {
            Effect::chamber(self, p, law);
        }
    }
}

dispatch! {
    [
        /// An [`Effect`] of any type.
        #[diagnostic::on_unimplemented(
            message = "`{Self}` is no effect",
            label = "an effect is needed here",
            note = "implement `Effect` for it, which makes it an `AnyEffect` as well"
        )]
        pub trait AnyEffect:
            EffectHooks<f64>
            + EffectHooks<Derivatives>
            + EffectHooks<FewDerivatives>
            + EffectHooks<ManyDerivatives>
            + EffectHooks<Var>
            + Send
            + Sync
    ]
    [impl<E: Effect> AnyEffect for E] {
        fn info(&self) -> &'static EffectInfo;
        fn definition(&self) -> Option<&'static str>;
        fn may_stick_later(&self, values: &[f64]) -> bool;
        fn starts(&self, scales: &DataScales) -> Vec<Vec<f64>>;
        fn stands(&self, values: &[f64], scales: &DataScales) -> bool;
        fn acts_where_off(&self) -> bool;
        fn changes_gas(&self) -> bool;
        fn hooks(&self) -> Hooks;
        fn memory_len(&self) -> usize;
        fn remembers(&self) -> bool;
        fn moves_with_the_joint(&self) -> bool;
        fn absorb(&self, values: &[f64], joint: &mut JointModel<f64, AnyForce<f64>>) -> Absorbed;
    }
    {
        /// Its course, if it begins, ends or grows at a time.
        fn course(&self) -> Option<&Timed> {
            None
        }
        /// Whether delay, inertia or law of the chambers depend on the time.
        fn changes_in_time(&self) -> bool {
            false
        }
    }
    {}
}

/// A scalar for which [`AnyEffect`] offers the hooks.
pub trait EffectScalar: Scalar {
    /// The hooks for this scalar.
    fn hooks(effect: &dyn AnyEffect) -> &dyn EffectHooks<Self>;

    /// Whether it has no derivative that differs from zero.
    fn is_constant(&self) -> bool;
}

macro_rules! effect_scalars {
    ($($scalar:ty: $constant:expr),+) => {
        $(impl EffectScalar for $scalar {
            fn hooks(effect: &dyn AnyEffect) -> &dyn EffectHooks<Self> {
                effect
            }

            fn is_constant(&self) -> bool {
                let constant: fn(&Self) -> bool = $constant;
                constant(self)
            }
        })+
    };
}

effect_scalars!(
    f64: |_| true,
    Derivatives: |number| number.derivatives.iter().all(|d| *d == 0.0),
    FewDerivatives: |number| number.derivatives.iter().all(|d| *d == 0.0),
    ManyDerivatives: |number| number.derivatives.iter().all(|d| *d == 0.0),
    // A variable of a tape may have any derivatives.
    Var: |_| false
);

impl std::fmt::Debug for dyn AnyEffect + '_ {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.info().id)
    }
}
