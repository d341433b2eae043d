//! One step of the joint.

use super::acting::Acting;
use super::laws::{Kept, Moment};
use super::network::ReluNetwork;
use super::{ATMOSPHERE_KPA, Plant};
use std::f64::consts::PI;

/// Nominal radius and length of a muscle, mm.
const RADIUS_MM: f64 = 5.0;
const LENGTH_MM: f64 = 200.0;

/// Elements of the Maxwell-slip loop.
const ELEMENTS: usize = 24;

/// Displacements between which rest is looked for, mm, and bisections.
const REST_WITHIN_MM: f64 = 8.0;
const BISECTIONS: usize = 60;

/// The joint with everything that remembers.
#[derive(Debug, Clone)]
pub(super) struct Joint {
    network: ReluNetwork,
    mass_kg: f64,
    deformation: f64,
    gas_coefficient: f64,
    /// Displacement, mm.
    pub x: f64,
    /// Velocity, mm/s.
    pub v: f64,
    /// Air in flexor and extensor, g.
    pub masses_g: [f64; 2],
    /// Pressures, kPa absolute.
    pub pressures_kpa: [f64; 2],
    /// Volumes at which the valves closed, mm³: an exponent other than one acts from there.
    sealed_mm3: [f64; 2],
    /// Force of the motor, mN.
    pub motor_mn: f64,
    /// Displacement of the damper of a creep element, mm.
    damper_mm: f64,
    /// Stretch of the elements of a loop, −1 to 1.
    stretch: [f64; ELEMENTS],
    /// What laws remember.
    pub kept: Kept,
}

