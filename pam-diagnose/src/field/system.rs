//! Experiments with a vector field, and terms of it as candidates.

use super::candidate::Candidate;
use super::features;
use super::gated::{Gate, Gated};
use super::labels::label;
use super::options::FieldOptions;
use super::perturbed::{Perturbed, Sizes};
use crate::error::DiagnoseError;
use crate::fit::{Hypothesis, Member, Sensitivities};
use crate::onset::Acts;
use crate::search::{CandidateInfo, Candidates, Nuisance, OutputInfo};
use crate::settings::DiagnosisSettings;
use pam_core::ParametricField;
use pam_solvers::{Input, Side};
use pam_train::field::{Experiment, FieldProblem, Number, Numbers};
use pam_vocabulary::ParameterInfo;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// A field, experiments with it, and the terms that may be missing from it.
pub(super) struct FieldSystem<'a, F, I> {
    problem: &'a FieldProblem<'a, F, I>,
    experiments: Vec<&'a Experiment<I>>,
    candidates: &'a [Candidate],
    infos: Vec<Vec<ParameterInfo>>,
    /// The field's parameters with all candidates off.
    pub(super) plain: Vec<f64>,
    /// Standard deviations of the priors of the candidates' parameters; none for free ones.
    pub(super) deviations: Vec<Vec<f64>>,
    refitted: Vec<usize>,
    /// Whether each refitted parameter is fitted by its logarithm.
    logarithmic: Vec<bool>,
    /// Whether the delay of the inputs is fitted, as the last shared nuisance.
    delayed: bool,
    shared: Vec<Nuisance>,
    /// Initial states that are not known exactly.
    free_states: Vec<usize>,
    pub(super) local: Vec<Nuisance>,
    outputs: Vec<OutputInfo>,
    /// Measured outputs of each experiment.
    measured: Vec<Vec<Vec<f64>>>,
    settings: DiagnosisSettings,
    /// Time between the rows of the most finely sampled experiment, s.
    row_s: f64,
    /// Sizes of the states, once they are needed.
    sizes: OnceLock<Arc<Sizes>>,
}

