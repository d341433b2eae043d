//! The joint with its effects, step by step.
//!
//! A step of the grid is cut into equal substeps as [stability and accuracy](super::steps) ask. A substep is one
//! Runge–Kutta step of fourth order; with dry friction, [`friction`](super::friction) cuts it where the joint turns or
//! breaks away.

use super::base::{Base, BaseForce, SealedForce};
use super::gas::Chambers;
use super::gas_table::GasTable;
use super::input::FineForce;
use super::measured::Measured;
use super::nuisances::Nuisances;
use super::parts::{Part, Parts};
use super::record::ResampledRecord;
use super::substep::{At, SealedAir, Substep};
use super::trajectory::Diverged;
use super::trial::LedForce;
use crate::effects::{
    Air, ChamberLaw, Command, EffectScalar, Hooks, MemoryStart, Point, Restoring, StepStart,
};
use pam_core::SealedMasses;
use pam_data::MassOrigin;

/// The state of the extended joint, moved step by step: Runge–Kutta steps of fourth order, and dry friction as a
/// set-valued force.
pub(crate) struct JointIntegrator<'a, S, F> {
    pub(super) record: &'a ResampledRecord,
    base: &'a Base<S>,
    pub(super) force: &'a F,
    parts: &'a [Part<'a, S>],
    /// The hooks that any of them has.
    hooks: Hooks,
    chambers: Chambers<'a, S>,
    /// Their law as a table, where that is faster.
    gas: Option<GasTable<S>>,
    inverse_mass: S,
    /// Substeps of a step of the grid.
    substeps: usize,
    /// Whether there is dry friction.
    rough: bool,
    /// Whether inertia, delay and chambers depend on the time.
    changes_in_time: bool,
    /// Which effects were wholly there when inertia and chambers were last worked out; `None` if one of them was in part.
    whole: Option<Vec<bool>>,
    delay_s: S,
    /// Displacement at which the chambers were sealed, mm.
    sealed_mm: S,
    lead_samples: f64,
    /// The recorded force at half steps of the grid with this lead, if it is worked out.
    led_mn: Option<&'a [f64]>,
    /// The part of the recorded force that may be noise, at half steps with the lead where that is worked out, and the share of
    /// it that is noise; none where that is nothing.
    noise: Option<(&'a FineForce, Option<&'a [f64]>, S)>,
    start_kpa: [S; 2],
    pub(super) x: S,
    pub(super) v: S,
    pub(super) air_g: [S; 2],
    /// The driving force now, mN.
    driving_mn: S,
    memory: Vec<S>,
}

/// The part of the recorded force that may be noise, and the share of it that is; none where that is nothing.
fn noise_of<S: EffectScalar>(
    record: &ResampledRecord,
    share: S,
) -> Option<(&FineForce, Option<&[f64]>, S)> {
    let nothing = share.is_constant() && share.real() == 0.0;
    record.doubtful_force.as_ref().filter(|_| !nothing).map(|f| (f, None, share))
}

/// Friction that holds less than this, mN, is none.
const LEAST_FRICTION_MN: f64 = 1e-9;

