//! An effect of expressions, at the places where it acts.

use super::at_zero::{self, WithPlainMemory, is_at_zero};
use super::joint::{DT, FORCE, Instant, NETWORK, PE, PF, Row, T, V, VARIABLES, X};
use super::memory::{Law, MOST, Memory};
use super::sensing::{Sensors, Velocity};
use crate::effects::{
    ChamberLaw, Command, DataScales, Effect, EffectInfo, Hooks, MemoryStart, Observed, Point, Rest,
    delayed,
};
use pam_core::Scalar;
use pam_core::units::MN_PER_N;
use pam_expression::{Compiled, Graph, Id, Program, too_long};
use pam_vocabulary::definition::{EffectDefinition, Language, MemoryLaw, Moment, Symbol};
use pam_vocabulary::expression::Expression;

/// An effect that a file defines.
#[derive(Debug)]
pub(super) struct ExpressionEffect {
    info: &'static EffectInfo,
    definition: Option<&'static str>,
    starts: Vec<Vec<Compiled>>,
    switches: Vec<Vec<f64>>,
    valid: Option<Compiled>,
    /// When its memory moves.
    moment: Moment,
    memory: Option<Memory>,
    /// Force on the joint (mN), dry friction (mN) and flow of air (g/s).
    motion: [Option<Program>; 3],
    /// The same for the remembered numbers at the start of a step, where they move by steps alone: one evaluation in place of
    /// two.
    motion_within_step: Option<[Option<Program>; 3]>,
    /// Whether all of the balance of forces is zero where the values are, whatever is remembered.
    vanishes_at_zero: bool,
    command_n: Option<Program>,
    once: Once,
    sensors: Sensors,
}

/// Places of the programs of the balance of forces.
const FORCE_MN: usize = 0;
const DRY_FRICTION_MN: usize = 1;
const AIR_G_S: usize = 2;

/// Numbers that depend on the values of the effect alone.
#[derive(Debug, Default)]
struct Once {
    command_delay_s: Option<Program>,
    inertia_kg: Option<Program>,
    gas_exponent: Option<Program>,
    deformation_factor: Option<Program>,
    contraction_limit_mm: Option<Program>,
    pressure_feedback: Option<Program>,
    position_delay_s: Option<Program>,
    pressure_delay_s: Option<Program>,
}

/// Builds the programs of a definition.
struct Builder<'a> {
    definition: &'a EffectDefinition,
    language: &'a Language,
    graph: Graph,
    /// Nodes that stand for the remembered numbers in the balance of forces; as they are handed in if empty.
    steps: Vec<Id>,
}

/// The node of a name: named parts are put in, `other` gives those of all other symbols.
fn named(
    definition: &EffectDefinition,
    graph: &mut Graph,
    k: usize,
    other: &dyn Fn(&mut Graph, Symbol, usize) -> Id,
) -> Id {
    match definition.symbol(k) {
        Symbol::Let(k) => {
            let tree = &definition.lets[k].1.tree;
            graph.expression(tree, &mut |graph, k| named(definition, graph, k, other))
        }
        symbol => other(graph, symbol, k),
    }
}