impl<'a, F, I> FieldSystem<'a, F, I>
where
    F: ParametricField + Sync,
    I: Input<f64> + Sync,
{
    pub(super) fn new(
        problem: &'a FieldProblem<'a, F, I>,
        experiments: Vec<&'a Experiment<I>>,
        candidates: &'a [Candidate],
        options: &FieldOptions,
    ) -> Self {
        let mut plain = problem.field.parameters();
        candidates.iter().for_each(|c| c.switch_off(&mut plain));
        let outputs = &problem.outputs;
        let deviation = |state: usize| match &options.initial_state_deviation {
            Some(deviations) => deviations[state],
            None => {
                let output = outputs.signals.iter().position(|&s| s == state);
                output.map_or(0.0, |k| outputs.noise[k])
            }
        };
        let free_states: Vec<usize> =
            (0..problem.field.state_len()).filter(|&s| deviation(s) > 0.0).collect();
        let columns = |e: &&Experiment<I>| -> Vec<Vec<f64>> {
            let m = outputs.len();
            (0..m).map(|c| e.measured.iter().skip(c).step_by(m).copied().collect()).collect()
        };
        let output = |key: String| {
            let (name, unit) = label(&key);
            OutputInfo { key, name, unit, fitted: true }
        };
        let delayed = options.delay_deviation_s > 0.0;
        let free = vec![f64::INFINITY; options.refitted.len()];
        let refitted = options.refitted_deviation.as_ref().unwrap_or(&free);
        let mut shared: Vec<Nuisance> = refitted.iter().map(|&d| Nuisance::of(d)).collect();
        shared.extend(delayed.then(|| Nuisance::of(options.delay_deviation_s)));
        Self {
            local: free_states.iter().map(|&s| Nuisance::of(deviation(s))).collect(),
            free_states,
            plain,
            deviations: Vec::new(),
            shared,
            delayed,
            logarithmic: options.refitted.iter().map(|k| options.logarithmic.contains(k)).collect(),
            refitted: options.refitted.clone(),
            infos: candidates.iter().map(|c| c.parameters.iter().map(|p| p.1).collect()).collect(),
            outputs: problem.output_names().into_iter().map(output).collect(),
            measured: experiments.iter().map(columns).collect(),
            settings: options.settings,
            row_s: experiments.iter().map(|e| e.sample_s()).fold(f64::INFINITY, f64::min),
            sizes: OnceLock::new(),
            problem,
            experiments,
            candidates,
        }
    }

    /// The field's parameters under a hypothesis, with every member there.
    pub(super) fn parameters(&self, h: &Hypothesis) -> Vec<f64> {
        self.parameters_where(h, |_| true)
    }

    /// The field's parameters with those members that are there.
    fn parameters_where(&self, h: &Hypothesis, there: impl Fn(&Member) -> bool) -> Vec<f64> {
        let mut parameters = self.plain.clone();
        let refitted = self.refitted.iter().zip(&self.logarithmic).zip(&h.shared);
        for ((&index, logarithmic), deviation) in refitted {
            if *logarithmic {
                parameters[index] *= deviation.exp();
            } else {
                parameters[index] += deviation;
            }
        }
        for member in h.members.iter().filter(|m| there(m)) {
            let indices = &self.candidates[member.candidate].parameters;
            for ((index, _), value) in indices.iter().zip(&member.values) {
                parameters[*index] = *value;
            }
        }
        parameters
    }

    /// The gates of members that come or go in an experiment, and the times of all members.
    fn gates(&self, h: &Hypothesis, experiment: usize) -> (Vec<Gate>, Vec<f64>) {
        let (mut gates, mut times) = (Vec::new(), Vec::new());
        for member in &h.members {
            if let Acts::Within(course, first) = acts(member, experiment) {
                let all = &self.candidates[member.candidate].parameters;
                let parameters = all.iter().filter_map(|(index, p)| Some((*index, p.off?)));
                let first = times.len() + first;
                gates.push(Gate { parameters: parameters.collect(), course, first });
            }
            times.extend(member.times());
        }
        (gates, times)
    }

    /// The delay of the inputs under a hypothesis, s.
    pub(super) fn delay_s(&self, h: &Hypothesis) -> f64 {
        if self.delayed { h.shared.last().copied().unwrap_or(0.0) } else { 0.0 }
    }

    fn numbers(&self, h: &Hypothesis, local: &[f64], experiment: usize) -> Numbers<f64> {
        let mut initial_state = self.problem.initial_state(self.experiments[experiment]);
        self.free_states.iter().zip(local).for_each(|(&s, d)| initial_state[s] += d);
        let parameters = self.parameters_where(h, |m| acts(m, experiment) != Acts::Never);
        Numbers { parameters, initial_state, delay_s: self.delay_s(h) }
    }

    /// The signals at the times of an experiment, signal by signal.
    fn signals(
        &self,
        h: &Hypothesis,
        local: &[f64],
        experiment: usize,
    ) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        let mut numbers = self.numbers(h, local, experiment);
        let e = self.experiments[experiment];
        let (gates, times) = self.gates(h, experiment);
        let signals = if gates.is_empty() {
            self.problem.simulate(e, &numbers)?
        } else {
            numbers.parameters.extend(&times);
            let gated = self.gated(gates, times.len(), experiment);
            self.over(&gated).simulate(e, &numbers)?
        };
        let width = self.problem.signal_len();
        Ok((0..width).map(|i| signals.iter().skip(i).step_by(width).copied().collect()).collect())
    }

    /// The states at the times of an experiment, state by state.
    pub(super) fn states(
        &self,
        h: &Hypothesis,
        local: &[f64],
        experiment: usize,
    ) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        let mut signals = self.signals(h, local, experiment)?;
        signals.truncate(self.problem.field.state_len());
        Ok(signals)
    }

    /// Responses of the measured outputs to small terms of every simple kind in the derivatives, to first order.
    fn responses(
        &self,
        h: &Hypothesis,
        local: &[f64],
        experiment: usize,
    ) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        // Of one motion for all experiments, so that a weight means the same in all of them.
        let sizes = self.sizes.get_or_init(|| {
            let base = Hypothesis::base(self, 1);
            let states = self.states(&base, &base.locals[0], 0);
            let unknown = vec![vec![1.0]; self.problem.field.state_len()];
            let width = self.settings.verdict.direction_width;
            Arc::new(Sizes::of(&states.unwrap_or(unknown), width))
        });
        let perturbed = Perturbed::new(self.problem.field, Arc::clone(sizes));
        let problem = self.over(&perturbed);
        let mut numbers = self.numbers(h, local, experiment);
        let own = numbers.parameters.len();
        numbers.parameters.resize(own + perturbed.weight_len(), 0.0);
        let by: Vec<Number> = (own..numbers.parameters.len()).map(Number::Parameter).collect();
        let found = problem.sensitivities(self.experiments[experiment], &numbers, &by)?;
        let width = problem.signal_len();
        let of = |by: &Vec<f64>, s: usize| by.iter().skip(s).step_by(width).copied().collect();
        let columns =
            found.by.iter().flat_map(|by| problem.outputs.signals.iter().map(move |&s| of(by, s)));
        Ok(columns.collect())
    }

    /// The field with terms that come and go in an experiment.
    fn gated(&self, gates: Vec<Gate>, times: usize, experiment: usize) -> Gated<'a, F> {
        let start_s = self.experiments[experiment].times_s[0];
        Gated::new(self.problem.field, gates, times, start_s, self.row_s)
    }

    /// The problem of another field, without experiments.
    fn over<'p, G: ParametricField>(&'p self, field: &'p G) -> FieldProblem<'p, G, I> {
        let FieldProblem { outputs, integrator, .. } = self.problem;
        FieldProblem::new(field, &[], outputs.clone(), integrator)
    }

    /// The inputs at the times of an experiment, input by input.
    pub(super) fn inputs(&self, experiment: usize) -> Vec<Vec<f64>> {
        let e = self.experiments[experiment];
        let m = e.input.input_len();
        let mut columns = vec![Vec::with_capacity(e.times_s.len()); m];
        let mut u = vec![0.0; m];
        for &t in &e.times_s {
            e.input.value_into(t, Side::Right, &mut u);
            columns.iter_mut().zip(&u).for_each(|(column, v)| column.push(*v));
        }
        columns
    }

    /// Number of inputs that an experiment has.
    fn input_len(&self) -> usize {
        self.experiments.first().map_or(0, |e| e.input.input_len())
    }
}