impl Joint {
    /// The joint at rest under absolute pressures, where the restoring force and a steady load balance.
    pub(super) fn at_rest(plant: &Plant, kpa: [f64; 2], acting: &Acting) -> Self {
        let mut joint = Self {
            network: plant.network.clone(),
            mass_kg: plant.mass_kg,
            deformation: plant.deformation,
            gas_coefficient: plant.gas_coefficient,
            x: 0.0,
            v: 0.0,
            masses_g: [0.0; 2],
            pressures_kpa: kpa,
            sealed_mm3: [0.0; 2],
            motor_mn: 0.0,
            damper_mm: 0.0,
            stretch: [0.0; ELEMENTS],
            kept: Kept::default(),
        };
        // The air is that of the pressures at the displacement where the joint rests with it.
        for _ in 0..3 {
            joint.sealed_mm3 = joint.volumes(joint.x, acting);
            joint.masses_g = [0, 1].map(|i| kpa[i] * joint.sealed_mm3[i] / joint.gas_coefficient);
            let (mut low, mut high) = (-REST_WITHIN_MM, REST_WITHIN_MM);
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (low + high);
                if joint.restoring_mn(middle, 0.0, 0.0, acting) > acting.load_mn {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            joint.x = 0.5 * (low + high);
        }
        joint.damper_mm = joint.x;
        joint.pressures_kpa = joint.pressures(acting);
        joint.kept = Kept::at_rest(joint.pressures_kpa);
        joint
    }

    /// Volumes of flexor and extensor; beyond its displacement a slack tendon moves its chamber no further.
    fn volumes(&self, x: f64, acting: &Acting) -> [f64; 2] {
        let nu = self.deformation * (1.0 + acting.geometry);
        let limit = acting.slack.map_or(f64::INFINITY, |s| s[0]);
        let volume = |x: f64| {
            let radius = RADIUS_MM * (1.0 + nu * x / LENGTH_MM);
            PI * radius * radius * (LENGTH_MM - x)
        };
        [volume(x.min(limit)), volume((-x).min(limit))]
    }

    fn pressures(&self, acting: &Acting) -> [f64; 2] {
        let volumes = self.volumes(self.x, acting);
        let heated = acting.laws.heated_kpa(self.kept);
        [0, 1].map(|i| {
            let isothermal = self.gas_coefficient * self.masses_g[i] / volumes[i];
            let by_gas_law = if acting.exponent == 1.0 {
                isothermal
            } else {
                isothermal * (self.sealed_mm3[i] / volumes[i]).powf(acting.exponent - 1.0)
            };
            by_gas_law + heated[i]
        })
    }

    fn restoring_mn(&mut self, x: f64, v: f64, t: f64, acting: &Acting) -> f64 {
        let masses = self.masses_g;
        let mut force = self.network.force_mn(masses, x, v)
            * (1.0 + acting.scale)
            * (1.0 + acting.drift_per_s * t.max(0.0));
        if let Some([limit, loss]) = acting.slack
            && x.abs() > limit
        {
            let beyond = self.network.force_mn(masses, x, 0.0)
                - self.network.force_mn(masses, limit.copysign(x), 0.0);
            force -= loss * beyond;
        }
        force
    }

    /// Stretch of an element of a loop after `travel` mm.
    fn stretched(&self, element: usize, travel: f64, [_, slip, exponent]: [f64; 3]) -> f64 {
        let z = self.stretch[element];
        if exponent < 0.5 {
            // Maxwell slip (Iwan 1966): slip distances spread evenly from 0 to `slip`.
            let own = slip * (element as f64 + 0.5) / ELEMENTS as f64;
            return (z + travel / own).clamp(-1.0, 1.0);
        }
        // Bouc–Wen with β = γ = ½ (Wen 1976), by the midpoint rule.
        let rate = |z: f64| {
            let opposed = z * travel > 0.0;
            (1.0 - if opposed { z.abs().powf(exponent) } else { 0.0 }) * travel / slip
        };
        z + rate(z + 0.5 * rate(z))
    }

    /// Force of the loop (mN) after `travel` mm.
    fn loop_mn(&self, travel: f64, shape: [f64; 3]) -> f64 {
        if shape[2] < 0.5 {
            let sum: f64 = (0..ELEMENTS).map(|e| self.stretched(e, travel, shape)).sum();
            shape[0] * sum / ELEMENTS as f64
        } else {
            shape[0] * self.stretched(0, travel, shape)
        }
    }

    /// Everything but dry friction, mN, at the middle of a step.
    fn smooth_mn(&mut self, x: f64, v: f64, t: f64, dt: f64, acting: &Acting) -> f64 {
        let mut total = self.motor_mn + acting.load_mn - self.restoring_mn(x, v, t, acting);
        total -= acting.damping * v;
        if acting.cogging[0] != 0.0 {
            total -= acting.cogging[0] * (acting.cogging[1] * x).sin();
        }
        if acting.periodic[0] != 0.0 {
            total += acting.periodic[0] * (acting.periodic[1] * t).sin();
        }
        if let Some(shape) = acting.hysteresis {
            total -= self.loop_mn(0.5 * dt * v, shape);
        }
        if let Some([stiffness, time]) = acting.creep {
            let damper = self.damper_mm + 0.5 * dt / time * (x - self.damper_mm);
            total -= stiffness * (x - damper);
        }
        total + acting.laws.force_mn(self.moment(x, v, t), self.kept, 0.5 * dt)
    }

    /// What laws depend on, with the present pressures and force of the motor.
    fn moment(&self, x: f64, v: f64, t: f64) -> Moment {
        Moment { x, v, t, kpa: self.pressures_kpa, motor_mn: self.motor_mn }
    }

    /// Largest dry friction at a displacement and a velocity, mN.
    fn dry_mn(&self, x: f64, v: f64, t: f64, acting: &Acting) -> f64 {
        let gauge = 0.5 * (self.pressures_kpa[0] + self.pressures_kpa[1]) - ATMOSPHERE_KPA;
        let mut dry = acting.coulomb_mn + acting.load_friction * gauge;
        dry += acting.laws.dry_mn(self.moment(x, v, t), self.kept);
        if let Some([coulomb, still, velocity]) = acting.stribeck {
            dry += coulomb + (still - coulomb) * (-(v / velocity).powi(2)).exp();
        }
        dry
    }

    /// A step of `dt` s whose middle is at `t`, under a commanded force (mN).
    ///
    /// Displacement, velocity, displacement (Strang splitting); the forces are taken at the middle velocity, which a
    /// first guess gives. Dry friction is set-valued: the velocity is zero where friction can hold it there
    /// (Moreau's implicit step).
    pub(super) fn step(&mut self, command_mn: f64, t: f64, acting: &Acting, dt: f64) {
        let asked = (1.0 + acting.force_gain) * command_mn;
        let asked = asked.clamp(-acting.limit_mn, acting.limit_mn);
        let before = self.motor_mn;
        // With an infinite rate the lag is none.
        let approached =
            |share: f64| asked + (before - asked) * (-acting.actuator_rate * share * dt).exp();
        self.motor_mn = approached(0.5);
        let after = approached(1.0);

        let x = self.x + 0.5 * dt * self.v;
        let mass = self.mass_kg + acting.added_kg;
        let mut middle = self.v;
        let mut end = self.v;
        for _ in 0..2 {
            let total = self.smooth_mn(x, middle, t, dt, acting);
            let free = self.v + dt * total / mass;
            let held = dt * self.dry_mn(x, middle, t, acting) / mass;
            end = if free.abs() <= held { 0.0 } else { free - held.copysign(free) };
            middle = 0.5 * (self.v + end);
        }
        if let Some(shape) = acting.hysteresis {
            let travel = dt * middle;
            for e in 0..ELEMENTS {
                self.stretch[e] = self.stretched(e, travel, shape);
            }
        }
        if let Some([_, time]) = acting.creep {
            self.damper_mm += (1.0 - (-dt / time).exp()) * (x - self.damper_mm);
        }
        self.kept = acting.laws.moved(self.kept, self.moment(x, middle, t), dt);
        self.motor_mn = after;
        self.x = x + 0.5 * dt * end;
        self.v = end;
        for i in 0..2 {
            let rate = acting.leak_per_s[i];
            let over = 1.0 - ATMOSPHERE_KPA / self.pressures_kpa[i];
            self.masses_g[i] -= dt * rate * self.masses_g[i] * over;
        }
        if acting.crosstalk_per_s != 0.0 {
            let [flexor, extensor] = self.pressures_kpa;
            let flow = acting.crosstalk_per_s * self.masses_g[0] * (flexor - extensor) / flexor;
            self.masses_g[0] -= dt * flow;
            self.masses_g[1] += dt * flow;
        }
        let inflow = acting.laws.inflow_g_s(self.moment(x, middle, t), self.kept);
        for (mass, flow) in self.masses_g.iter_mut().zip(inflow) {
            *mass += dt * flow;
        }
        self.pressures_kpa = self.pressures(acting);
    }
}
