//! The joint itself, from first principles.
//!
//! Two McKibben muscles ([`muscle`]: [`braid`], [`wall`], [`losses`], [`gas`]) pull on the tendon of a
//! pulley; motor, gearbox and fixture are a reflected mass with dry [`friction`]. In the coordinate x of
//! the tendon, positive where the flexor contracts,
//!
//! ```text
//! M ẍ = F_e + T_f(x, ẋ) − T_e(−x, −ẋ) − dry friction,     T ≥ 0
//! ```
//!
//! Nothing here is shared with the models that learn the joint: it knows pressures where they know
//! masses, memory where they know none, and tendons that go slack.

pub mod braid;
pub mod friction;
pub mod gas;
pub mod losses;
pub mod muscle;
pub mod wall;

pub use braid::{Braid, BraidParameters};
pub use friction::DryFriction;
pub use gas::{Chamber, GasLedger, HeatExchange};
pub use losses::{LossParameters, MaxwellSlip};
pub use muscle::{Muscle, MuscleParameters, VolumeLaw};
pub use wall::WallParameters;

use friction::after_friction;
use pam_core::units::ATMOSPHERE_KPA;
use serde::{Deserialize, Serialize};

/// Parameters of the joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlantParameters {
    /// The flexor, which pulls towards +x.
    pub flexor: MuscleParameters,
    /// The extensor.
    pub extensor: MuscleParameters,
    /// Inertia of motor, gearbox and fixture seen at the tendon, kg.
    pub mass_kg: f64,
    /// Viscous friction of gearbox and bearings, N·s/m (kg/s).
    pub viscous_ns_m: f64,
    /// Dry friction of gearbox and bearings.
    pub friction: DryFriction,
    /// Heat exchange of the air.
    pub heat: HeatExchange,
    /// Leak of flexor and extensor, 1/s: `ṁ = −rate · m (P − P_atm)/P`.
    pub leak_per_s: [f64; 2],
}

/// Two equal muscles; 315 kg, near the 305 kg that the published model learned (the datasheet's rotor and
/// gearbox alone make 254 kg).
impl Default for PlantParameters {
    fn default() -> Self {
        Self {
            flexor: MuscleParameters::default(),
            extensor: MuscleParameters::default(),
            mass_kg: 315.0,
            viscous_ns_m: 0.0,
            friction: DryFriction::default(),
            heat: HeatExchange::default(),
            leak_per_s: [0.0; 2],
        }
    }
}

/// Actions on the joint during a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// Force along +x, N.
    pub force_n: f64,
    /// Dry friction beside that of the parameters, at rest and while sliding, N.
    pub dry_friction_n: f64,
    /// Factor of the muscles' net force.
    pub muscle_scale: f64,
    /// Air that enters each chamber in the step, g (negative: leaves).
    pub air_g: [f64; 2],
    /// Temperature of air that enters, K.
    pub air_k: f64,
}

impl Default for Drive {
    fn default() -> Self {
        Self {
            force_n: 0.0,
            dry_friction_n: 0.0,
            muscle_scale: 1.0,
            air_g: [0.0; 2],
            air_k: gas::ROOM_K,
        }
    }
}

/// The joint in motion.
///
/// A step is symmetric (half a drift, heat, kick, heat, half a drift), hence of second order where the
/// motion is smooth; dry friction is implicit and set-valued, Maxwell slip and adiabatic compression
/// are exact for the step's travel.
#[derive(Debug, Clone)]
pub struct Plant {
    displacement_mm: f64,
    velocity_mm_s: f64,
    muscles: [Muscle; 2],
    mass_kg: f64,
    viscous_ns_mm: f64,
    frictions: Vec<DryFriction>,
    leak_per_s: [f64; 2],
    force_n: f64,
    friction_n: f64,
}

/// +1 where a muscle shortens as x grows: flexor, extensor.
const SIDE: [f64; 2] = [1.0, -1.0];

