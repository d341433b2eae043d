//! An effect of expressions in the rig.

use super::LANGUAGE;
use super::evaluate::{Known, VARIABLES};
use crate::effects::sensing::DelayLine;
use crate::effects::{Clock, Phenomenon, Seen, SetUp};
use crate::plant::{Braid, Plant};
use pam_vocabulary::definition::{EffectDefinition, Formula, MemoryLaw, Moment};

/// Places of the variables in the language of the joint.
const X: usize = 0;
const V: usize = 1;
const PF: usize = 2;
const PE: usize = 3;
const MF: usize = 4;
const ME: usize = 5;
const FORCE: usize = 6;
const NETWORK: usize = 7;
const T: usize = 8;
const DT: usize = 9;
const DX: usize = 10;
const X0: usize = 11;

/// The effect in a run.
pub(super) struct Hidden {
    definition: &'static EffectDefinition,
    values: Vec<f64>,
    /// Whether an expression asks for the plant's restoring force, which is not cheap.
    asks_network: bool,
    /// When the memory moves.
    moment: Moment,
    memory: Vec<f64>,
    /// Variables at the last call at that moment.
    last: Option<[f64; VARIABLES]>,
    /// Factor of the muscles' force in this step.
    factor: f64,
    /// Force of the motor in this step, N.
    force_n: f64,
    command_delay: Option<DelayLine>,
    position_delay: Option<DelayLine>,
    pressure_delays: Option<[DelayLine; 2]>,
    /// Displacement at the last sample, mm.
    sampled_mm: Option<f64>,
}

const NOWHERE: [f64; VARIABLES] = [f64::NAN; VARIABLES];

impl Hidden {
    pub(super) fn new(definition: &'static EffectDefinition, values: &[f64]) -> Self {
        let moments = definition.acts.iter().map(|(k, _)| LANGUAGE.places[*k].moment);
        let mut hidden = Self {
            definition,
            values: values.to_vec(),
            asks_network: asks(definition, NETWORK),
            moment: moments.into_iter().find(|m| *m != Moment::Once).unwrap_or(Moment::Once),
            memory: vec![0.0; definition.memory.len()],
            last: None,
            factor: 1.0,
            force_n: 0.0,
            command_delay: None,
            position_delay: None,
            pressure_delays: None,
            sampled_mm: None,
        };
        hidden.command_delay = hidden.once("command_delay_s").map(DelayLine::new);
        hidden.position_delay = hidden.once("position_delay_s").map(DelayLine::new);
        hidden.pressure_delays =
            hidden.once("pressure_delay_s").map(|s| [0, 1].map(|_| DelayLine::new(s)));
        hidden
    }

    fn act(&self, place: &str) -> Option<&'static Formula> {
        self.definition.act(&LANGUAGE, place)
    }

    fn value(&self, formula: &Formula, variables: [f64; VARIABLES], plant: Option<&Plant>) -> f64 {
        value(self.definition, &self.values, &self.memory, formula, variables, plant)
    }

    /// A number that depends on the parameters alone.
    fn once(&self, place: &str) -> Option<f64> {
        self.act(place).map(|formula| self.value(formula, NOWHERE, None))
    }

    /// Moves the memory to this moment: by Heun's method, or by its own step.
    fn remember(&mut self, mut now: [f64; VARIABLES], plant: Option<&Plant>) {
        let (definition, values) = (self.definition, &self.values);
        if definition.memory.is_empty() {
            return;
        }
        let Some(before) = self.last.replace(now) else {
            let start = |m: &_| value(definition, values, &[], starting(m), now, plant);
            self.memory = definition.memory.iter().map(start).collect();
            return;
        };
        now[DT] = now[T] - before[T];
        (now[DX], now[X0]) = (now[X] - before[X], before[X]);
        let rates = |memory: &[f64], at: [f64; VARIABLES]| -> Vec<f64> {
            let rate = |law: &MemoryLaw| match law {
                MemoryLaw::Rate(formula) => value(definition, values, memory, formula, at, plant),
                MemoryLaw::Step(_) => 0.0,
            };
            definition.memory.iter().map(|m| rate(&m.law)).collect()
        };
        let first = rates(&self.memory, before);
        let moved: Vec<f64> =
            self.memory.iter().zip(&first).map(|(q, rate)| q + now[DT] * rate).collect();
        let second = rates(&moved, now);
        let after = definition.memory.iter().enumerate().map(|(k, m)| match &m.law {
            MemoryLaw::Rate(_) => self.memory[k] + 0.5 * now[DT] * (first[k] + second[k]),
            MemoryLaw::Step(formula) => {
                value(definition, values, &self.memory, formula, now, plant)
            }
        });
        self.memory = after.collect();
    }

    /// The variables in the balance of forces.
    fn motion(&self, clock: &Clock, plant: &Plant) -> [f64; VARIABLES] {
        let mut now = NOWHERE;
        (now[X], now[V]) = (plant.displacement_mm(), plant.velocity_mm_s());
        [now[PF], now[PE]] = plant.pressures_kpa();
        [now[MF], now[ME]] = masses_g(plant);
        now[FORCE] = self.force_n;
        if self.asks_network {
            now[NETWORK] = plant.elastic_restoring_force_n(now[X], masses_g(plant));
        }
        now[T] = clock.time_s;
        now
    }
}

