//! Experiments with a vector field, and terms of it as candidates.

use super::candidate::{Candidate, FieldOptions};
use super::features;
use crate::error::DiagnoseError;
use crate::fit::{Hypothesis, Sensitivities};
use crate::search::{CandidateInfo, Candidates, Nuisance, OutputInfo};
use crate::settings::DiagnosisSettings;
use pam_autodiff::{ByDual, Differentiation};
use pam_core::ParametricField;
use pam_effects::effects::ParameterInfo;
use pam_solvers::sensitivity::{Direction, ForwardSensitivity, Problem};
use pam_solvers::{ParametricInput, SaveAt, Side, Term};
use pam_train::field::{Experiment, FieldError, FieldProblem};
use std::ops::Range;

/// A field, experiments with it, and the terms that may be missing from it.
pub(super) struct FieldSystem<'a, F, I> {
    problem: &'a FieldProblem<'a, F, I>,
    experiments: &'a [Experiment<I>],
    candidates: &'a [Candidate],
    infos: Vec<Vec<ParameterInfo>>,
    /// The field's parameters with all candidates off.
    pub(super) plain: Vec<f64>,
    refitted: Vec<usize>,
    shared: Vec<Nuisance>,
    /// Initial states that are not known exactly.
    free_states: Vec<usize>,
    local: Vec<Nuisance>,
    outputs: Vec<OutputInfo>,
    /// Measured outputs of each experiment.
    measured: Vec<Vec<Vec<f64>>>,
    settings: DiagnosisSettings,
}

impl<'a, F, I> FieldSystem<'a, F, I>
where
    F: ParametricField + Sync,
    F::With<f64>: ParametricField,
    ByDual: Differentiation<F::With<f64>>,
    I: ParametricInput + Sync,
{
    pub(super) fn new(
        problem: &'a FieldProblem<'a, F, I>,
        experiments: &'a [Experiment<I>],
        candidates: &'a [Candidate],
        options: &FieldOptions,
    ) -> Self {
        let mut plain = problem.field.parameters();
        candidates.iter().for_each(|c| c.switch_off(&mut plain));
        let outputs = &problem.outputs;
        let deviation = |state: usize| match &options.initial_state_deviation {
            Some(deviations) => deviations[state],
            None => {
                let output = outputs.states.iter().position(|&s| s == state);
                output.map_or(0.0, |k| outputs.noise[k])
            }
        };
        let free_states: Vec<usize> =
            (0..problem.field.state_len()).filter(|&s| deviation(s) > 0.0).collect();
        let columns = |e: &Experiment<I>| -> Vec<Vec<f64>> {
            let m = outputs.len();
            (0..m).map(|c| e.measured.iter().skip(c).step_by(m).copied().collect()).collect()
        };
        Self {
            local: free_states.iter().map(|&s| Nuisance::of(deviation(s))).collect(),
            free_states,
            plain,
            shared: vec![Nuisance::of(f64::INFINITY); options.refitted.len()],
            refitted: options.refitted.clone(),
            infos: candidates.iter().map(|c| c.parameters.iter().map(|p| p.1).collect()).collect(),
            outputs: outputs
                .states
                .iter()
                .map(|s| OutputInfo {
                    key: format!("state_{s}"),
                    name: format!("state {s}"),
                    unit: "–".into(),
                    fitted: true,
                })
                .collect(),
            measured: experiments.iter().map(columns).collect(),
            settings: options.settings,
            problem,
            experiments,
            candidates,
        }
    }

    /// The field's parameters under a hypothesis.
    pub(super) fn parameters(&self, h: &Hypothesis) -> Vec<f64> {
        let mut parameters = self.plain.clone();
        for (&index, deviation) in self.refitted.iter().zip(&h.shared) {
            parameters[index] += deviation;
        }
        for member in &h.members {
            let indices = &self.candidates[member.candidate].parameters;
            for ((index, _), value) in indices.iter().zip(&member.values) {
                parameters[*index] = *value;
            }
        }
        parameters
    }

    fn initial_state(&self, local: &[f64], experiment: usize) -> Vec<f64> {
        let mut y0 = self.experiments[experiment].initial_state.clone();
        self.free_states.iter().zip(local).for_each(|(&s, d)| y0[s] += d);
        y0
    }

    fn failed(&self, experiment: usize, why: impl ToString) -> DiagnoseError {
        let experiment = self.experiments[experiment].name.clone();
        FieldError::Solve { experiment, why: why.to_string() }.into()
    }

    /// The states at the times of an experiment, row-major.
    pub(super) fn states(
        &self,
        h: &Hypothesis,
        local: &[f64],
        experiment: usize,
    ) -> Result<Vec<f64>, DiagnoseError> {
        let e = &self.experiments[experiment];
        let field = self.problem.field.with_parameters::<f64>(&self.parameters(h));
        let term = Term::new(&field, &e.input);
        let (t0, t1) = (e.times_s[0], e.times_s[e.times_s.len() - 1]);
        let y0 = self.initial_state(local, experiment);
        let solution = self.problem.integrator.solve(&term, t0, t1, &y0, SaveAt::Times(&e.times_s));
        let states = solution.map_err(|error| self.failed(experiment, error))?.states().to_vec();
        if states.iter().all(|v| v.is_finite()) {
            Ok(states)
        } else {
            Err(self.failed(experiment, "a state is not finite"))
        }
    }

    /// The inputs at the times of an experiment, input by input.
    pub(super) fn inputs(&self, experiment: usize) -> Vec<Vec<f64>> {
        let e = &self.experiments[experiment];
        let m = self.problem.field.input_len();
        let mut columns = vec![Vec::with_capacity(e.times_s.len()); m];
        let mut u = vec![0.0; m];
        for &t in &e.times_s {
            e.input.value_into(t, Side::Right, &mut u);
            columns.iter_mut().zip(&u).for_each(|(column, v)| column.push(*v));
        }
        columns
    }

    /// States (or their series) column by column.
    fn columns(&self, states: &[f64]) -> Vec<Vec<f64>> {
        let n = self.problem.field.state_len();
        (0..n).map(|i| states.iter().skip(i).step_by(n).copied().collect()).collect()
    }
}

