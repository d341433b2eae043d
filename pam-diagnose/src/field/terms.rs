//! A field as a system to which terms can be added.

use super::candidate::Candidate;
use super::labels::label;
use super::options::FieldOptions;
use super::system::FieldSystem;
use crate::error::DiagnoseError;
use crate::fit::Hypothesis;
use crate::search::Candidates;
use crate::terms::{Definition, Place, TermParameter, TermSpace, Unit, Variable, VariableKind};
use pam_core::{ParametricField, VectorField};
use pam_expression::Terms;
use pam_numerics::statistics::root_mean_square;
use pam_solvers::Input;
use pam_train::field::{Experiment, FieldError, FieldProblem};
use pam_vocabulary::ParameterInfo;
use pam_vocabulary::definition::keep;

/// A field, experiments with it, named causes, and whatever terms are asked for.
pub(super) struct FieldTerms<'a, F, I> {
    problem: &'a FieldProblem<'a, F, I>,
    experiments: Vec<&'a Experiment<I>>,
    /// The named causes.
    listed: Vec<Candidate>,
    /// The field's parameters with all candidates off, but for those of the baseline.
    plain: Vec<f64>,
    options: &'a FieldOptions,
    variables: Vec<Variable>,
    places: Vec<Place>,
    series: Vec<Vec<Vec<f64>>>,
}

/// Largest number of states of which the direction matters, and from which terms are few.
const FEW_STATES: usize = 3;
/// Points at which a rate is compared with the states.
const KINEMATIC_POINTS: usize = 5;
/// Typical size of what swings, over its root mean square.
const SWING: f64 = 1.5;

impl<'a, F, I> FieldTerms<'a, F, I>
where
    F: ParametricField + Sync,
    I: Input<f64> + Sync,
{
    pub(super) fn new(
        problem: &'a FieldProblem<'a, F, I>,
        experiments: Vec<&'a Experiment<I>>,
        listed: Vec<Candidate>,
        plain: Vec<f64>,
        options: &'a FieldOptions,
    ) -> Self {
        let mut space = Self {
            problem,
            experiments,
            listed,
            plain,
            options,
            variables: Vec::new(),
            places: Vec::new(),
            series: Vec::new(),
        };
        space.series = (0..space.experiments.len()).map(|e| space.measured(e)).collect();
        space.variables = space.variables();
        space.places = space.places();
        space
    }

    fn names(&self) -> (Vec<String>, Vec<String>) {
        let names = self.problem.field.names();
        let (n, m) = (self.problem.field.state_len(), self.problem.field.input_len());
        ((0..n).map(|k| names.state(k)).collect(), (0..m).map(|k| names.input(k)).collect())
    }

    /// States, inputs and time of an experiment: as measured, else as the field without any cause has them.
    fn measured(&self, experiment: usize) -> Vec<Vec<f64>> {
        let e = self.experiments[experiment];
        let mut system =
            FieldSystem::new(self.problem, self.experiments.clone(), &self.listed, self.options);
        system.plain.clone_from(&self.plain);
        let base = Hypothesis::base(&system, 1);
        let n = self.problem.field.state_len();
        let simulated = system.states(&base, &base.locals[0], experiment);
        let mut states = simulated.unwrap_or_else(|_| vec![vec![0.0; e.times_s.len()]; n]);
        for (output, &signal) in self.problem.outputs.signals.iter().enumerate() {
            if let Some(state) = states.get_mut(signal) {
                *state = system.measured(experiment, output).to_vec();
            }
        }
        let time = e.times_s.iter().map(|t| t - e.times_s[0]).collect();
        states.into_iter().chain(system.inputs(experiment)).chain([time]).collect()
    }

    fn size(&self, variable: usize) -> f64 {
        let all: Vec<f64> = self.series.iter().flat_map(|s| s[variable].iter().copied()).collect();
        (SWING * root_mean_square(&all)).max(1e-12)
    }

    fn variables(&self) -> Vec<Variable> {
        let (states, inputs) = self.names();
        let few = states.len() <= FEW_STATES;
        let of_states = if few { VariableKind::Turning } else { VariableKind::Moving };
        let kinds =
            states.iter().map(|_| of_states).chain(inputs.iter().map(|_| VariableKind::Moving));
        let names = states.iter().chain(&inputs);
        let length = ((states.len() + inputs.len()).max(2) as f64).ln();
        let mut all: Vec<Variable> = names
            .zip(kinds)
            .enumerate()
            .map(|(k, (name, kind))| {
                let (words, unit_text) = label(name);
                Variable {
                    group: words.clone(),
                    name: words,
                    text: name.clone(),
                    names: vec![name.clone()],
                    unit: Unit::UNKNOWN,
                    unit_text,
                    size: self.size(k),
                    kind,
                    signed: true,
                    at_start: None,
                    change: None,
                    description_length: length,
                }
            })
            .collect();
        all.push(Variable {
            name: "time".into(),
            text: "t".into(),
            group: "time".into(),
            names: vec!["t".into()],
            unit: Unit::UNKNOWN,
            unit_text: "s".into(),
            size: self.size(all.len()),
            kind: VariableKind::Slow,
            signed: false,
            at_start: None,
            change: None,
            description_length: length + 1.0,
        });
        all
    }

    fn places(&self) -> Vec<Place> {
        let (states, _) = self.names();
        let length = (states.len().max(1) as f64).ln() + 0.5;
        let rate = |state: usize| -> f64 {
            let slopes: Vec<f64> = self
                .experiments
                .iter()
                .zip(&self.series)
                .flat_map(|(e, series)| {
                    let steps = e.times_s.windows(2).zip(series[state].windows(2));
                    // Noise has slopes as well: over a few samples.
                    steps.map(|(t, y)| (y[1] - y[0]) / (t[1] - t[0])).collect::<Vec<f64>>()
                })
                .collect();
            root_mean_square(&slopes).max(1e-12)
        };
        let of = |(k, name): (usize, &String)| Place {
            id: name.clone(),
            name: format!("rate of {}", label(name).0),
            unit: Unit::UNKNOWN,
            unit_text: String::new(),
            size: rate(k),
            targets: vec![(format!("d_{name}"), String::new(), 1.0)],
            variables: (0..self.variables.len()).collect(),
            rich: states.len() <= FEW_STATES,
            remembers: false,
            dry: None,
            family: k,
            description_length: length,
        };
        let kinematic = self.kinematic();
        let free = states.iter().enumerate().filter(|(k, _)| !kinematic[*k]);
        let places: Vec<Place> = free.map(of).collect();
        if places.is_empty() { states.iter().enumerate().map(of).collect() } else { places }
    }

    /// Which rates are another state whatever the field's numbers are: that of a position is the velocity by definition, and
    /// what is missing does not act there.
    fn kinematic(&self) -> Vec<bool> {
        let field = self.problem.field.with_parameters(&self.plain);
        let (n, m) = (field.state_len(), field.input_len());
        let mut work = vec![0.0; field.work_len()];
        let mut is = vec![vec![true; n]; n];
        for point in 0..KINEMATIC_POINTS {
            // Points that do not lie on a motion.
            let at = |k: usize| self.variables[k].size * (1.7 * (point + 3 * k) as f64 + 0.4).sin();
            let y: Vec<f64> = (0..n).map(at).collect();
            let u: Vec<f64> = (n..n + m).map(at).collect();
            let mut dy = vec![0.0; n];
            field.eval_into(0.0, &y, &u, &mut dy, &mut work);
            for (row, rate) in is.iter_mut().zip(&dy) {
                row.iter_mut().zip(&y).for_each(|(is, state)| *is &= rate == state);
            }
        }
        is.into_iter().map(|row| row.contains(&true)).collect()
    }
}