impl<'a, S: EffectScalar, F: BaseForce<S>> JointIntegrator<'a, S, F> {
    pub(crate) fn new(
        record: &'a ResampledRecord,
        base: &'a Base<S>,
        force: &'a F,
        parts: &'a Parts<'a, S>,
        measured: &Measured<S>,
        nuisances: &Nuisances<S>,
        substeps: usize,
    ) -> Self {
        let mut rest = measured.rest;
        // The sensors' effects are undone in the reverse order of their action.
        for part in parts.list.iter().rev() {
            part.effect.rest(part.p, &mut rest);
        }
        let (memory_len, air_changed, hooks) = (parts.memory_len, parts.air, parts.hooks);
        let changes_in_time = parts.changes_in_time;
        let parts = &parts.list;
        let start_s = record.since_start_s;
        let x = rest.start_mm + nuisances.start_mm;
        let began_at = record.before.as_ref().map_or(x, |b| S::constant(b.start_mm()));
        let law = law_of(parts, start_s);
        let chambers = Chambers::new(base, law, air_changed, rest.sealed_mm);
        let mut air_g = [record.masses.flexor_g, record.masses.extensor_g].map(S::constant);
        if record.source.origin == MassOrigin::GasLaw {
            // The masses follow from the sealed reading: another true reading or another volume, other masses.
            let now = chambers.sealed_mm3();
            let v = base.geometry.volumes(S::constant(record.rest.sealed_mm), base.deformation);
            let measured = [v.flexor_mm3, v.extensor_mm3];
            for i in 0..2 {
                let pressure = rest.sealed_kpa[i].scaled(1.0 / record.rest.sealed_kpa[i]);
                air_g[i] = air_g[i] * pressure * now[i] / measured[i];
            }
        }
        for (air, log) in air_g.iter_mut().zip(nuisances.log_air) {
            *air *= log.exp();
        }
        let mut joint = Self {
            record,
            base,
            force,
            parts,
            hooks,
            chambers,
            gas: None,
            inverse_mass: (base.mass_kg + inertia_kg(parts, start_s)).recip(),
            substeps,
            rough: false,
            changes_in_time,
            whole: None,
            led_mn: if nuisances.lead_samples == 0.0 {
                Some(record.force.values_mn())
            } else {
                None
            },
            noise: noise_of(record, nuisances.force_noise_share),
            lead_samples: nuisances.lead_samples,
            delay_s: delay_s(parts, start_s),
            sealed_mm: rest.sealed_mm,
            start_kpa: rest.start_kpa,
            x,
            v: measured.start_mm_s + nuisances.start_mm_s,
            air_g,
            driving_mn: S::zero(),
            memory: vec![S::zero(); memory_len],
        };
        joint.begin_memory(began_at);
        joint.remember_before();
        joint.driving_mn = joint.driving_at(0, 0.0);
        // What may stick later is not asked now: it may ask for the base model's force, which is asked in steps alone.
        joint.rough =
            joint.parts.iter().any(|part| part.may_stick_later) || joint.sticks_at_start();
        joint
    }

    /// The same with the recorded force at half steps with its lead ([`FineForce::led`]).
    pub(super) fn driven_by(mut self, led: &'a LedForce) -> Self {
        if let Some((_, noise, _)) = &mut self.noise {
            *noise = led.doubtful_mn.as_deref();
        }
        Self { led_mn: Some(&led.whole_mn), ..self }
    }

    /// The same with the [gas law as a table](GasTable), if it is changed and stays as it is.
    pub(super) fn with_gas_table(mut self) -> Self {
        let stays = !self.changes_in_time && !self.chambers.leaks() && !self.hooks.air_flow;
        if stays && self.chambers.is_changed_smoothly() {
            let range = self.record.ranges[0];
            self.gas = GasTable::new(&self.chambers, self.air_g, range, self.limit_mm());
        }
        self
    }

    /// The memory of a joint that rests at a displacement, mm.
    fn begin_memory(&mut self, displacement_mm: S) {
        if self.memory.is_empty() {
            return;
        }
        let pressures_kpa = self.air().pressures_kpa(displacement_mm);
        let at = MemoryStart { displacement_mm, pressures_kpa };
        for part in self.parts {
            part.effect.begin(part.p, &at, &mut self.memory[part.memory.clone()]);
        }
    }

    /// Whether there is dry friction at rest at the start.
    fn sticks_at_start(&self) -> bool {
        let air = self.force.sealed(self.air_g);
        let step = self.whole_step(self.record.since_start_s, [self.driving_mn; 3]);
        let at = At { share: S::zero(), x: self.x, v: S::zero() };
        self.friction_limit_mn(&air, &step, &at).real() > LEAST_FRICTION_MN
    }