impl Builder<'_> {
    /// The node of a tree; named parts are put in.
    fn node(&mut self, tree: &Expression) -> Id {
        self.node_with(tree, &[])
    }

    /// As [`node`](Self::node), with nodes in place of the remembered numbers.
    fn node_with(&mut self, tree: &Expression, memory: &[Id]) -> Id {
        let definition = self.definition;
        let other = |graph: &mut Graph, symbol: Symbol, k: usize| match symbol {
            Symbol::Memory(m) if m < memory.len() => memory[m],
            _ => graph.input(k),
        };
        self.graph.expression(tree, &mut |graph, k| named(definition, graph, k, &other))
    }

    /// The node at a place.
    fn act(&mut self, place: &str) -> Option<Id> {
        let tree = &self.definition.act(self.language, place)?.tree;
        Some(self.node(tree))
    }

    /// The node at a place in the balance of forces.
    fn act_in_motion(&mut self, place: &str) -> Option<Id> {
        let tree = &self.definition.act(self.language, place)?.tree;
        let steps = std::mem::take(&mut self.steps);
        let id = self.node_with(tree, &steps);
        self.steps = steps;
        Some(id)
    }

    fn program(&self, outputs: &[Id]) -> Result<Program, String> {
        Program::new(&self.graph, outputs).ok_or_else(too_long)
    }

    fn act_program(&mut self, place: &str) -> Result<Option<Program>, String> {
        self.act(place).map(|id| self.program(&[id])).transpose()
    }

    /// Force on the joint with that of a factor of the base model's, mN.
    fn force(&mut self) -> Result<Option<Program>, String> {
        let force = self.act_in_motion("force_n");
        let factor = self.act_in_motion("force_factor").map(|factor| {
            let network = self.graph.input(NETWORK);
            let one = self.graph.constant(1.0);
            let less = self.graph.subtract(one, factor);
            self.graph.multiply(less, network)
        });
        let sum = match (force, factor) {
            (Some(a), Some(b)) => self.graph.add(a, b),
            (Some(id), None) | (None, Some(id)) => id,
            (None, None) => return Ok(None),
        };
        let sum = self.graph.scaled(sum, MN_PER_N);
        self.program(&[sum]).map(Some)
    }

    fn dry_friction(&mut self) -> Result<Option<Program>, String> {
        let Some(level) = self.act_in_motion("dry_friction_n") else { return Ok(None) };
        let zero = self.graph.constant(0.0);
        let level = self.graph.maximum(level, zero);
        let level = self.graph.scaled(level, MN_PER_N);
        self.program(&[level]).map(Some)
    }

    fn air(&mut self) -> Result<Option<Program>, String> {
        let acts = ["air_flexor_g_s", "air_extensor_g_s"].map(|place| self.act_in_motion(place));
        if acts == [None; 2] {
            return Ok(None);
        }
        let zero = self.graph.constant(0.0);
        self.program(&acts.map(|act| act.unwrap_or(zero))).map(Some)
    }

    /// Force on the joint, dry friction and flow of air.
    fn motion(&mut self) -> Result<[Option<Program>; 3], String> {
        Ok([self.force()?, self.dry_friction()?, self.air()?])
    }

    /// The same with the remembered numbers worked out in the programs, where they move in the balance of forces by steps
    /// alone: one evaluation in place of two. `None` if that takes too many registers.
    fn motion_with_steps(&mut self) -> Option<[Option<Program>; 3]> {
        let definition = self.definition;
        let trees = definition.memory.iter().map(|m| match &m.law {
            MemoryLaw::Step(step) => Some(&step.tree),
            MemoryLaw::Rate(_) => None,
        });
        let trees: Vec<&Expression> = trees.collect::<Option<_>>()?;
        if trees.is_empty() {
            return None;
        }
        self.steps = trees.iter().map(|tree| self.node(tree)).collect();
        let programs = self.motion().ok();
        self.steps.clear();
        programs
    }

    /// Whether what acts in the balance of forces is zero where all values are.
    fn vanishes_at_zero(&self) -> bool {
        let definition = self.definition;
        let other = |graph: &mut Graph, symbol: Symbol, k: usize| match symbol {
            Symbol::Value(_) => graph.constant(0.0),
            _ => graph.input(k),
        };
        let mut graph = Graph::default();
        let mut is_zero = |tree: &Expression| {
            let mut name = |graph: &mut Graph, k| named(definition, graph, k, &other);
            let id = graph.expression(tree, &mut name);
            graph.value(id) == Some(0.0)
        };
        let in_motion = |place: usize| self.language.places[place].moment == Moment::Motion;
        definition.acts.iter().all(|(place, act)| !in_motion(*place) || is_zero(&act.tree))
    }

    fn memory(&mut self) -> Result<Option<Memory>, String> {
        let definition = self.definition;
        if definition.memory.is_empty() {
            return Ok(None);
        }
        let starts: Vec<Id> = definition.memory.iter().map(|m| self.node(&m.start.tree)).collect();
        let laws: Vec<Law> = definition
            .memory
            .iter()
            .map(|m| match &m.law {
                MemoryLaw::Rate(rate) => Law::Rate(self.node(&rate.tree)),
                MemoryLaw::Step(step) => Law::Step(self.node(&step.tree)),
            })
            .collect();
        let first = VARIABLES + definition.value_len();
        let memory = Memory::new(&mut self.graph, &starts, &laws, first).map_err(|k| {
            format!(
                "the rate of `{}` asks for `network(…)` where the memory itself stands; that cannot be differentiated",
                definition.memory[k].name
            )
        })?;
        memory.map(Some).ok_or_else(too_long)
    }

    fn sensors(&mut self) -> Result<Sensors, String> {
        let definition = self.definition;
        let position = self.act("position_mm");
        let velocity = match (self.act("velocity_mm_s"), position) {
            (Some(given), _) => Velocity::Of(self.program(&[given])?),
            (None, None) => Velocity::True,
            (None, Some(position)) => self.velocity_of(position)?,
        };
        let mut rest = [None, None, None];
        let starts: Vec<Id> = definition.memory.iter().map(|m| self.node(&m.start.tree)).collect();
        let places =
            [("position_mm", X), ("pressure_flexor_kpa", PF), ("pressure_extensor_kpa", PE)];
        for (rest, (place, read)) in rest.iter_mut().zip(places) {
            let Some(formula) = definition.act(self.language, place) else { continue };
            let value = self.node_with(&formula.tree, &starts);
            if !self.graph.is_input(value, read)
                && let Some(slope) = self.graph.derivative(value, read)
            {
                *rest = Some(self.program(&[value, slope])?);
            }
        }
        Ok(Sensors {
            position_mm: position.map(|id| self.program(&[id])).transpose()?,
            velocity,
            pressures_kpa: [
                self.act_program("pressure_flexor_kpa")?,
                self.act_program("pressure_extensor_kpa")?,
            ],
            rest,
        })
    }

    /// The velocity of a reading of the position: by the chain rule where it depends on displacement and time alone.
    fn velocity_of(&mut self, position: Id) -> Result<Velocity, String> {
        let reads = self.program(&[position])?;
        let others = [V, PF, PE, FORCE].into_iter().any(|k| reads.reads(k));
        let remembers = (0..self.definition.memory.len())
            .any(|k| reads.reads(VARIABLES + self.definition.value_len() + k));
        let slopes = self
            .graph
            .derivative(position, X)
            .zip(self.graph.derivative(position, T))
            .filter(|_| !others && !remembers);
        let Some((by_x, by_t)) = slopes else { return Ok(Velocity::Difference) };
        let v = self.graph.input(V);
        let along = self.graph.multiply(by_x, v);
        let rate = self.graph.add(along, by_t);
        if rate == v { Ok(Velocity::True) } else { self.program(&[rate]).map(Velocity::Of) }
    }
}

