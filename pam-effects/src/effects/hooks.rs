//! Where an effect can act.

use super::{Before, DataScales, EffectInfo, Group, Hooks};
use pam_core::units::{ATMOSPHERE_KPA, MN_PER_N};
use pam_core::{AnyForce, JointModel, Scalar};

/// The base model's restoring force of one recording.
pub trait Restoring<S> {
    /// The force (mN) at displacement `x` (mm) and velocity `v` (mm/s) with the air that is sealed in.
    fn restoring_mn(&self, x: S, v: S) -> S;
}

/// Displacement, velocity and driving force where a step started, and the memory stands.
#[derive(Debug, Clone, Copy)]
pub struct StepStart<S> {
    /// Displacement, mm.
    pub displacement_mm: S,
    /// Velocity, mm/s.
    pub velocity_mm_s: S,
    /// Force of the drive, mN.
    pub driving_mn: S,
}

/// The joint where a memory begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MemoryStart<S> {
    /// Displacement, mm.
    pub displacement_mm: S,
    /// Absolute pressures of flexor and extensor, kPa.
    pub pressures_kpa: [S; 2],
}

/// The joint at one instant inside a step.
#[derive(Clone, Copy)]
pub struct Point<'a, S> {
    /// Time since the excitation began, s. Where the joint turns or breaks away, it has derivatives.
    pub time_s: S,
    /// Displacement, mm.
    pub displacement_mm: S,
    /// Velocity, mm/s; zero where surfaces stick.
    pub velocity_mm_s: S,
    /// Force of the drive, mN.
    pub driving_mn: S,
    /// The joint at the start of the step.
    pub step_start: &'a StepStart<S>,
    /// Time since the start of the step, s.
    pub since_step_s: f64,
    /// The base model's restoring force here, mN, if it was worked out.
    pub restoring: Option<&'a S>,
    /// The base model's restoring force elsewhere.
    pub base: &'a dyn Restoring<S>,
    /// The air of the chambers.
    pub air: &'a dyn Air<S>,
}

/// The air of the chambers at an instant. Pressures are worked out where an effect asks for them.
pub trait Air<S> {
    /// Absolute pressures of flexor and extensor at a displacement (mm), kPa.
    fn pressures_kpa(&self, displacement_mm: S) -> [S; 2];

    /// Masses of flexor and extensor, g.
    fn masses_g(&self) -> [S; 2];
}

impl<S: Scalar> Point<'_, S> {
    /// The base model's restoring force here, mN.
    #[must_use]
    pub fn restoring_mn(&self) -> S {
        self.restoring
            .copied()
            .unwrap_or_else(|| self.base.restoring_mn(self.displacement_mm, self.velocity_mm_s))
    }

    /// Absolute pressures of flexor and extensor, kPa.
    #[must_use]
    pub fn pressures_kpa(&self) -> [S; 2] {
        self.air.pressures_kpa(self.displacement_mm)
    }

    /// Mean gauge pressure of both chambers, kPa; not below zero.
    #[must_use]
    pub fn mean_gauge_kpa(&self) -> S {
        let [flexor, extensor] = self.pressures_kpa();
        let mean = (flexor + extensor).scaled(0.5) - S::constant(ATMOSPHERE_KPA);
        mean.maximum(S::zero())
    }
}

/// A joint in a given state, for an effect by itself outside a simulation: [`point`](Self::point) is what the effect sees.
#[derive(Debug, Clone, Copy)]
pub struct FixedState<S> {
    /// Time since the excitation began, s.
    pub time_s: f64,
    /// Displacement, velocity and force of the drive.
    pub motion: StepStart<S>,
    /// The base model's restoring force, mN, here and elsewhere.
    pub restoring_mn: S,
    /// Absolute pressures of flexor and extensor, kPa.
    pub pressures_kpa: [S; 2],
    /// Air in flexor and extensor, g.
    pub masses_g: [S; 2],
}

impl<S: Scalar> FixedState<S> {
    /// At rest in the middle, without forces, at absolute pressures (kPa).
    #[must_use]
    pub fn at_rest(pressures_kpa: [S; 2]) -> Self {
        Self {
            time_s: 0.0,
            motion: StepStart {
                displacement_mm: S::zero(),
                velocity_mm_s: S::zero(),
                driving_mn: S::zero(),
            },
            restoring_mn: S::zero(),
            pressures_kpa,
            masses_g: [S::zero(); 2],
        }
    }

    /// The joint as an effect sees it, at the start of a step.
    #[must_use]
    pub fn point(&self) -> Point<'_, S> {
        let StepStart { displacement_mm, velocity_mm_s, driving_mn } = self.motion;
        Point {
            time_s: S::constant(self.time_s),
            displacement_mm,
            velocity_mm_s,
            driving_mn,
            step_start: &self.motion,
            since_step_s: 0.0,
            restoring: Some(&self.restoring_mn),
            base: self,
            air: self,
        }
    }
}