impl Plant {
    /// A joint at rest at x = 0 with both chambers at atmospheric pressure. `laws` give the volume of each
    /// gas, `further` are dry frictions in addition to the joint's own.
    #[must_use]
    pub fn new(p: &PlantParameters, laws: [VolumeLaw; 2], further: &[DryFriction]) -> Self {
        let muscle = |m, law| Muscle::new(m, law, p.heat, ATMOSPHERE_KPA);
        let mut plant = Self {
            displacement_mm: 0.0,
            velocity_mm_s: 0.0,
            muscles: [muscle(&p.flexor, laws[0]), muscle(&p.extensor, laws[1])],
            mass_kg: p.mass_kg,
            viscous_ns_mm: 0.0,
            frictions: Vec::new(),
            leak_per_s: p.leak_per_s,
            force_n: 0.0,
            friction_n: 0.0,
        };
        plant.change(p, laws, further);
        plant
    }

    /// Goes on with other masses, losses, leaks and laws of the gas; muscles and air stay.
    pub fn change(&mut self, p: &PlantParameters, laws: [VolumeLaw; 2], further: &[DryFriction]) {
        let all = [p.friction].into_iter().chain(further.iter().copied());
        self.mass_kg = p.mass_kg;
        self.viscous_ns_mm = 1e-3 * p.viscous_ns_m;
        self.frictions.clear();
        self.frictions.extend(all.filter(|f| f.coulomb_n != 0.0 || f.static_n != 0.0));
        self.leak_per_s = p.leak_per_s;
        for (muscle, law) in self.muscles.iter_mut().zip(laws) {
            muscle.set_law(law);
        }
    }

    /// Displacement x, mm.
    #[must_use]
    pub fn displacement_mm(&self) -> f64 {
        self.displacement_mm
    }

    /// Velocity, mm/s; exactly zero while the joint sticks.
    #[must_use]
    pub fn velocity_mm_s(&self) -> f64 {
        self.velocity_mm_s
    }

    /// Flexor and extensor.
    #[must_use]
    pub fn muscles(&self) -> &[Muscle; 2] {
        &self.muscles
    }

    /// Absolute pressures, kPa.
    #[must_use]
    pub fn pressures_kpa(&self) -> [f64; 2] {
        [0, 1].map(|i| self.muscles[i].air.pressure_kpa())
    }

    /// Tensions of the tendons, N.
    #[must_use]
    pub fn tensions_n(&self) -> [f64; 2] {
        [0, 1].map(|i| self.muscles[i].tension_n(SIDE[i] * self.velocity_mm_s))
    }

    /// External force of the last step along +x, N.
    #[must_use]
    pub fn force_n(&self) -> f64 {
        self.force_n
    }

    /// Dry friction of the last step along +x, N.
    #[must_use]
    pub fn friction_n(&self) -> f64 {
        self.friction_n
    }

    /// Puts the joint somewhere, with the muscles and their air following.
    pub fn place(&mut self, displacement_mm: f64, velocity_mm_s: f64) {
        self.displacement_mm = displacement_mm;
        self.velocity_mm_s = velocity_mm_s;
        for (muscle, side) in self.muscles.iter_mut().zip(SIDE) {
            muscle.follow(side * displacement_mm, side * velocity_mm_s, 0.0);
        }
    }

    /// Fills the chambers to absolute pressures at room temperature.
    pub fn fill(&mut self, pressures_kpa: [f64; 2]) {
        for (muscle, kpa) in self.muscles.iter_mut().zip(pressures_kpa) {
            muscle.air.refill(kpa);
        }
    }

    /// Elastic restoring force of the sealed joint in slow motion, N: isothermal air, no losses, no
    /// friction, positive where the joint is pulled back towards −x. `masses_g` are the true ones.
    #[must_use]
    pub fn elastic_restoring_force_n(&self, displacement_mm: f64, masses_g: [f64; 2]) -> f64 {
        self.elastic_force_n(displacement_mm, masses_g, |muscle, c| muscle.gas_volume_mm3(c))
    }

    /// The same with chambers that follow every contraction.
    #[must_use]
    pub fn elastic_restoring_force_without_limit_n(
        &self,
        displacement_mm: f64,
        masses_g: [f64; 2],
    ) -> f64 {
        self.elastic_force_n(displacement_mm, masses_g, |muscle, c| muscle.following_volume_mm3(c))
    }

