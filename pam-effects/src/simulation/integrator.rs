//! The joint with its effects, step by step.

use super::base::{Base, BaseForce};
use super::gas::Chambers;
use super::measured::Measured;
use super::nuisances::Nuisances;
use super::parts::{Part, Parts};
use super::record::ResampledRecord;
use super::trajectory::Diverged;
use crate::effects::{ChamberLaw, EffectScalar, Point, Restoring};
use pam_data::MassOrigin;
use pam_solvers::rk4_step;

/// The state of the extended joint, moved step by step: Runge–Kutta steps of fourth order, and dry friction as a
/// set-valued force.
pub(crate) struct JointIntegrator<'a, S, F> {
    record: &'a ResampledRecord,
    base: &'a Base<S>,
    force: &'a F,
    parts: &'a [Part<'a, S>],
    chambers: Chambers<'a, S>,
    inverse_mass: S,
    total_mass: S,
    delay_s: S,
    delayed: bool,
    lead_s: f64,
    start_kpa: [S; 2],
    x: S,
    v: S,
    air_g: [S; 2],
    friction_mn: S,
    memory: Vec<S>,
}

impl<'a, S: EffectScalar, F: BaseForce<S>> JointIntegrator<'a, S, F> {
    pub(crate) fn new(
        record: &'a ResampledRecord,
        base: &'a Base<S>,
        force: &'a F,
        parts: &'a Parts<'a, S>,
        measured: &Measured<S>,
        nuisances: &Nuisances<S>,
    ) -> Self {
        let mut rest = measured.rest;
        // The sensors' effects are undone in the reverse order of their action.
        for part in parts.list.iter().rev() {
            part.effect.rest(part.p, &mut rest);
        }
        let (memory_len, air_changed) = (parts.memory_len, parts.air);
        let parts = &parts.list;
        let mut law = ChamberLaw::plain();
        let (mut inertia, mut delay_s) = (S::zero(), S::zero());
        for part in parts {
            part.effect.chamber(part.p, &mut law);
            inertia += part.effect.inertia_kg(part.p);
            delay_s += part.effect.delay_s(part.p);
        }
        let x = rest.start_mm + nuisances.start_mm;
        let mut memory = vec![S::zero(); memory_len];
        for part in parts {
            part.effect.begin(part.p, x, &mut memory[part.memory.clone()]);
        }
        let mut air_g = [record.masses.flexor_g, record.masses.extensor_g].map(S::constant);
        if record.source.origin == MassOrigin::GasLaw {
            // The masses follow from the sealed reading: another true reading, other masses.
            let volumes = |x: S| {
                let v = base.geometry.volumes(x, base.deformation);
                [v.flexor_mm3, v.extensor_mm3]
            };
            let now = volumes(rest.sealed_mm);
            let measured = volumes(S::constant(record.rest.sealed_mm));
            for i in 0..2 {
                let pressure = rest.sealed_kpa[i].scaled(1.0 / record.rest.sealed_kpa[i]);
                air_g[i] = air_g[i] * pressure * now[i] / measured[i];
            }
        }
        for (air, log) in air_g.iter_mut().zip(nuisances.log_air) {
            *air *= log.exp();
        }
        let total_mass = base.mass_kg + inertia;
        Self {
            record,
            base,
            force,
            parts,
            chambers: Chambers::new(base, law, air_changed, rest.sealed_mm),
            inverse_mass: total_mass.recip(),
            total_mass,
            delayed: delay_s.real() != 0.0,
            lead_s: nuisances.lead_samples * record.sample_s,
            delay_s,
            start_kpa: rest.start_kpa,
            x,
            v: measured.start_mm_s + nuisances.start_mm_s,
            air_g,
            friction_mn: S::zero(),
            memory,
        }
    }

    /// Integrates to the end and writes the true channels. `at_point` is called at every grid point, before the
    /// step from it.
    pub(crate) fn run(
        &mut self,
        channels: &mut [Vec<S>; 4],
        mut at_point: impl FnMut(usize, &Self),
    ) -> Result<(), Diverged> {
        let points = self.record.points();
        for channel in channels.iter_mut() {
            channel.clear();
            channel.reserve(points);
        }
        let limit = self.limit_mm();
        let at_start = self.pressures();
        for k in 0..points {
            at_point(k, self);
            let now = self.pressures();
            channels[0].push(self.x);
            channels[1].push(self.v);
            for i in 0..2 {
                channels[2 + i].push(self.start_kpa[i] + now[i] - at_start[i]);
            }
            if k + 1 < points {
                self.step(k);
                let x = self.x.real();
                if !x.is_finite() || x.abs() >= limit {
                    return Err(Diverged { time_s: self.record.step_s * (k + 1) as f64 });
                }
            }
        }
        Ok(())
    }

    /// Pressures now, kPa, before the readings at the start are put right.
    pub(crate) fn pressures(&self) -> [S; 2] {
        let per_mass = self.chambers.pressures_per_mass(self.x);
        [self.air_g[0] * per_mass[0], self.air_g[1] * per_mass[1]]
    }