impl<S: Scalar> Restoring<S> for FixedState<S> {
    fn restoring_mn(&self, _x: S, _v: S) -> S {
        self.restoring_mn
    }
}

impl<S: Scalar> Air<S> for FixedState<S> {
    fn pressures_kpa(&self, _displacement_mm: S) -> [S; 2] {
        self.pressures_kpa
    }

    fn masses_g(&self) -> [S; 2] {
        self.masses_g
    }
}

/// A force that is commanded at an instant.
#[derive(Debug, Clone, Copy)]
pub struct Command<S> {
    /// Time since the excitation began, s.
    pub time_s: f64,
    /// Time since the last command, s; 0 for the first one.
    pub since_s: f64,
    /// The force, mN.
    pub force_mn: S,
}

/// The reading at rest and the measured start, on their way from what was measured to what was.
#[derive(Debug, Clone, Copy)]
pub struct Rest<S> {
    /// Time of the first sample since the excitation began, s.
    pub start_s: f64,
    /// Displacement at the sealed reading, mm.
    pub sealed_mm: S,
    /// Sealed pressures of flexor and extensor, kPa absolute.
    pub sealed_kpa: [S; 2],
    /// Recorded force of the drive at the first sample, mN; there is none at the sealed reading.
    pub start_force_mn: f64,
    /// Displacement at the first sample, mm.
    pub start_mm: S,
    /// Pressures at the first sample, kPa absolute.
    pub start_kpa: [S; 2],
}

/// How the two chambers obey their gas law: `P = C m V_s⁻¹ (V_s/V(x))ⁿ` with the volume `V_s` at the
/// sealed reading, ν scaled, and displacement of a chamber that stops following.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChamberLaw<S> {
    /// Factor of the deformation coefficient ν.
    pub deformation_factor: S,
    /// Exponent n of the volume; 1 is isothermal.
    pub exponent: S,
    /// Contraction beyond which a chamber stops following x, mm.
    pub contraction_limit_mm: Option<S>,
    /// Share of the contraction beyond the limit that it still follows: 0 where it stops.
    pub beyond_limit: S,
    /// Leak rates of flexor and extensor, `ṁ = −rate · m (P − P_atm)/P`, 1/s.
    pub leak_per_s: [S; 2],
    /// Whether the leak rates may differ from zero.
    pub leaks: bool,
    /// Whether pressures that differ from the base model's push on the joint, by `ΔP dV/dx`.
    pub feeds_back: bool,
}

/// Measured series on the simulation's own uniform grid.
#[derive(Debug)]
pub struct Observed<'a, S> {
    /// Time of the first value since the excitation began, s.
    pub start_s: f64,
    /// Time between two values, s.
    pub step_s: f64,
    /// Recorded force of the drive every half step, mN.
    pub half_step_forces_mn: &'a [f64],
    /// Displacement, mm.
    pub displacement_mm: &'a mut [S],
    /// Velocity, mm/s.
    pub velocity_mm_s: &'a mut [S],
    /// Pressures of flexor and extensor, kPa absolute.
    pub pressures_kpa: [&'a mut [S]; 2],
    /// The measured history before the series, if they belong to a part of a recording.
    pub before: Option<&'a Before>,
}

impl<S: Scalar> Observed<'_, S> {
    /// Recorded force of the drive at a value, N.
    #[must_use]
    pub fn force_n(&self, k: usize) -> f64 {
        self.half_step_forces_mn[2 * k] / MN_PER_N
    }

    /// Takes the velocity anew as the central difference of the displacement.
    pub fn renew_velocity(&mut self) {
        let (x, v) = (&*self.displacement_mm, &mut *self.velocity_mm_s);
        let last = x.len() - 1;
        for (k, v) in v.iter_mut().enumerate() {
            let (a, b) = (k.saturating_sub(1), (k + 1).min(last));
            *v = (x[b] - x[a]).scaled(1.0 / ((b - a).max(1) as f64 * self.step_s));
        }
    }
}

/// Fate of an effect in a model without effects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Absorbed {
    /// The model's own numbers hold it, exactly.
    Exactly,
    /// It is of the instruments: the joint itself is as the model has it.
    OfInstruments,
    /// The model cannot hold it.
    LeftOut,
}

