//! One march through a trial.

use super::gas::Chambers;
use super::table::Air;
use super::trial::Trial;
use crate::effects::{
    AnyEffect, ChamberLaw, EffectOver, EffectScalar, Observed, Point, Rest, Restoring,
};
use pam_core::{JointModel, MuscleGeometry};
use pam_data::MassOrigin;
use pam_data::preprocess::LowPass;
use thiserror::Error;

/// The base model's own numbers.
#[derive(Debug, Clone, Copy)]
pub struct Base<S> {
    /// Mass m, kg.
    pub mass_kg: S,
    /// Deformation coefficient ν.
    pub deformation: S,
    /// Gas coefficient C, kPa·mm³/g.
    pub gas_coefficient: f64,
    /// Auxiliary damping B, kg/s.
    pub damping_kg_s: f64,
    /// Nominal size.
    pub geometry: MuscleGeometry,
}

impl Base<f64> {
    /// The numbers of a model.
    #[must_use]
    pub fn of<F>(model: &JointModel<f64, F>) -> Self {
        let p = model.physical();
        Self {
            mass_kg: p.mass_kg,
            deformation: p.deformation,
            gas_coefficient: p.gas_coefficient,
            damping_kg_s: model.auxiliary_damping_kg_s,
            geometry: model.geometry,
        }
    }
}

/// What a recording leaves uncertain, as deviations from the measured values.
#[derive(Debug, Clone, Copy)]
pub struct Nuisances<S> {
    /// Logarithm of the factor on the model's mass.
    pub log_mass: S,
    /// Logarithm of the factor on the model's deformation coefficient.
    pub log_deformation: S,
    /// Added to the displacement at the start, mm.
    pub start_mm: S,
    /// Added to the velocity at the start, mm/s.
    pub start_mm_s: S,
    /// Logarithms of the factors on the sealed masses.
    pub log_air: [S; 2],
}

impl<S: EffectScalar> Nuisances<S> {
    /// No deviation.
    #[must_use]
    pub fn none() -> Self {
        Self {
            log_mass: S::zero(),
            log_deformation: S::zero(),
            start_mm: S::zero(),
            start_mm_s: S::zero(),
            log_air: [S::zero(); 2],
        }
    }
}

/// The channels at the grid points, as the sensors would show them: mm, mm/s, kPa, kPa.
#[derive(Debug, Clone)]
pub struct Trajectory<S> {
    /// In the order of the state.
    pub channels: [Vec<S>; 4],
}

impl<S> Default for Trajectory<S> {
    fn default() -> Self {
        Self { channels: [const { Vec::new() }; 4] }
    }
}

/// A simulation that left the range of the joint.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("the simulation diverges at t = {time_s:.3} s")]
pub struct Diverged {
    /// When.
    pub time_s: f64,
}

/// An effect with its values in a simulation, and where its memory lies.
struct Part<'a, S> {
    effect: &'a dyn EffectOver<S>,
    p: &'a [S],
    memory: std::ops::Range<usize>,
}

/// Simulates a trial with effects. `values` holds the parameters and switches of each effect in turn.
///
/// # Errors
/// [`Diverged`] with the time, if the displacement leaves the range in which the chambers have a volume.
pub fn simulate<S: EffectScalar>(
    trial: &Trial,
    base: &Base<f64>,
    effects: &[&dyn AnyEffect],
    values: &[S],
    nuisances: &Nuisances<S>,
    out: &mut Trajectory<S>,
) -> Result<(), Diverged> {
    let (mut first_value, mut first_memory) = (0, 0);
    let parts: Vec<Part<'_, S>> = effects
        .iter()
        .map(|e| {
            let (v, m) = (e.info().value_len(), e.memory_len());
            let part = Part {
                effect: S::over(*e),
                p: &values[first_value..first_value + v],
                memory: first_memory..first_memory + m,
            };
            first_value += v;
            first_memory += m;
            part
        })
        .collect();
    let base = Base {
        mass_kg: nuisances.log_mass.exp().scaled(base.mass_kg),
        deformation: nuisances.log_deformation.exp().scaled(base.deformation),
        gas_coefficient: base.gas_coefficient,
        damping_kg_s: base.damping_kg_s,
        geometry: base.geometry,
    };
    let air = effects.iter().any(|e| e.info().air);
    let mut march = March::new(trial, &base, &parts, air, nuisances, first_memory);
    march.run(out)?;
    let [x, v, pf, pe] = &mut out.channels;
    let mut seen = Observed {
        step_s: trial.step_s,
        displacement_mm: x,
        velocity_mm_s: v,
        pressures_kpa: [pf, pe],
    };
    for part in &parts {
        part.effect.observe(part.p, &mut seen);
    }
    for (channel, low_pass) in out.channels.iter_mut().zip(&trial.low_pass) {
        if let Some(low_pass) = low_pass.filter(|_| channel.len() >= LowPass::shortest()) {
            *channel = low_pass.forward_backward(channel);
        }
    }
    Ok(())
}

/// The measured rest as it truly was.
fn true_rest<S: EffectScalar>(trial: &Trial, parts: &[Part<'_, S>]) -> Rest<S> {
    let c = S::constant;
    let mut rest = Rest {
        sealed_mm: c(trial.rest.sealed_mm),
        sealed_kpa: trial.rest.sealed_kpa.map(c),
        start_mm: c(trial.rest.start_mm),
        start_kpa: trial.rest.start_kpa.map(c),
    };
    // The sensors' effects are undone in the reverse order of their action.
    for part in parts.iter().rev() {
        part.effect.rest(part.p, &mut rest);
    }
    rest
}

struct March<'a, S> {
    trial: &'a Trial,
    base: &'a Base<S>,
    parts: &'a [Part<'a, S>],
    chambers: Chambers<'a, S>,
    inverse_mass: S,
    total_mass: S,
    delay_s: S,
    delayed: bool,
    start_kpa: [S; 2],
    x: S,
    v: S,
    air_g: [S; 2],
    friction_mn: S,
    memory: Vec<S>,
}

