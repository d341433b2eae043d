//! Experiments that would distinguish confusable causes of a field.

use super::candidate::Candidate;
use super::diagnose::FieldDiagnosis;
use super::options::FieldOptions;
use super::system::FieldSystem;
use crate::design::difference;
use crate::fit::Hypothesis;
use crate::search::Candidates;
use pam_core::ParametricField;
use pam_core::parallel;
use pam_solvers::{Input, InputFn, ParametricInput, Side};
use pam_train::field::{Experiment, FieldProblem, Outputs};
use serde::Serialize;
use std::f64::consts::TAU;

/// How well an experiment separates a named cause from its alternatives.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FieldSeparation {
    /// Name of the experiment.
    pub experiment: String,
    /// Alternative and the difference that its own parameters cannot make up for: root mean square over all
    /// outputs in units of the noise.
    pub by_alternative: Vec<(String, f64)>,
}

impl FieldSeparation {
    /// The difference to the alternative that is hardest to distinguish.
    #[must_use]
    pub fn least(&self) -> f64 {
        self.by_alternative.iter().map(|a| a.1).fold(f64::INFINITY, f64::min)
    }
}

/// Tries planned experiments for the first confusable cause of a diagnosis, best separation first; empty if nothing is
/// confusable. Of a planned experiment, name, input, initial state and times count; it has no measurements.
#[must_use]
pub fn design_field<F, I, J>(
    problem: &FieldProblem<'_, F, I>,
    candidates: &[Candidate],
    options: &FieldOptions,
    diagnosis: &FieldDiagnosis,
    planned: &[Experiment<J>],
) -> Vec<FieldSeparation>
where
    F: ParametricField + Sync,
    I: Input<f64> + Sync,
    J: Input<f64> + Sync + Clone,
{
    let Some(place) = diagnosis.causes.iter().position(|c| !c.alternatives.is_empty()) else {
        return Vec::new();
    };
    let outputs = Outputs { noise: diagnosis.noise.clone(), ..problem.outputs.clone() };
    let points = |e: &Experiment<J>| e.times_s.len() * outputs.len();
    let planned: Vec<Experiment<J>> = planned
        .iter()
        .map(|e| Experiment { measured: vec![0.0; points(e)], ..e.clone() })
        .collect();
    let (field, integrator) = (problem.field, problem.integrator);
    let problem = FieldProblem::new(field, &planned, outputs.clone(), integrator);
    let mut all: Vec<FieldSeparation> = parallel::map(planned.len(), |k| {
        let experiment = &planned[k];
        let system = FieldSystem::new(&problem, vec![experiment], candidates, options);
        let named = Hypothesis {
            members: diagnosis.causes.iter().map(|c| c.member.clone()).collect(),
            shared: diagnosis.model.shared.clone(),
            ..Hypothesis::base(&system, 1)
        };
        let by_alternative = diagnosis.causes[place]
            .alternatives
            .iter()
            .map(|alternative| {
                let mut other = named.clone();
                other.members[place] = alternative.clone();
                let distance = difference(&system, &named, &other, place, &outputs.noise);
                let id = system.candidate(alternative.candidate).id.to_owned();
                (id, distance.unwrap_or(0.0))
            })
            .collect();
        FieldSeparation { experiment: experiment.name.clone(), by_alternative }
    });
    all.sort_by(|a, b| b.least().total_cmp(&a.least()));
    all
}

/// Planned experiments with sines of every input, as long and as finely sampled as the first experiment of a problem:
/// half, once and one and a half times the range of the inputs, with 2 to 32 periods.
#[must_use]
pub fn sine_experiments<F, I>(
    problem: &FieldProblem<'_, F, I>,
) -> Vec<Experiment<impl ParametricInput + Sync + Clone>>
where
    F: ParametricField + Sync,
    I: Input<f64> + Sync,
{
    let first = problem.experiments.first();
    let m = first.map_or(0, |e| e.input.input_len());
    let (mut low, mut high) = (vec![f64::INFINITY; m], vec![f64::NEG_INFINITY; m]);
    let mut u = vec![0.0; m];
    for e in problem.experiments {
        for &t in &e.times_s {
            e.input.value_into(t, Side::Right, &mut u);
            for k in 0..m {
                (low[k], high[k]) = (low[k].min(u[k]), high[k].max(u[k]));
            }
        }
    }
    let mut planned = Vec::new();
    for (e, scale) in first.into_iter().flat_map(|e| [0.5, 1.0, 1.5].map(|scale| (e, scale))) {
        let (from, to) = (e.times_s[0], e.times_s[e.times_s.len() - 1]);
        for periods in [2.0, 8.0, 32.0] {
            let (low, high) = (low.clone(), high.clone());
            let input = InputFn::new(m, move |t: f64, u: &mut [f64]| {
                let sine = (TAU * periods * (t - from) / (to - from)).sin();
                for (k, u) in u.iter_mut().enumerate() {
                    *u = 0.5 * (low[k] + high[k] + scale * (high[k] - low[k]) * sine);
                }
            });
            let name = format!("{scale} times the range, {:.3} Hz", periods / (to - from));
            let start = problem.initial_state(e);
            planned.push(
                Experiment::new(&name, input, e.times_s.clone(), Vec::new()).starting_at(start),
            );
        }
    }
    planned
}