    /// Integrates up to a number of grid points and writes the true channels at all steps. `at_point` is called at every
    /// step, before it is done.
    #[inline(always)]
    pub(crate) fn run(
        &mut self,
        grid_points: usize,
        channels: &mut [Vec<S>; 4],
        mut at_point: impl FnMut(usize, &Self),
    ) -> Result<(), Diverged> {
        let points = (grid_points.max(1) - 1) * self.record.steps_per_point + 1;
        for channel in channels.iter_mut() {
            channel.clear();
            channel.reserve(points);
        }
        let limit = self.limit_mm();
        self.at_point(0);
        let at_start = self.pressures();
        let offset_kpa = [0, 1].map(|i| self.start_kpa[i] - at_start[i]);
        for k in 0..points {
            self.at_point(k);
            at_point(k, self);
            let now = self.pressures();
            channels[0].push(self.x);
            channels[1].push(self.v);
            for i in 0..2 {
                channels[2 + i].push(offset_kpa[i] + now[i]);
            }
            if k + 1 < points {
                self.step(k);
                let x = self.x.real();
                if !x.is_finite() || x.abs() >= limit {
                    return Err(Diverged { time_s: self.record.fine_step_s() * (k + 1) as f64 });
                }
            }
        }
        Ok(())
    }

    /// Takes inertia and chambers as they are at a step of the grid.
    pub(crate) fn at_point(&mut self, k: usize) {
        if self.changes_in_time {
            self.at_time(self.record.since_start_s + self.record.fine_step_s() * k as f64);
        }
    }

    /// Takes them as they are in the middle of a step.
    #[inline(always)]
    pub(super) fn at_middle(&mut self, step: &Substep<S>) {
        if self.changes_in_time {
            self.at_time(step.start_s + 0.5 * (step.from + step.to) * step.grid_s);
        }
    }

    fn at_time(&mut self, time_s: f64) {
        let whole_or_not = |part: &Part<'_, S>| match part.effect.share(part.p, time_s) {
            share if share <= 0.0 => Some(false),
            share if share >= 1.0 => Some(true),
            _ => None,
        };
        let same = |(part, whole): (&Part<'_, S>, &bool)| whole_or_not(part) == Some(*whole);
        if self.whole.as_ref().is_some_and(|whole| self.parts.iter().zip(whole).all(same)) {
            return;
        }
        self.whole = self.parts.iter().map(whole_or_not).collect();
        self.chambers = self.chambers.with_law(law_of(self.parts, time_s), self.sealed_mm);
        self.inverse_mass = (self.base.mass_kg + inertia_kg(self.parts, time_s)).recip();
    }

    /// Pressures now, kPa, before the readings at the start are put right.
    pub(crate) fn pressures(&self) -> [S; 2] {
        self.air().pressures_kpa(self.x)
    }

    /// The driving force at half step `half` of the grid, mN, `since_s` after the last call.
    #[inline(always)]
    fn driving_at(&mut self, half: usize, since_s: f64) -> S {
        let (time_s, lead) = (0.5 * self.record.fine_step_s() * half as f64, self.lead_samples);
        if self.changes_in_time {
            self.delay_s = delay_s(self.parts, self.record.since_start_s + time_s);
        }
        let delay_s = self.delay_s;
        // At zero delay the force is the recorded one, but its derivative with respect to the delay is not zero.
        let is_delayed = delay_s.real() != 0.0 || (S::NDERIV > 0 && self.hooks.delay);
        let mut force = if is_delayed {
            let at = |recorded: &FineForce| recorded.at(S::constant(time_s) - delay_s, lead);
            let whole = at(&self.record.force);
            self.noise.as_ref().map_or(whole, |(doubtful, _, share)| whole - *share * at(doubtful))
        } else {
            // The recorded forces are plain numbers; only the share of the noise has derivatives.
            let at = |recorded: &FineForce, led_mn: Option<&[f64]>| {
                led_mn.map_or_else(|| recorded.at(time_s, lead), |led_mn| led_mn[half])
            };
            let whole = at(&self.record.force, self.led_mn);
            self.noise.as_ref().map_or(S::constant(whole), |(doubtful, led_mn, share)| {
                let doubtful = at(doubtful, *led_mn);
                S::with_slopes(whole - share.real() * doubtful, [share], [-doubtful])
            })
        };
        for part in self.parts.iter().filter(|part| part.hooks.drive) {
            let memory = &mut self.memory[part.memory.clone()];
            let command =
                Command { time_s: self.record.since_start_s + time_s, since_s, force_mn: force };
            force = part.effect.drive(part.p, &command, memory);
        }
        force
    }