impl<'a, S: EffectScalar> March<'a, S> {
    fn new(
        trial: &'a Trial,
        base: &'a Base<S>,
        parts: &'a [Part<'a, S>],
        air_changed: bool,
        nuisances: &Nuisances<S>,
        memory_len: usize,
    ) -> Self {
        let rest = true_rest(trial, parts);
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
        let mut air_g = [trial.masses.flexor_g, trial.masses.extensor_g].map(S::constant);
        if trial.source.origin == MassOrigin::GasLaw {
            // The masses follow from the sealed reading: another true reading, other masses.
            let volumes = |x: S| {
                let v = base.geometry.volumes(x, base.deformation);
                [v.flexor_mm3, v.extensor_mm3]
            };
            let now = volumes(rest.sealed_mm);
            let measured = volumes(S::constant(trial.rest.sealed_mm));
            for i in 0..2 {
                let pressure = rest.sealed_kpa[i].scaled(1.0 / trial.rest.sealed_kpa[i]);
                air_g[i] = air_g[i] * pressure * now[i] / measured[i];
            }
        }
        for (air, log) in air_g.iter_mut().zip(nuisances.log_air) {
            *air *= log.exp();
        }
        let total_mass = base.mass_kg + inertia;
        Self {
            trial,
            base,
            parts,
            chambers: Chambers::new(base, law, air_changed, rest.sealed_mm),
            inverse_mass: total_mass.recip(),
            total_mass,
            delayed: delay_s.real() != 0.0,
            delay_s,
            start_kpa: rest.start_kpa,
            x,
            v: S::constant(trial.start_mm_s) + nuisances.start_mm_s,
            air_g,
            friction_mn: S::zero(),
            memory,
        }
    }

    fn run(&mut self, out: &mut Trajectory<S>) -> Result<(), Diverged> {
        let points = self.trial.points();
        for channel in &mut out.channels {
            channel.clear();
            channel.reserve(points);
        }
        let limit = self.base.geometry.displacement_limit_mm(self.base.deformation.real());
        let at_start = self.pressures();
        for k in 0..points {
            let now = self.pressures();
            out.channels[0].push(self.x);
            out.channels[1].push(self.v);
            for i in 0..2 {
                out.channels[2 + i].push(self.start_kpa[i] + now[i] - at_start[i]);
            }
            if k + 1 < points {
                self.step(k);
                let x = self.x.real();
                if !x.is_finite() || x.abs() >= limit {
                    return Err(Diverged { time_s: self.trial.step_s * (k + 1) as f64 });
                }
            }
        }
        Ok(())
    }

    fn pressures(&self) -> [S; 2] {
        let per_mass = self.chambers.pressures_per_mass(self.x);
        [self.air_g[0] * per_mass[0], self.air_g[1] * per_mass[1]]
    }

    /// The driving force at half step `fine` of the grid, mN.
    fn driving_mn(&self, fine: usize) -> S {
        let mut force = if self.delayed {
            let time = 0.5 * self.trial.step_s * fine as f64;
            self.trial.force.at(S::constant(time) - self.delay_s)
        } else {
            S::constant(self.trial.force.values_mn()[fine])
        };
        for part in self.parts {
            force = part.effect.drive(part.p, force);
        }
        force
    }

    /// The acceleration at a stage, mm/s².
    fn acceleration(&self, air: &Air<'_, S>, stage: Stage<S>) -> S {
        let Stage { x, v, driving_mn, time_s, since_step_s } = stage;
        let restoring = air.restoring_mn(x, v);
        let mut force = driving_mn - restoring - v.scaled(self.base.damping_kg_s);
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

    fn step(&mut self, k: usize) {
        let h = self.trial.step_s;
        let start_s = h * k as f64;
        let table = &self.trial.table;
        let masses = table.masses();
        let air = Air {
            table,
            change_g: [
                self.air_g[0] - S::constant(masses.flexor_g),
                self.air_g[1] - S::constant(masses.extensor_g),
            ],
        };
        let driving = [0, 1, 2].map(|i| self.driving_mn(2 * k + i));
        let (x, v) = (self.x, self.v);
        let stage = |x: S, v: S, half: usize| Stage {
            x,
            v,
            driving_mn: driving[half],
            time_s: start_s + 0.5 * h * half as f64,
            since_step_s: 0.5 * h * half as f64,
        };
        let a1 = self.acceleration(&air, stage(x, v, 0));
        let v2 = v + a1.scaled(0.5 * h);
        let a2 = self.acceleration(&air, stage(x + v.scaled(0.5 * h), v2, 1));
        let v3 = v + a2.scaled(0.5 * h);
        let a3 = self.acceleration(&air, stage(x + v2.scaled(0.5 * h), v3, 1));
        let v4 = v + a3.scaled(h);
        let a4 = self.acceleration(&air, stage(x + v3.scaled(h), v4, 2));
        let to_x = x + (v + (v2 + v3).scaled(2.0) + v4).scaled(h / 6.0);
        let to_v = v + (a1 + (a2 + a3).scaled(2.0) + a4).scaled(h / 6.0);
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
        let h = self.trial.step_s;
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