impl ExpressionEffect {
    pub(super) fn new(
        definition: &EffectDefinition,
        language: &Language,
        text: Option<&'static str>,
    ) -> Result<Self, String> {
        let mut builder =
            Builder { definition, language, graph: Graph::default(), steps: Vec::new() };
        let moment = definition
            .acts
            .iter()
            .map(|(k, _)| language.places[*k].moment)
            .find(|moment| *moment != Moment::Once)
            .unwrap_or(Moment::Motion);
        let own = |tree: &Expression| Compiled::of_tree(tree).ok_or_else(too_long);
        let starts = definition
            .parameters
            .iter()
            .map(|p| p.starts.iter().map(|s| own(&s.tree)).collect())
            .collect::<Result<_, String>>()?;
        Ok(Self {
            info: definition.info(),
            definition: text,
            starts,
            switches: definition.switches.iter().map(|s| s.values.clone()).collect(),
            valid: definition.valid.as_ref().map(|v| own(&v.tree)).transpose()?,
            moment,
            memory: builder.memory()?,
            motion: builder.motion()?,
            motion_within_step: match moment {
                Moment::Motion => builder.motion_with_steps(),
                _ => None,
            },
            vanishes_at_zero: moment == Moment::Motion && builder.vanishes_at_zero(),
            command_n: builder.act_program("command_n")?,
            once: Once {
                command_delay_s: builder.act_program("command_delay_s")?,
                inertia_kg: builder.act_program("inertia_kg")?,
                gas_exponent: builder.act_program("gas_exponent")?,
                deformation_factor: builder.act_program("deformation_factor")?,
                contraction_limit_mm: builder.act_program("contraction_limit_mm")?,
                pressure_feedback: builder.act_program("pressure_feedback")?,
                position_delay_s: builder.act_program("position_delay_s")?,
                pressure_delay_s: builder.act_program("pressure_delay_s")?,
            },
            sensors: builder.sensors()?,
        })
    }

