//! The diagnosis of a field, from experiments on.

use super::candidate::{Candidate, FieldOptions};
use super::system::FieldSystem;
use crate::data::{OpenPart, Roles, Span, TestSource};
use crate::diagnosis::{self, Baseline, Diagnosis, Prepared};
use crate::error::DiagnoseError;
use crate::noise::{NoisePrior, noise_deviation};
use crate::report::ReportModel;
use maud::{Markup, html};
use pam_autodiff::{ByDual, Differentiation};
use pam_core::ParametricField;
use pam_solvers::ParametricInput;
use pam_train::field::{Experiment, FieldError, FieldProblem, Outputs};
use serde::Serialize;

/// The baseline discrepancy of a field.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FieldBaseline {
    /// Candidates that the baseline experiments show; part of the field from there on.
    pub effects: Vec<String>,
    /// Root-mean-square error of each output that is left then.
    pub rms: Vec<f64>,
    /// Names of the baseline experiments.
    pub recordings: Vec<String>,
}

/// The field's own part of a diagnosis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DiagnosedField {
    /// The field's parameters with the named causes in them.
    pub parameters: Vec<f64>,
    /// The baseline discrepancy, if baseline experiments were given.
    pub baseline: Option<FieldBaseline>,
    /// Fitted deviations of the refitted parameters.
    #[serde(skip)]
    pub(super) shared: Vec<f64>,
}

/// A diagnosis of a field.
pub type FieldDiagnosis = Diagnosis<DiagnosedField>;

/// Names the causes of a field's error, out of the candidates that its author lists.
///
/// The experiments are divided into training, validation and test data as in [`diagnose`](crate::diagnose), and
/// the search, the rejection of names and the verdict are the same. A noise level of the outputs that is NaN
/// ([`Outputs::of_unknown_noise`]) is estimated from the open data.
///
/// # Errors
/// [`DiagnoseError`] if the shapes do not fit or the field without any cause cannot be solved.
pub fn diagnose_field<F, I>(
    problem: &FieldProblem<'_, F, I>,
    candidates: &[Candidate],
    options: &FieldOptions,
) -> Result<FieldDiagnosis, DiagnoseError>
where
    F: ParametricField + Sync,
    F::With<f64>: ParametricField,
    ByDual: Differentiation<F::With<f64>>,
    I: ParametricInput + Sync,
{
    with_noise(problem, |_, _| 1.0).check()?;
    check(problem, candidates, options)?;
    let mut settings = options.settings;
    let data = problem.experiments.len() - options.baseline;
    // An experiment of a field may be short or long: lengths of time follow from it.
    let duration = |e: &Experiment<I>| e.times_s[e.times_s.len() - 1] - e.times_s[0];
    let shortest_s = problem.experiments[..data].iter().map(duration).fold(f64::INFINITY, f64::min);
    settings.data.shortest_s = 0.0;
    settings.intervals.shortest_block_s = 0.0;
    let residual = &mut settings.residual;
    residual.spectrum_piece_s = shortest_s / residual.field_spectrum_pieces;
    residual.spectrum_highest_hz = residual.field_spectrum_lines / residual.spectrum_piece_s;
    residual.profile_block_s = shortest_s / residual.field_profile_blocks;
    residual.jump_margin_s = shortest_s * residual.field_jump_margin;
    let (experiments, of_baseline) = problem.experiments.split_at(data);
    let source = match options.test {
        0 => TestSource::Kept,
        test => TestSource::GivenFrom(data - test),
    };
    let span = |e: &Experiment<I>| Span { name: e.name.clone(), duration_s: duration(e) };
    let roles_of = |experiments: &[Experiment<I>], source| {
        let spans: Vec<Span> = experiments.iter().map(span).collect();
        Roles::assign(&spans, source, options.seed, &settings.data)
    };
    let roles = roles_of(experiments, source)?;
    let open = roles.open();
    // A noise level that is given is a lower limit; one that is not known is learned.
    let given = |n: &f64| if n.is_nan() { f64::MIN_POSITIVE.sqrt() } else { *n };
    let least = problem.outputs.noise.iter().map(given).collect();
    let problem = &with_noise(problem, |output, outputs| {
        let column = |part: &OpenPart| -> Vec<f64> {
            let e = &experiments[part.experiment];
            let rows = e.times_s.partition_point(|t| t - e.times_s[0] < part.end_s);
            e.measured.iter().skip(output).step_by(outputs).take(rows).copied().collect()
        };
        let series: Vec<Vec<f64>> = open.iter().map(column).collect();
        noise_deviation(&series, settings.noise.relative)
    });
    let noise = problem.outputs.noise.clone();
    let mut prior = NoisePrior::at_least(least);
    let mut system = FieldSystem::new(problem, experiments, candidates, options);
    let mut on_baseline = FieldSystem::new(problem, of_baseline, candidates, options);
    let (mut baseline, mut baseline_discrepancy) = (None, Vec::new());
    if !of_baseline.is_empty() {
        let roles = roles_of(of_baseline, TestSource::Kept)?;
        let seed = options.seed;
        let own = prior.clone();
        let learned = Baseline::learn(&on_baseline, &roles, &noise, own, &settings, seed, &|_| {})?;
        let effects = learned.members.iter().map(|m| candidates[m.candidate].name.clone());
        let effects = effects.collect();
        for member in &learned.members {
            let indices = &candidates[member.candidate].parameters;
            for ((index, _), value) in indices.iter().zip(&member.values) {
                (system.plain[*index], on_baseline.plain[*index]) = (*value, *value);
            }
        }
        baseline_discrepancy =
            learned.discrepancy.iter().map(|d| d.first().map_or(0.0, |v| v.sqrt())).collect();
        prior.add(learned.discrepancy);
        let (rms, recordings) = (learned.rms, learned.recordings);
        baseline = Some((FieldBaseline { effects, rms, recordings }, roles, learned.noise));
    }
    let prepared = Prepared {
        system: &system,
        roles: &roles,
        noise,
        prior,
        baseline_discrepancy,
        baseline: baseline.as_ref().map(|(_, r, n)| r.whole(&on_baseline, n, &settings)),
        settings: &settings,
        seed: options.seed,
    };
    diagnosis::run(&prepared, &|_, _| {}, |best| DiagnosedField {
        parameters: system.parameters(best),
        baseline: baseline.as_ref().map(|b| b.0.clone()),
        shared: best.shared.clone(),
    })
}