    /// The driving force at half step `fine` of the grid, mN.
    fn driving_mn(&self, fine: usize) -> S {
        let recorded = &self.record.force;
        let time_s = 0.5 * self.record.step_s * fine as f64 + self.lead_s;
        let mut force = if self.delayed {
            recorded.at(S::constant(time_s) - self.delay_s)
        } else if self.lead_s != 0.0 {
            S::constant(recorded.at(time_s))
        } else {
            S::constant(recorded.values_mn()[fine])
        };
        for part in self.parts {
            force = part.effect.drive(part.p, force);
        }
        force
    }

    /// The acceleration at a stage, mm/s².
    fn acceleration(&self, air: &F::Sealed<'_>, stage: Stage<S>) -> S {
        let Stage { x, v, driving_mn, time_s, since_step_s } = stage;
        let restoring = air.restoring_mn(x, v);
        let mut force = driving_mn - restoring - v * self.base.damping_kg_s;
        if !self.parts.is_empty() {
            let at = Point {
                time_s,
                displacement_mm: x,
                velocity_mm_s: v,
                step_start_mm: self.x,
                since_step_s,
                restoring_mn: restoring,
                base: air,
            };
            for part in self.parts {
                force += part.effect.force_mn(part.p, &at, &self.memory[part.memory.clone()]);
            }
            force += self.chambers.feedback_mn(x, self.air_g);
        }
        (force - self.friction_mn) * self.inverse_mass
    }

    /// Number of values in a state.
    pub(crate) fn state_len(&self) -> usize {
        5 + self.memory.len()
    }

    /// Writes the state: displacement, velocity, air, dry friction, memory.
    pub(crate) fn state_into(&self, out: &mut [S]) {
        out[..5].copy_from_slice(&[self.x, self.v, self.air_g[0], self.air_g[1], self.friction_mn]);
        out[5..].copy_from_slice(&self.memory);
    }

    /// Goes on from a state.
    pub(crate) fn restore(&mut self, state: &[S]) {
        (self.x, self.v, self.air_g) = (state[0], state[1], [state[2], state[3]]);
        self.friction_mn = state[4];
        self.memory.copy_from_slice(&state[5..]);
    }

    /// Pressures that stand in the data at the start, kPa.
    pub(crate) fn start_kpa(&self) -> [S; 2] {
        self.start_kpa
    }

    /// Displacement beyond which the chambers have no volume, mm.
    fn limit_mm(&self) -> f64 {
        self.base.geometry.displacement_limit_mm(self.base.deformation.real())
    }

    /// Does step `k` of the grid.
    pub(crate) fn step(&mut self, k: usize) {
        let h = self.record.step_s;
        let start_s = self.record.since_start_s + h * k as f64;
        let force = self.force;
        let air = force.sealed(self.air_g);
        let driving = [0, 1, 2].map(|i| self.driving_mn(2 * k + i));
        let (x, v) = (self.x, self.v);
        let rate = |half: usize, [x, v]: [S; 2]| {
            let since_step_s = 0.5 * h * half as f64;
            let (driving_mn, time_s) = (driving[half], start_s + since_step_s);
            [v, self.acceleration(&air, Stage { x, v, driving_mn, time_s, since_step_s })]
        };
        let [to_x, to_v] = rk4_step([x, v], rate(0, [x, v]), h, rate);
        let (to_x, to_v) = self.after_friction(to_x, to_v);
        for part in self.parts {
            let memory = &mut self.memory[part.memory.clone()];
            part.effect.advance(part.p, h, x, to_x, memory);
        }
        if self.chambers.leaks() {
            self.air_g = self.chambers.leaked(to_x, h, self.air_g);
        }
        (self.x, self.v) = (to_x, to_v);
    }

    /// Dry friction over the step: the smooth step was made with the friction force that held before; the
    /// one that holds now is the nearest to standstill that the limit allows (a projection, Moreau 1988).
    fn after_friction(&mut self, to_x: S, to_v: S) -> (S, S) {
        let mut limit = S::zero();
        for part in self.parts {
            limit += part.effect.dry_friction_mn(part.p, to_v);
        }
        if limit.real() <= 0.0 {
            return (to_x, to_v);
        }
        let h = self.record.step_s;
        let holding = self.friction_mn + (self.total_mass * to_v).scaled(1.0 / h);
        let slides = holding.real().abs() > limit.real();
        let before = self.friction_mn;
        if slides {
            self.friction_mn = if holding.real() > 0.0 { limit } else { -limit };
            let change = (self.friction_mn - before) * self.inverse_mass;
            (to_x - change.scaled(0.5 * h * h), to_v - change.scaled(h))
        } else {
            self.friction_mn = holding;
            (self.x + self.v.scaled(0.5 * h), S::zero())
        }
    }
}

/// One evaluation point of the step.
struct Stage<S> {
    x: S,
    v: S,
    driving_mn: S,
    time_s: f64,
    since_step_s: f64,
}