/// What a member does in an experiment; a planned experiment has it all the time.
fn acts(member: &Member, experiment: usize) -> Acts {
    let schedule = member.schedule.as_ref();
    schedule.and_then(|s| s.acts.get(experiment).copied()).unwrap_or(Acts::Always)
}

impl<F, I> Candidates for FieldSystem<'_, F, I>
where
    F: ParametricField + Sync,
    I: Input<f64> + Sync,
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

    fn parameter_deviation(&self, candidate: usize, parameter: usize) -> f64 {
        let own = self.deviations.get(candidate).and_then(|own| own.get(parameter));
        own.copied().unwrap_or(f64::INFINITY)
    }

    fn may_be_timed(&self, index: usize) -> bool {
        self.infos[index].iter().any(|p| p.off.is_some())
    }

    fn acts_at_rest(&self, _index: usize) -> bool {
        false
    }

    fn ramp_s(&self) -> f64 {
        self.row_s
    }

    fn shared(&self) -> &[Nuisance] {
        &self.shared
    }

    fn local(&self) -> &[Nuisance] {
        &self.local
    }

    fn experiment_len(&self) -> usize {
        self.experiments.len()
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

    fn resolution(&self, experiment: usize, output: usize) -> f64 {
        pam_numerics::statistics::resolution(&self.measured[experiment][output])
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
        _until: usize,
    ) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        let signals = self.signals(hypothesis, local, experiment)?;
        Ok(self.problem.outputs.signals.iter().map(|&s| signals[s].clone()).collect())
    }

    fn sensitivities(
        &self,
        hypothesis: &Hypothesis,
        local: &[f64],
        experiment: usize,
        window: Range<usize>,
    ) -> Result<Sensitivities, DiagnoseError> {
        let fitted = hypothesis.parameters(self);
        let there = |m: &Member| acts(m, experiment) != Acts::Never;
        // The value of a member replaces that of the field.
        let replaced = |k: usize| {
            let of = |c: usize| self.candidates[c].parameters.iter().any(|p| p.0 == k);
            hypothesis.members.iter().any(|m| there(m) && of(m.candidate))
        };
        let mut numbers = self.numbers(hypothesis, local, experiment);
        let (gates, times) = self.gates(hypothesis, experiment);
        let own = numbers.parameters.len();
        let mut slopes = Vec::new();
        let mut by = Vec::new();
        for p in &fitted {
            let member = &hypothesis.members[p.member];
            let value = member.values[p.value];
            let slope = if p.info.logarithmic { value } else { 1.0 };
            let indices = &self.candidates[member.candidate].parameters;
            let (index, has) = match indices.get(p.value) {
                Some((index, _)) => (*index, there(member)),
                None => {
                    let before = &hypothesis.members[..p.member];
                    let first: usize = before.iter().map(|m| m.times().len()).sum();
                    let time = p.value - member.own().len();
                    let schedule = member.schedule.as_ref();
                    let has = schedule.is_some_and(|s| s.times_in(experiment).contains(&time));
                    (own + first + time, has)
                }
            };
            slopes.push(if has { slope } else { 0.0 });
            // Where there are no gates there are no times among the parameters.
            by.push(Number::Parameter(if has { index } else { 0 }));
        }
        for (&k, logarithmic) in self.refitted.iter().zip(&self.logarithmic) {
            let slope = if *logarithmic { numbers.parameters[k] } else { 1.0 };
            slopes.push(if replaced(k) { 0.0 } else { slope });
            by.push(Number::Parameter(k));
        }
        if self.delayed {
            slopes.push(1.0);
            by.push(Number::Delay);
        }
        for &s in &self.free_states {
            slopes.push(1.0);
            by.push(Number::InitialState(s));
        }
        let e = self.experiments[experiment];
        let solved = if gates.is_empty() {
            self.problem.sensitivities(e, &numbers, &by)?
        } else {
            numbers.parameters.extend(&times);
            let gated = self.gated(gates, times.len(), experiment);
            self.over(&gated).sensitivities(e, &numbers, &by)?
        };
        let n = self.problem.signal_len();
        let outputs = self.problem.outputs.signals.iter();
        let residual = |(c, &s): (usize, &usize)| -> Vec<f64> {
            let measured = &self.measured[experiment][c];
            window.clone().map(|k| measured[k] - solved.signals[k * n + s]).collect()
        };
        let residuals = outputs.clone().enumerate().map(residual).collect();
        let columns = slopes
            .iter()
            .zip(&solved.by)
            .map(|(slope, by)| {
                let column = |&s: &usize| -> Vec<f64> {
                    window.clone().map(|k| slope * by[k * n + s]).collect()
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
        _simulated: &[Vec<f64>],
    ) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        let states = self.states(hypothesis, local, experiment)?;
        let width = self.settings.verdict.direction_width;
        let mut all = features::features(&states, &self.inputs(experiment), width);
        all.extend(self.responses(hypothesis, local, experiment)?);
        Ok(all)
    }

    fn factor_names(&self) -> Vec<(String, String)> {
        let names = self.problem.field.names();
        let (n, m) = (self.problem.field.state_len(), self.input_len());
        let states: Vec<(String, String)> = (0..n).map(|k| label(&names.state(k))).collect();
        let turned = |(name, _): &(String, String)| (format!("direction of {name}"), "–".into());
        let directions: Vec<(String, String)> = states.iter().map(turned).collect();
        let inputs = (0..m).map(|k| label(&names.input(k)));
        let time = [("time".to_owned(), "s".to_owned())];
        states.into_iter().chain(directions).chain(inputs).chain(time).collect()
    }

    fn factors(
        &self,
        hypothesis: &Hypothesis,
        local: &[f64],
        experiment: usize,
        window: Range<usize>,
    ) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        let states = self.states(hypothesis, local, experiment)?;
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
        let (name, unit) = label(&self.problem.field.names().input(0));
        if unit == "–" { name } else { format!("{name} in {unit}") }
    }

    fn excitation(&self, experiment: usize) -> Vec<f64> {
        self.inputs(experiment).into_iter().next().unwrap_or_default()
    }
}