    /// The memory where it moves at this moment.
    fn memory_of(&self, moment: Moment) -> Option<&Memory> {
        self.memory.as_ref().filter(|_| self.moment == moment)
    }

    /// A number that depends on the values alone.
    fn once<S: Scalar>(&self, program: Option<&Program>, p: &[S]) -> Option<S> {
        let variables = [S::zero(); VARIABLES];
        program.map(|program| program.value(&Row { variables: &variables, p, memory: &[] }))
    }

    /// One of the expressions in the balance of forces.
    #[inline]
    fn at_point<S: Scalar>(
        &self,
        which: usize,
        p: &[S],
        at: &Point<'_, S>,
        memory: &[S],
        out: &mut [S],
    ) {
        let Some(program) = &self.motion[which] else { return };
        let law = self.memory_of(Moment::Motion).filter(|_| at.since_step_s > 0.0);
        let within = self.motion_within_step.as_ref().and_then(|all| all[which].as_ref());
        match (law, within) {
            // A step of no length changes no memory.
            (None, _) => program.values(&Instant::new(at, p, memory), out),
            (Some(_), Some(within)) => within.values(&Instant::new(at, p, memory), out),
            (Some(law), None) if is_at_zero(self.vanishes_at_zero, p) => {
                at_zero::moved(law, p, at, memory, |memory| {
                    let instant = Instant::new(at, p, &[]);
                    program.values(&WithPlainMemory { instant, memory }, out);
                });
            }
            (Some(law), None) => moved(law, p, at, memory, |now| {
                program.values(&Instant::new(at, p, now), out);
            }),
        }
    }

    /// Starting values of `k` parameters and switches on, in all combinations.
    fn combinations(&self, scales: &[f64]) -> Vec<Vec<f64>> {
        let parameters =
            self.starts.iter().map(|starts| starts.iter().map(|s| s.value(scales)).collect());
        let all = parameters.chain(self.switches.iter().cloned());
        all.fold(vec![Vec::new()], |rows, values: Vec<f64>| {
            let with = |row: &Vec<f64>| {
                values.iter().map(|v| [row.as_slice(), &[*v]].concat()).collect::<Vec<_>>()
            };
            rows.iter().flat_map(with).collect()
        })
    }
}

/// The remembered numbers at a point of a step.
fn moved<S: Scalar, R>(
    law: &Memory,
    p: &[S],
    at: &Point<'_, S>,
    memory: &[S],
    then: impl FnOnce(&[S]) -> R,
) -> R {
    let evaluate = |memory: &[S], start: bool, program: &Program, out: &mut [S]| {
        let inputs =
            if start { Instant::at_start(at, p, memory) } else { Instant::new(at, p, memory) };
        program.values(&inputs, out);
    };
    law.advance(at.since_step_s, memory, &evaluate, then)
}

/// Magnitudes of the data, in the order of [`Language::joint`].
fn in_order(scales: &DataScales) -> [f64; 6] {
    [
        scales.force_n,
        scales.peak_force_n,
        scales.travel_mm,
        scales.speed_mm_s,
        scales.stiffness_n_mm,
        scales.gauge_kpa,
    ]
}