impl<F, I> TermSpace for FieldTerms<'_, F, I>
where
    F: ParametricField + Sync,
    I: Input<f64> + Sync,
{
    fn variables(&self) -> &[Variable] {
        &self.variables
    }

    fn places(&self) -> &[Place] {
        &self.places
    }

    fn call_with(
        &self,
        definitions: &[Definition],
        then: &mut dyn FnMut(&dyn Candidates) -> Result<(), DiagnoseError>,
    ) -> Result<(), DiagnoseError> {
        let (states, inputs) = self.names();
        let texts = |names: &[String]| names.iter().map(|n| keep(n)).collect::<Vec<&str>>();
        let mut terms = Terms::new(&texts(&states), &texts(&inputs));
        for d in definitions {
            let info =
                |p: &TermParameter| -> (ParameterInfo, f64) { (p.info(keep(&p.name)), p.start) };
            let parameters: Vec<(ParameterInfo, f64)> = d.parameters.iter().map(info).collect();
            let adds: Vec<(&str, &str)> = d
                .acts
                .iter()
                .map(|[place, text]| (place.strip_prefix("d_").unwrap_or(place), text.as_str()))
                .collect();
            terms = terms.term(&d.id, &parameters, &adds).map_err(|e| {
                DiagnoseError::from(FieldError::Shape(format!("term `{}`: {e}", d.id)))
            })?;
        }
        let field = terms.onto(self.problem.field);
        let mut candidates = self.listed.clone();
        candidates.extend(Candidate::of_terms(&field));
        let FieldProblem { experiments, held_out, integrator, .. } = *self.problem;
        let outputs = self.problem.outputs.clone();
        let problem = FieldProblem { field: &field, experiments, held_out, outputs, integrator };
        let of = self.experiments.clone();
        let mut system = FieldSystem::new(&problem, of, &candidates, self.options);
        system.plain[..self.plain.len()].copy_from_slice(&self.plain);
        system.deviations = vec![Vec::new(); self.listed.len()];
        system
            .deviations
            .extend(definitions.iter().map(|d| d.parameters.iter().map(|p| p.deviation).collect()));
        then(&system)
    }

    fn series(&self, experiment: usize) -> Vec<Vec<f64>> {
        self.series[experiment].clone()
    }

    fn step_s(&self, experiment: usize) -> f64 {
        let times = &self.experiments[experiment].times_s;
        (times[times.len() - 1] - times[0]) / (times.len() - 1).max(1) as f64
    }

    fn file(&self, definitions: &[Definition]) -> String {
        definitions.iter().map(Definition::to_toml).collect::<Vec<_>>().join("\n")
    }
}