    /// The air of the chambers.
    #[inline(always)]
    fn air(&self) -> SealedAir<'_, 'a, S> {
        SealedAir { chambers: &self.chambers, gas: self.gas.as_ref(), air_g: &self.air_g }
    }

    /// A step of the grid from the present state on, without substeps.
    #[inline(always)]
    fn whole_step(&self, start_s: f64, driving_mn: [S; 3]) -> Substep<S> {
        let start =
            StepStart { displacement_mm: self.x, velocity_mm_s: self.v, driving_mn: driving_mn[0] };
        let grid_s = self.record.fine_step_s();
        Substep { start_s, grid_s, from: 0.0, to: 1.0, driving_mn, start }
    }

    /// The joint at a share of a step, as effects see it.
    #[inline(always)]
    fn point<'p>(
        &self,
        base: &'p F::Sealed<'_>,
        air: &'p SealedAir<'_, 'a, S>,
        step: &'p Substep<S>,
        at: &At<S>,
        restoring: Option<&'p S>,
    ) -> Point<'p, S> {
        let share = at.share.real();
        Point {
            time_s: S::constant(step.start_s) + at.share.scaled(step.grid_s),
            displacement_mm: at.x,
            velocity_mm_s: at.v,
            driving_mn: step.driving_mn(at.share),
            step_start: &step.start,
            since_step_s: (share - step.from) * step.grid_s,
            restoring,
            base,
            air,
        }
    }

    /// The force on the joint at an instant but for dry friction, mN.
    #[inline(always)]
    pub(super) fn pull_mn(&self, air: &F::Sealed<'_>, step: &Substep<S>, at: &At<S>) -> S {
        let restoring = air.restoring_mn(at.x, at.v);
        let mut force = step.driving_mn(at.share) - restoring - at.v * self.base.damping_kg_s;
        if self.hooks.force {
            let sealed = self.air();
            force += self.forces_mn(&self.point(air, &sealed, step, at, Some(&restoring)));
        }
        if self.chambers.feeds_back() {
            force += self.feedback_mn(&at.x);
        }
        force
    }

    /// Force of the pressures by which the gas law differs from the base model's, mN.
    #[inline(always)]
    fn feedback_mn(&self, x: &S) -> S {
        let tabulated = self.gas.as_ref().and_then(|gas| gas.feedback_mn(x));
        tabulated.unwrap_or_else(|| self.chambers.feedback_mn(*x, self.air_g))
    }

    /// The forces of all effects, mN.
    #[inline(always)]
    fn forces_mn(&self, at: &Point<'_, S>) -> S {
        let parts = self.parts.iter().filter(|part| part.hooks.force);
        let forces =
            parts.map(|part| part.effect.force_mn(part.p, at, &self.memory[part.memory.clone()]));
        forces.fold(S::zero(), |sum, force| sum + force)
    }

    /// The dry friction of all effects, mN.
    #[inline(always)]
    fn frictions_mn(&self, at: &Point<'_, S>) -> S {
        let parts = self.parts.iter().filter(|part| part.hooks.dry_friction);
        let limits = parts
            .map(|part| part.effect.dry_friction_mn(part.p, at, &self.memory[part.memory.clone()]));
        limits.fold(S::zero(), |sum, limit| sum + limit)
    }

    /// The acceleration, mm/s², of a joint that slides in `direction` (±1; 0 without dry friction).
    #[inline(always)]
    pub(super) fn acceleration(
        &self,
        air: &F::Sealed<'_>,
        step: &Substep<S>,
        at: &At<S>,
        direction: f64,
    ) -> S {
        if self.hooks.force {
            // An effect may ask for the restoring force, which is worked out once.
            let mut force = self.pull_mn(air, step, at);
            if direction != 0.0 {
                force -= self.friction_limit_mn(air, step, at).scaled(direction);
            }
            return force * self.inverse_mass;
        }
        let mut push = step.driving_mn(at.share);
        if direction != 0.0 {
            push -= self.friction_limit_mn(air, step, at).scaled(direction);
        }
        if self.chambers.feeds_back() {
            push += self.feedback_mn(&at.x);
        }
        air.acceleration([&at.x, &at.v], &push, &self.base.damping_kg_s, &self.inverse_mass)
    }

    /// Largest dry friction at a share of a step, mN.
    #[inline(always)]
    pub(super) fn friction_limit_mn(
        &self,
        air: &F::Sealed<'_>,
        step: &Substep<S>,
        at: &At<S>,
    ) -> S {
        if !self.hooks.dry_friction {
            return S::zero();
        }
        let sealed = self.air();
        self.frictions_mn(&self.point(air, &sealed, step, at, None))
    }

    /// The whole substep as one Runge–Kutta step of fourth order, sliding in `direction`; the acceleration at its start and
    /// the state at its end. As the rate of the displacement is the velocity, it is Nyström's method of these nodes.
    #[inline(always)]
    pub(super) fn slide(
        &self,
        air: &F::Sealed<'_>,
        step: &Substep<S>,
        direction: f64,
    ) -> (S, [S; 2]) {
        let [from, middle, to] = [step.from, 0.5 * (step.from + step.to), step.to].map(S::constant);
        let h = (step.to - step.from) * step.grid_s;
        let (x, v) = (&self.x, &self.v);
        let rate = |at: &At<S>| self.acceleration(air, step, at, direction);
        let first = rate(&At { share: from, x: *x, v: *v });
        let second = rate(&At {
            share: middle,
            x: S::combination([x, v], [1.0, 0.5 * h]),
            v: S::combination([v, &first], [1.0, 0.5 * h]),
        });
        let third = rate(&At {
            share: middle,
            x: S::combination([x, v, &first], [1.0, 0.5 * h, 0.25 * h * h]),
            v: S::combination([v, &second], [1.0, 0.5 * h]),
        });
        let fourth = rate(&At {
            share: to,
            x: S::combination([x, v, &second], [1.0, h, 0.5 * h * h]),
            v: S::combination([v, &third], [1.0, h]),
        });
        let (sixth, third_h) = (h / 6.0, h / 3.0);
        let end_x = S::combination(
            [x, v, &first, &second, &third],
            [1.0, h, h * sixth, h * sixth, h * sixth],
        );
        let end_v = S::combination(
            [v, &first, &second, &third, &fourth],
            [1.0, sixth, third_h, third_h, sixth],
        );
        (first, [end_x, end_v])
    }

    /// The masses of air now.
    pub(super) fn masses(&self) -> SealedMasses {
        let [flexor_g, extensor_g] = self.air_g.map(|air| air.real());
        SealedMasses { flexor_g, extensor_g }
    }

    /// The recording.
    pub(super) fn record(&self) -> &'a ResampledRecord {
        self.record
    }

    /// Number of values in a state.
    pub(crate) fn state_len(&self) -> usize {
        5 + self.memory.len()
    }

    /// Writes the state: displacement, velocity, air, driving force, memory.
    pub(crate) fn state_into(&self, out: &mut [S]) {
        out[..5].copy_from_slice(&[self.x, self.v, self.air_g[0], self.air_g[1], self.driving_mn]);
        out[5..].copy_from_slice(&self.memory);
    }

    /// Goes on from a state.
    pub(crate) fn restore(&mut self, state: &[S]) {
        (self.x, self.v, self.air_g) = (state[0], state[1], [state[2], state[3]]);
        self.driving_mn = state[4];
        self.memory.copy_from_slice(&state[5..]);
        // On a tape, what was worked out before belongs to another step.
        self.whole = None;
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
    #[inline(always)]
    pub(crate) fn step(&mut self, k: usize) {
        let grid_s = self.record.fine_step_s();
        let driving_mn = [
            self.driving_mn,
            self.driving_at(2 * k + 1, 0.5 * grid_s),
            self.driving_at(2 * k + 2, 0.5 * grid_s),
        ];
        let start_s = self.record.since_start_s + grid_s * k as f64;
        for part in 0..self.substeps {
            let [from, to] = [part, part + 1].map(|j| j as f64 / self.substeps as f64);
            let mut step = Substep { from, to, ..self.whole_step(start_s, driving_mn) };
            if part > 0 {
                step.start.driving_mn = step.driving_mn(S::constant(from));
            }
            self.substep(&step);
        }
        self.driving_mn = driving_mn[2];
    }

    #[inline(always)]
    fn substep(&mut self, step: &Substep<S>) {
        self.at_middle(step);
        let force = self.force;
        let air = force.sealed(self.air_g);
        let [to_x, to_v] = if self.rough {
            let at = At { share: S::constant(step.from), x: self.x, v: self.v };
            self.slide_and_stick(&air, step, at)
        } else {
            self.slide(&air, step, 0.0).1
        };
        let h = (step.to - step.from) * step.grid_s;
        if self.has_memory() {
            let at = At { share: S::constant(step.to), x: to_x, v: to_v };
            self.remember(&air, step, &at, h);
        }
        (self.x, self.v) = (to_x, to_v);
    }
}