/// The problem with another value for each noise level that is not known; `estimate` gets the index of the output and
/// the number of outputs.
fn with_noise<'a, F, I>(
    problem: &FieldProblem<'a, F, I>,
    estimate: impl Fn(usize, usize) -> f64,
) -> FieldProblem<'a, F, I> {
    let Outputs { states, noise } = &problem.outputs;
    let known = |(c, n): (usize, &f64)| if n.is_nan() { estimate(c, noise.len()) } else { *n };
    let noise = noise.iter().enumerate().map(known).collect();
    FieldProblem { outputs: Outputs { states: states.clone(), noise }, ..*problem }
}

fn check<F: ParametricField, I>(
    problem: &FieldProblem<'_, F, I>,
    candidates: &[Candidate],
    options: &FieldOptions,
) -> Result<(), DiagnoseError> {
    let fail = |message: String| Err(FieldError::Shape(message).into());
    let (len, states) = (problem.field.parameter_len(), problem.field.state_len());
    for c in candidates {
        let fits = |s: &Vec<f64>| s.len() == c.parameters.len();
        let inside = c.parameters.iter().all(|(i, _)| *i < len);
        if !inside || c.starts.is_empty() || !c.starts.iter().all(fits) {
            return fail(format!(
                "candidate `{}`: parameters {:?} and starting values {:?} do not fit a field of {len} \
                 parameters",
                c.name,
                c.parameters.iter().map(|p| p.0).collect::<Vec<_>>(),
                c.starts
            ));
        }
    }
    if let Some(bad) = options.refitted.iter().find(|&&i| i >= len) {
        return fail(format!("the field has no parameter {bad} to refit"));
    }
    if let Some(d) = &options.initial_state_deviation
        && (d.len() != states || d.iter().any(|v| !(v.is_finite() && *v >= 0.0)))
    {
        return fail(format!(
            "the prior standard deviations {d:?} of the initial state must be {states} finite values of at \
             least 0"
        ));
    }
    let (test, baseline, all) = (options.test, options.baseline, problem.experiments.len());
    if test + baseline >= all {
        return fail(format!(
            "of {all} experiments, {test} for the test set and {baseline} for the baseline leave none"
        ));
    }
    options.settings.check()
}

impl ReportModel for DiagnosedField {
    fn notes(&self) -> Markup {
        html! {
            @if let Some(b) = &self.baseline {
                p {
                    "Baseline discrepancy of the field, from " (b.recordings.join(", ")) ": RMS "
                    (b.rms.iter().map(|r| pam_effects::model::significant(*r, 3)).collect::<Vec<_>>().join(", "))
                    @if !b.effects.is_empty() { " with " (b.effects.join(", ")) }
                    ". That much counts as no fault."
                }
            }
        }
    }

    fn extension(&self) -> Markup {
        html! { "These terms of the field are switched on; its other parameters stay as they are, or as refitted." }
    }
}