impl<F, I> Candidates for FieldSystem<'_, F, I>
where
    F: ParametricField + Sync,
    F::With<f64>: ParametricField,
    ByDual: Differentiation<F::With<f64>>,
    I: ParametricInput + Sync,
{
    fn candidate_len(&self) -> usize {
        self.candidates.len()
    }

    fn candidate(&self, index: usize) -> CandidateInfo<'_> {
        let parameters = &self.infos[index];
        let id = &self.candidates[index].name;
        CandidateInfo {
            id,
            description: parameters.first().map_or("", |p| p.meaning),
            excited_by: "",
            parameters,
            value_len: parameters.len(),
        }
    }

    fn starts(&self, index: usize) -> Vec<Vec<f64>> {
        self.candidates[index].starts.clone()
    }

    fn shared(&self) -> &[Nuisance] {
        &self.shared
    }

    fn local(&self) -> &[Nuisance] {
        &self.local
    }

    fn outputs(&self) -> &[OutputInfo] {
        &self.outputs
    }

    fn name(&self, experiment: usize) -> &str {
        &self.experiments[experiment].name
    }

    fn points(&self, experiment: usize) -> usize {
        self.experiments[experiment].times_s.len()
    }

    fn time_s(&self, experiment: usize, point: usize) -> f64 {
        let times = &self.experiments[experiment].times_s;
        times[point.min(times.len() - 1)] - times[0]
    }

    fn start_s(&self, experiment: usize) -> f64 {
        self.experiments[experiment].times_s[0]
    }

    fn point_at(&self, experiment: usize, time_s: f64) -> usize {
        let times = &self.experiments[experiment].times_s;
        times.partition_point(|t| t - times[0] < time_s)
    }

    fn measured(&self, experiment: usize, output: usize) -> &[f64] {
        &self.measured[experiment][output]
    }

    fn rows_per_block(&self, rows: usize, _row_s: f64) -> usize {
        rows.div_ceil(self.settings.intervals.field_blocks).max(1)
    }

    fn simulate(
        &self,
        hypothesis: &Hypothesis,
        local: &[f64],
        experiment: usize,
    ) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        let states = self.columns(&self.states(hypothesis, local, experiment)?);
        Ok(self.problem.outputs.states.iter().map(|&s| states[s].clone()).collect())
    }

    fn sensitivities(
        &self,
        hypothesis: &Hypothesis,
        local: &[f64],
        experiment: usize,
        window: Range<usize>,
    ) -> Result<Sensitivities, DiagnoseError> {
        let e = &self.experiments[experiment];
        let parameters = self.parameters(hypothesis);
        let fitted = hypothesis.parameters(self);
        let index = |m: usize, value: usize| {
            self.candidates[hypothesis.members[m].candidate].parameters[value].0
        };
        // The value of a member replaces that of the field.
        let replaced = |k: usize| {
            let of = |c: usize| self.candidates[c].parameters.iter().any(|p| p.0 == k);
            hypothesis.members.iter().any(|m| of(m.candidate))
        };
        let mut slopes = Vec::new();
        let mut directions = Vec::new();
        for p in &fitted {
            let value = hypothesis.members[p.member].values[p.value];
            slopes.push(if p.info.logarithmic { value } else { 1.0 });
            directions.push(Direction::Parameter(index(p.member, p.value)));
        }
        for &k in &self.refitted {
            slopes.push(if replaced(k) { 0.0 } else { 1.0 });
            directions.push(Direction::Parameter(k));
        }
        for &s in &self.free_states {
            slopes.push(1.0);
            directions.push(Direction::InitialState(s));
        }
        let field = self.problem.field.with_parameters::<f64>(&parameters);
        let y0 = self.initial_state(local, experiment);
        let solved = ForwardSensitivity::new(ByDual)
            .with_directions(directions)
            .sensitivities(&Problem {
                field: &field,
                input: &e.input,
                t0: e.times_s[0],
                t1: e.times_s[e.times_s.len() - 1],
                y0: &y0,
                observations_s: &e.times_s,
                integrator: self.problem.integrator,
            })
            .map_err(|error| self.failed(experiment, error))?;
        if solved.tangents.iter().any(|t| !t.is_finite()) {
            let why = "the derivative of its states by a parameter is not finite; look for overflow in \
                       the field (sinh, cosh, exp of large numbers)";
            return Err(self.failed(experiment, why));
        }
        let n = self.problem.field.state_len();
        let outputs = self.problem.outputs.states.iter();
        let residual = |(c, &s): (usize, &usize)| -> Vec<f64> {
            let measured = &self.measured[experiment][c];
            window.clone().map(|k| measured[k] - solved.states[k * n + s]).collect()
        };
        let residuals = outputs.clone().enumerate().map(residual).collect();
        let columns = slopes
            .iter()
            .enumerate()
            .map(|(d, slope)| {
                let at = |k: usize, s: usize| (k * slopes.len() + d) * n + s;
                let column = |&s: &usize| -> Vec<f64> {
                    window.clone().map(|k| slope * solved.tangents[at(k, s)]).collect()
                };
                outputs.clone().map(column).collect()
            })
            .collect();
        Ok(Sensitivities { residuals, columns })
    }

    fn features(
        &self,
        hypothesis: &Hypothesis,
        local: &[f64],
        experiment: usize,
    ) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        let states = self.columns(&self.states(hypothesis, local, experiment)?);
        let width = self.settings.verdict.direction_width;
        Ok(features::features(&states, &self.inputs(experiment), width))
    }

    fn factor_names(&self) -> Vec<(String, String)> {
        let (n, m) = (self.problem.field.state_len(), self.problem.field.input_len());
        let numbered = |what: &'static str, count: usize| {
            (0..count).map(move |i| (format!("{what} {i}"), "–".to_owned()))
        };
        numbered("state", n)
            .chain(numbered("direction of state", n))
            .chain(numbered("input", m))
            .chain([("time".to_owned(), "s".to_owned())])
            .collect()
    }

    fn factors(
        &self,
        hypothesis: &Hypothesis,
        local: &[f64],
        experiment: usize,
        window: Range<usize>,
    ) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        let states = self.columns(&self.states(hypothesis, local, experiment)?);
        let last = self.points(experiment) - 1;
        let direction = |y: &Vec<f64>| -> Vec<f64> {
            let slope = |k: usize| (y[(k + 1).min(last)] - y[k.saturating_sub(1)]).signum();
            (0..=last).map(slope).collect()
        };
        let directions: Vec<Vec<f64>> = states.iter().map(direction).collect();
        let time = (0..=last).map(|k| self.time_s(experiment, k)).collect();
        let all = states.into_iter().chain(directions).chain(self.inputs(experiment)).chain([time]);
        Ok(all.map(|column: Vec<f64>| column[window.clone()].to_vec()).collect())
    }

    fn excitation_label(&self) -> String {
        "input 0".into()
    }

    fn excitation(&self, experiment: usize) -> Vec<f64> {
        self.inputs(experiment).into_iter().next().unwrap_or_default()
    }
}