impl<S: EffectScalar, F: BaseForce<S>> JointIntegrator<'_, S, F> {
    /// Whether air or memory moves.
    #[inline(always)]
    pub(super) fn has_memory(&self) -> bool {
        self.chambers.leaks() || self.hooks.air_flow || self.hooks.advance
    }

    /// Moves air and memory over a substep of the length `h` that ends `at`.
    pub(super) fn remember(&mut self, air: &F::Sealed<'_>, step: &Substep<S>, at: &At<S>, h: f64) {
        let mut memory = std::mem::take(&mut self.memory);
        let sealed = self.air();
        let end = self.point(air, &sealed, step, at, None);
        let mut air_g = self.air_g;
        if self.chambers.leaks() {
            air_g = self.chambers.leaked(at.x, h, air_g);
        }
        for part in self.parts.iter().filter(|part| part.hooks.air_flow) {
            let flow_g_s = part.effect.air_g_s(part.p, &end, &memory[part.memory.clone()]);
            for (air, flow) in air_g.iter_mut().zip(flow_g_s) {
                *air += flow.scaled(h);
            }
        }
        for part in self.parts.iter().filter(|part| part.hooks.advance) {
            part.effect.advance(part.p, &end, &mut memory[part.memory.clone()]);
        }
        self.memory = memory;
        self.air_g = air_g;
    }
}