impl Effect for ExpressionEffect {
    fn info(&self) -> &'static EffectInfo {
        self.info
    }

    fn definition(&self) -> Option<&'static str> {
        self.definition
    }

    fn starts(&self, scales: &DataScales) -> Vec<Vec<f64>> {
        let mut rows = self.combinations(&in_order(scales));
        // A magnitude of the data may lie outside of what is physical.
        for row in &mut rows {
            for (value, parameter) in row.iter_mut().zip(self.info.parameters) {
                let [low, high] = parameter.range;
                *value = if value.is_finite() { value.clamp(low, high) } else { low };
            }
        }
        rows
    }

    fn stands(&self, values: &[f64], scales: &DataScales) -> bool {
        self.valid
            .as_ref()
            .is_none_or(|valid| valid.value(&[values, &in_order(scales)].concat()) != 0.0)
    }

    fn memory_len(&self) -> usize {
        match (&self.memory, self.moment) {
            (Some(memory), Moment::Motion) => memory.len,
            // The last command stands behind.
            (Some(memory), Moment::Command) => memory.len + 1,
            _ => 0,
        }
    }

    fn acts_where_off(&self) -> bool {
        self.once.contraction_limit_mm.is_some()
    }

    fn changes_gas(&self) -> bool {
        let Once { gas_exponent, deformation_factor, contraction_limit_mm, .. } = &self.once;
        self.motion[AIR_G_S].is_some()
            || [gas_exponent, deformation_factor, contraction_limit_mm].iter().any(|p| p.is_some())
    }

    fn hooks(&self) -> Hooks {
        let Once { command_delay_s, inertia_kg, position_delay_s, pressure_delay_s, .. } =
            &self.once;
        let Sensors { position_mm, velocity, pressures_kpa, rest } = &self.sensors;
        let moves = self.memory_of(Moment::Motion).is_some();
        Hooks {
            rest: rest.iter().any(Option::is_some),
            drive: self.command_n.is_some(),
            force: self.motion[FORCE_MN].is_some(),
            dry_friction: self.motion[DRY_FRICTION_MN].is_some(),
            air_flow: self.motion[AIR_G_S].is_some(),
            advance: moves,
            constants: self.changes_gas() || command_delay_s.is_some() || inertia_kg.is_some(),
            delay: command_delay_s.is_some(),
            observe: position_delay_s.is_some()
                || pressure_delay_s.is_some()
                || position_mm.is_some()
                || !matches!(velocity, Velocity::True)
                || pressures_kpa.iter().any(Option::is_some),
        }
    }

    fn remembers(&self) -> bool {
        self.memory.is_some() || self.motion[AIR_G_S].is_some()
    }

    fn moves_with_the_joint(&self) -> bool {
        self.moment == Moment::Motion
    }

    fn may_stick_later(&self, values: &[f64]) -> bool {
        let absent =
            self.info.parameters.iter().zip(values).filter_map(|(p, v)| Some(p.off? == *v));
        let mut absent = absent.peekable();
        let is_there = absent.peek().is_none() || absent.any(|absent| !absent);
        self.motion[DRY_FRICTION_MN].is_some() && is_there
    }

    fn begin<S: Scalar>(&self, p: &[S], at: &MemoryStart<S>, memory: &mut [S]) {
        if let Some(law) = self.memory_of(Moment::Motion) {
            let mut variables = [S::zero(); VARIABLES];
            variables[X] = at.displacement_mm;
            [variables[PF], variables[PE]] = at.pressures_kpa;
            law.starts.values(&Row { variables: &variables, p, memory: &[] }, memory);
        }
    }

    fn rest<S: Scalar>(&self, p: &[S], rest: &mut Rest<S>) {
        self.sensors.undo(p, rest);
    }

    fn drive<S: Scalar>(&self, p: &[S], command: &Command<S>, memory: &mut [S]) -> S {
        let Some(program) = &self.command_n else { return command.force_mn };
        let force = command.force_mn.scaled(1.0 / MN_PER_N);
        let mut variables = [S::zero(); VARIABLES];
        variables[T] = S::constant(command.time_s);
        variables[FORCE] = force;
        variables[DT] = S::constant(command.since_s);
        let real = match self.memory_of(Moment::Command) {
            None => program.value(&Row { variables: &variables, p, memory: &[] }),
            Some(law) => {
                let (own, last) = memory.split_at_mut(law.len);
                if command.since_s > 0.0 {
                    let mut before = variables;
                    before[FORCE] = last[0];
                    before[T] = S::constant(command.time_s - command.since_s);
                    let mut now = [S::zero(); MOST];
                    let evaluate = |memory: &[S], start: bool, program: &Program, out: &mut [S]| {
                        let variables = if start { &before } else { &variables };
                        program.values(&Row { variables, p, memory }, out);
                    };
                    law.advance(command.since_s, own, &evaluate, |moved| {
                        now[..moved.len()].copy_from_slice(moved);
                    });
                    own.copy_from_slice(&now[..law.len]);
                } else {
                    law.starts.values(&Row { variables: &variables, p, memory: &[] }, own);
                }
                last[0] = force;
                program.value(&Row { variables: &variables, p, memory: own })
            }
        };
        real.scaled(MN_PER_N)
    }

    fn delay_s<S: Scalar>(&self, p: &[S]) -> S {
        self.once(self.once.command_delay_s.as_ref(), p).unwrap_or_else(S::zero)
    }

    fn force_mn<S: Scalar>(&self, p: &[S], at: &Point<'_, S>, memory: &[S]) -> S {
        let mut out = [S::zero()];
        self.at_point(FORCE_MN, p, at, memory, &mut out);
        out[0]
    }

    fn dry_friction_mn<S: Scalar>(&self, p: &[S], at: &Point<'_, S>, memory: &[S]) -> S {
        let mut out = [S::zero()];
        self.at_point(DRY_FRICTION_MN, p, at, memory, &mut out);
        out[0]
    }

    fn air_g_s<S: Scalar>(&self, p: &[S], at: &Point<'_, S>, memory: &[S]) -> [S; 2] {
        let mut out = [S::zero(); 2];
        self.at_point(AIR_G_S, p, at, memory, &mut out);
        out
    }

    fn inertia_kg<S: Scalar>(&self, p: &[S]) -> S {
        self.once(self.once.inertia_kg.as_ref(), p).unwrap_or_else(S::zero)
    }

    fn chamber<S: Scalar>(&self, p: &[S], law: &mut ChamberLaw<S>) {
        if let Some(exponent) = self.once(self.once.gas_exponent.as_ref(), p) {
            law.exponent *= exponent;
        }
        if let Some(factor) = self.once(self.once.deformation_factor.as_ref(), p) {
            law.deformation_factor *= factor;
        }
        if let Some(limit) = self.once(self.once.contraction_limit_mm.as_ref(), p) {
            law.contraction_limit_mm = Some(limit);
        }
        if let Some(feedback) = self.once(self.once.pressure_feedback.as_ref(), p) {
            law.feeds_back |= feedback.real() != 0.0;
        }
    }

    fn advance<S: Scalar>(&self, p: &[S], end: &Point<'_, S>, memory: &mut [S]) {
        if let Some(law) = self.memory_of(Moment::Motion) {
            if is_at_zero(self.vanishes_at_zero, p) {
                let mut now = [0.0; MOST];
                at_zero::moved(law, p, end, memory, |moved| {
                    now[..moved.len()].copy_from_slice(moved);
                });
                memory.iter_mut().zip(now).for_each(|(to, now)| *to = S::constant(now));
                return;
            }
            let mut now = [S::zero(); MOST];
            moved(law, p, end, memory, |moved| now[..moved.len()].copy_from_slice(moved));
            memory.copy_from_slice(&now[..law.len]);
        }
    }

    fn observe<S: Scalar>(&self, p: &[S], seen: &mut Observed<'_, S>) {
        let step_s = seen.step_s;
        if let Some(delay_s) = self.once(self.once.position_delay_s.as_ref(), p) {
            let steps = delay_s.scaled(1.0 / step_s);
            delayed(steps, seen.displacement_mm);
            delayed(steps, seen.velocity_mm_s);
        }
        if let Some(delay_s) = self.once(self.once.pressure_delay_s.as_ref(), p) {
            let steps = delay_s.scaled(1.0 / step_s);
            seen.pressures_kpa.iter_mut().for_each(|series| delayed(steps, series));
        }
        self.sensors.observe(self.memory_of(Moment::Sensing), p, seen);
    }
}