    fn elastic_force_n(
        &self,
        displacement_mm: f64,
        masses_g: [f64; 2],
        volume_mm3: impl Fn(&Muscle, f64) -> f64,
    ) -> f64 {
        let tension = |i: usize| {
            let muscle = &self.muscles[i];
            let contraction = SIDE[i] * displacement_mm;
            let kpa = masses_g[i] * pam_core::units::GAS_COEFFICIENT_KPA_MM3_PER_G
                / volume_mm3(muscle, contraction);
            muscle.elastic_tension_n(contraction, kpa - ATMOSPHERE_KPA).max(0.0)
        };
        tension(1) - tension(0)
    }

    /// One step of `step_s`.
    pub fn step(&mut self, step_s: f64, drive: &Drive) {
        let half = 0.5 * step_s;
        self.drift(half);
        for (i, muscle) in self.muscles.iter_mut().enumerate() {
            muscle.air.relax(half);
            let rate = self.leak_per_s[i];
            if rate != 0.0 {
                let kpa = muscle.air.pressure_kpa();
                let lost = rate * muscle.air.mass_g * (kpa - ATMOSPHERE_KPA) / kpa;
                muscle.air.exchange_air(-lost * step_s, gas::ROOM_K);
            }
            muscle.air.exchange_air(drive.air_g[i], drive.air_k);
        }
        self.kick(step_s, drive);
        for muscle in &mut self.muscles {
            muscle.air.relax(half);
        }
        self.drift(half);
    }

    /// Moves the joint along a prescribed motion, as a displacement-controlled test, and returns the force
    /// that this takes without friction, N.
    pub fn drag(&mut self, displacement_mm: f64, velocity_mm_s: f64, step_s: f64) -> f64 {
        for muscle in &mut self.muscles {
            muscle.air.relax(step_s);
        }
        self.displacement_mm = displacement_mm;
        self.velocity_mm_s = velocity_mm_s;
        for (muscle, side) in self.muscles.iter_mut().zip(SIDE) {
            muscle.follow(side * displacement_mm, side * velocity_mm_s, step_s);
        }
        let [flexor, extensor] = self.tensions_n();
        extensor - flexor + self.viscous_ns_mm * velocity_mm_s
    }

    /// Largest dry friction at a speed, N.
    #[must_use]
    pub fn friction_limit_n(&self, velocity_mm_s: f64) -> f64 {
        self.frictions.iter().map(|f| f.limit_n(velocity_mm_s)).sum()
    }

    /// Kinetic and elastic energy and availability of the air, mJ. With closed valves and no force it
    /// never grows.
    #[must_use]
    pub fn energy_mj(&self) -> f64 {
        let v = 1e-3 * self.velocity_mm_s;
        let muscles: f64 = self.muscles.iter().map(Muscle::energy_mj).sum();
        1e3 * 0.5 * self.mass_kg * v * v + muscles
    }

    fn drift(&mut self, time_s: f64) {
        self.displacement_mm += time_s * self.velocity_mm_s;
        for (muscle, side) in self.muscles.iter_mut().zip(SIDE) {
            muscle.follow(side * self.displacement_mm, side * self.velocity_mm_s, time_s);
        }
    }

    fn kick(&mut self, step_s: f64, drive: &Drive) {
        // 1 N on 1 kg is 1000 mm/s².
        let gain = 1e3 * step_s / self.mass_kg;
        let mut force = drive.force_n;
        let mut viscous = self.viscous_ns_mm;
        for (muscle, side) in self.muscles.iter().zip(SIDE) {
            let (tension, damping) = muscle.pull();
            force += drive.muscle_scale * side * tension;
            viscous += drive.muscle_scale * damping;
        }
        // The viscous force acts at the mean of the velocities before and after.
        let v = self.velocity_mm_s;
        let denominator = 1.0 + 0.5 * gain * viscous;
        let change = gain * (force - viscous * v) / denominator;
        let limit_n = |v: f64| self.friction_limit_n(v) + drive.dry_friction_n;
        let sliding = gain * limit_n(v) / denominator;
        let breaking = gain * limit_n(0.0) / denominator;
        self.velocity_mm_s = after_friction(v, change, sliding, breaking);
        self.force_n = drive.force_n;
        self.friction_n = (self.velocity_mm_s - v - change) * denominator / gain;
    }
}