impl<F: BaseForce<f64>> JointIntegrator<'_, f64, F> {
    /// Slopes of the acceleration at the start along displacement (1/s²) and velocity (1/s), if the joint were at rest
    /// at `x` (mm) and then moved at `v` (mm/s).
    pub(super) fn slopes(&mut self, x: f64, v: f64) -> [f64; 2] {
        // Small against what the force bends within, large against rounding.
        const STEPS: [f64; 2] = [1e-3, 1e-2];
        self.x = x;
        self.begin_memory(x);
        let step = self.whole_step(self.record.since_start_s, [0.0; 3]);
        let force = self.force;
        let air = force.sealed(self.air_g);
        let at = |x, v| self.acceleration(&air, &step, &At { share: 0.0, x, v }, 0.0);
        let [dx, dv] = STEPS;
        [(at(x + dx, v) - at(x - dx, v)) / (2.0 * dx), (at(x, v + dv) - at(x, v - dv)) / (2.0 * dv)]
    }
}

/// The law of the chambers under effects at a time, s.
fn law_of<S: EffectScalar>(parts: &[Part<'_, S>], time_s: f64) -> ChamberLaw<S> {
    let mut law = ChamberLaw::plain();
    parts.iter().for_each(|part| part.effect.chamber(part.p, time_s, &mut law));
    law
}

/// The mass that effects add at a time, kg.
fn inertia_kg<S: EffectScalar>(parts: &[Part<'_, S>], time_s: f64) -> S {
    let own = parts.iter().map(|part| part.effect.inertia_kg(part.p, time_s));
    own.fold(S::zero(), |sum, mass| sum + mass)
}

/// The delay of the real force behind the recorded one at a time, s.
fn delay_s<S: EffectScalar>(parts: &[Part<'_, S>], time_s: f64) -> S {
    let own = parts.iter().map(|part| part.effect.delay_s(part.p, time_s));
    own.fold(S::zero(), |sum, delay| sum + delay)
}