/// A known effect as a part of a model.
///
/// `p` holds the values of [`EffectInfo::parameters`] followed by the switches. All hooks are neutral
/// by default.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no effect",
    label = "an effect is needed here",
    note = "implement `Effect`: `info` and `starts`, and the hooks where it acts; see \
            `pam-diagnose/examples/own_effect.rs`"
)]
pub trait Effect: Send + Sync + 'static {
    /// The entry of the vocabulary, or a description of its own.
    fn info(&self) -> &'static EffectInfo;

    /// The file that defines the effect, if it is [an expression](crate::expression); a saved model carries it.
    fn definition(&self) -> Option<&'static str> {
        None
    }

    /// Values from which a fit may start, at magnitudes that these data could show. The derivative of
    /// the simulation must not vanish there; scales (gaps, lengths, times) are spread over a grid.
    fn starts(&self, scales: &DataScales) -> Vec<Vec<f64>>;

    /// Whether fitted values still are this effect. Where they reach the limit at which it is only another
    /// one by this name (a loop of no slip is dry friction), or contradict its sign, the name is refuted.
    fn stands(&self, values: &[f64], scales: &DataScales) -> bool {
        let _ = (values, scales);
        true
    }

    /// The hooks that it has. Hooks that are left out here are not called; simulations with few of them take less time.
    fn hooks(&self) -> Hooks {
        Hooks::ALL
    }

    /// Number of remembered values.
    fn memory_len(&self) -> usize {
        0
    }

    /// Returns true if the effect still changes the simulation when all its magnitudes have their [`off`](crate::effects::ParameterInfo::off) values, as
    /// a contraction limit does, which depends on a displacement alone.
    fn acts_where_off(&self) -> bool {
        false
    }

    /// `true` if the effect changes the gas law of the chambers.
    fn changes_gas(&self) -> bool {
        false
    }

    /// Whether the effect depends on what was before the present motion, so that a recording cannot be
    /// begun in its middle.
    fn remembers(&self) -> bool {
        self.memory_len() > 0
    }

    /// Whether its memory moves in the balance of forces, from [`begin`](Self::begin) on by [`advance`](Self::advance). That
    /// of a drive moves in [`drive`](Self::drive).
    fn moves_with_the_joint(&self) -> bool {
        self.info().group != Group::Sensing
    }

    /// Memory of a joint that rests.
    fn begin<S: Scalar>(&self, p: &[S], at: &MemoryStart<S>, memory: &mut [S]) {
        let _ = (p, at, memory);
    }

    /// Turns measured readings at rest into true ones.
    fn rest<S: Scalar>(&self, p: &[S], rest: &mut Rest<S>) {
        let _ = (p, rest);
    }

    /// The real force for a commanded one, mN. It is called first with `since_s = 0` and then at the middle and at the end of
    /// every step; between two commands the force runs straight. A drive that has a state keeps it in `memory` and moves it
    /// here.
    fn drive<S: Scalar>(&self, p: &[S], command: &Command<S>, memory: &mut [S]) -> S {
        let _ = (p, memory);
        command.force_mn
    }

    /// Delay of the real force behind the recorded one, s.
    fn delay_s<S: Scalar>(&self, p: &[S]) -> S {
        let _ = p;
        S::zero()
    }

    /// Force on the joint in the direction of +x, mN.
    fn force_mn<S: Scalar>(&self, p: &[S], at: &Point<'_, S>, memory: &[S]) -> S {
        let _ = (p, at, memory);
        S::zero()
    }

    /// Largest dry friction of a contact, mN. Friction is set-valued: the joint sticks while less than this is
    /// needed to hold it.
    fn dry_friction_mn<S: Scalar>(&self, p: &[S], at: &Point<'_, S>, memory: &[S]) -> S {
        let _ = (p, at, memory);
        S::zero()
    }

    /// `true` if there may be dry friction later where there is none at the start.
    fn may_stick_later(&self, values: &[f64]) -> bool {
        let _ = values;
        false
    }

    /// Air that enters flexor and extensor, g/s; asked for if [`changes_gas`](Self::changes_gas).
    fn air_g_s<S: Scalar>(&self, p: &[S], at: &Point<'_, S>, memory: &[S]) -> [S; 2] {
        let _ = (p, at, memory);
        [S::zero(); 2]
    }

    /// Mass that moves with the joint, kg.
    fn inertia_kg<S: Scalar>(&self, p: &[S]) -> S {
        let _ = p;
        S::zero()
    }

    /// Changes the gas law of the chambers; called if [`changes_gas`](Self::changes_gas).
    fn chamber<S: Scalar>(&self, p: &[S], law: &mut ChamberLaw<S>) {
        let _ = (p, law);
    }

    /// Moves the memory over a step that ends at `end`.
    fn advance<S: Scalar>(&self, p: &[S], end: &Point<'_, S>, memory: &mut [S]) {
        let _ = (p, end, memory);
    }

    /// Turns true series into measured ones.
    fn observe<S: Scalar>(&self, p: &[S], seen: &mut Observed<'_, S>) {
        let _ = (p, seen);
    }

    /// Moves the effect into the numbers of a model without effects, where that can hold it.
    fn absorb(&self, values: &[f64], joint: &mut JointModel<f64, AnyForce<f64>>) -> Absorbed {
        let _ = (values, joint);
        match self.info().group {
            Group::Sensing => Absorbed::OfInstruments,
            Group::Mechanics | Group::Gas => Absorbed::LeftOut,
        }
    }
}