/// Whether an expression of the effect names a variable.
fn asks(definition: &EffectDefinition, variable: usize) -> bool {
    let acts = definition.acts.iter().map(|(_, formula)| formula);
    let lets = definition.lets.iter().map(|(_, formula)| formula);
    let laws = definition.memory.iter().map(|m| m.law.formula());
    acts.chain(lets).chain(laws).any(|formula| formula.tree.names().contains(&variable))
}

/// The formula of a memory's beginning.
fn starting(memory: &pam_vocabulary::definition::MemoryDefinition) -> &Formula {
    &memory.start
}

fn masses_g(plant: &Plant) -> [f64; 2] {
    [0, 1].map(|i| plant.muscles()[i].air.mass_g)
}

fn value(
    definition: &EffectDefinition,
    values: &[f64],
    memory: &[f64],
    formula: &Formula,
    variables: [f64; VARIABLES],
    plant: Option<&Plant>,
) -> f64 {
    let restoring_n =
        |x: f64| plant.map_or(0.0, |plant| plant.elastic_restoring_force_n(x, masses_g(plant)));
    Known::new(definition, variables, values, memory, &restoring_n).value(&formula.tree)
}

impl Phenomenon for Hidden {
    fn set_up(&self, setup: &mut SetUp) {
        if let Some(mass_kg) = self.once("inertia_kg") {
            setup.plant.mass_kg += mass_kg;
        }
        let exponent = self.once("gas_exponent").unwrap_or(1.0);
        let factor = self.once("deformation_factor").unwrap_or(1.0);
        let limit_mm = self.once("contraction_limit_mm");
        let muscles = [setup.plant.flexor, setup.plant.extensor];
        for (law, muscle) in setup.laws.iter_mut().zip(muscles) {
            // dV/V = (2 nu − 1) dc/L at rest.
            let braid = Braid::new(&muscle.braid);
            let slope = muscle.braid.length_mm * braid.area_mm2(0.0) / braid.volume_mm3(0.0);
            law.exponent *= exponent * ((1.0 + slope) * factor - 1.0) / slope;
            if let Some(limit) = limit_mm {
                law.largest_contraction_mm = law.largest_contraction_mm.min(limit);
            }
        }
    }

    fn actuate(&mut self, clock: &Clock, force_n: f64) -> f64 {
        let mut force = force_n;
        if let Some(line) = &mut self.command_delay {
            force = line.pass(force, clock.step_s);
        }
        if let Some(formula) = self.act("command_n") {
            let mut now = NOWHERE;
            (now[FORCE], now[T]) = (force, clock.time_s);
            if self.moment == Moment::Command {
                self.remember(now, None);
            }
            force = self.value(formula, now, None);
        }
        self.force_n = force;
        force
    }

    fn joint_force_n(&mut self, clock: &Clock, plant: &Plant) -> f64 {
        if self.moment != Moment::Motion {
            return 0.0;
        }
        let now = self.motion(clock, plant);
        self.remember(now, Some(plant));
        if let Some(factor) = self.act("force_factor") {
            self.factor = self.value(factor, now, Some(plant));
        }
        self.act("force_n").map_or(0.0, |force| self.value(force, now, Some(plant)))
    }

    fn dry_friction_n(&self, clock: &Clock, plant: &Plant) -> f64 {
        self.act("dry_friction_n")
            .map_or(0.0, |level| self.value(level, self.motion(clock, plant), Some(plant)).max(0.0))
    }

    fn muscle_scale(&self, _clock: &Clock) -> f64 {
        self.factor
    }

    fn air_g(&mut self, clock: &Clock, plant: &Plant) -> [f64; 2] {
        // While the valves work, the servo makes up for any leak.
        if clock.sealed_g.is_none() {
            return [0.0; 2];
        }
        ["air_flexor_g_s", "air_extensor_g_s"].map(|place| {
            self.act(place).map_or(0.0, |rate| {
                clock.step_s * self.value(rate, self.motion(clock, plant), Some(plant))
            })
        })
    }

    fn observe(&mut self, clock: &Clock, seen: &mut Seen) {
        if let Some(line) = &mut self.position_delay {
            seen.displacement_mm = line.pass(seen.displacement_mm, clock.step_s);
        }
        if let Some(lines) = &mut self.pressure_delays {
            for (line, kpa) in lines.iter_mut().zip(&mut seen.pressures_kpa) {
                *kpa = line.pass(*kpa, clock.step_s);
            }
        }
        let x = seen.displacement_mm;
        let last_mm = self.sampled_mm.replace(x).unwrap_or(x);
        let mut now = NOWHERE;
        (now[X], now[V], now[T]) = (x, (x - last_mm) / clock.step_s, clock.time_s);
        [now[PF], now[PE]] = seen.pressures_kpa;
        now[FORCE] = self.force_n;
        if self.moment == Moment::Sensing {
            self.remember(now, None);
        }
        if let Some(position) = self.act("position_mm") {
            seen.displacement_mm = self.value(position, now, None);
        }
        for (kpa, place) in
            seen.pressures_kpa.iter_mut().zip(["pressure_flexor_kpa", "pressure_extensor_kpa"])
        {
            if let Some(pressure) = self.act(place) {
                *kpa = self.value(pressure, now, None);
            }
        }
    }
}
