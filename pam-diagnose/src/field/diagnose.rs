//! The diagnosis of a field, from experiments on.

use super::candidate::Candidate;
use super::options::{FieldNoise, FieldOptions};
use super::system::FieldSystem;
use crate::data::{OpenPart, Roles, Span, TestSource, range};
use crate::diagnosis::{self, Baseline, Diagnosis, Prepared};
use crate::error::DiagnoseError;
use crate::noise::{Discrepancy, NoisePrior, noise_deviation};
#[cfg(feature = "report")]
use crate::report::ReportModel;
use crate::search::{Candidates, Nuisance};
use crate::settings::DiagnosisSettings;
use crate::verdict::Cause;
#[cfg(feature = "report")]
use maud::{Markup, html};
use pam_core::ParametricField;
use pam_solvers::Input;
use pam_train::field::{Experiment, FieldError, FieldProblem, Outputs};
use serde::Serialize;
use std::cmp::Ordering;

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
    /// Their names.
    pub parameter_names: Vec<String>,
    /// The fitted delay of the inputs, s; absent where none was fitted.
    pub delay_s: Option<f64>,
    /// The baseline discrepancy, if baseline experiments were given.
    pub baseline: Option<FieldBaseline>,
    /// Fitted deviations of the refitted parameters and of the delay.
    #[serde(skip)]
    pub(super) shared: Vec<f64>,
    /// The field's parameters with all candidates off, but for those of the baseline.
    #[serde(skip)]
    pub(super) plain: Vec<f64>,
    /// The errors of the baseline experiments that go with the motion.
    #[serde(skip)]
    pub(super) discrepancy: Discrepancy,
}

/// A diagnosis of a field.
pub type FieldDiagnosis = Diagnosis<DiagnosedField>;

/// Names the causes of a field's error, out of the candidates that its author lists.
///
/// The experiments are divided into training and validation data as in [`diagnose`](crate::diagnose), and
/// the search, the rejection of names and the verdict are the same. The held-out experiments of the problem are the test data;
/// without any, a part of the experiments is. The noise is learned from the open data, unless
/// [`FieldOptions::noise`] says otherwise.
///
/// ```
/// use pam_core::field_fn;
/// use pam_diagnose::Verdict;
/// use pam_diagnose::field::{Candidate, FieldOptions, diagnose_field};
/// use pam_solvers::{InputFn, Integrator, PidController, SaveAt, Tableau, Term};
/// use pam_train::field::{Experiment, FieldProblem, Outputs};
///
/// // A cart with drag (p[0]) and a drift of its motor (p[1]); the model lacks both, and the real one has drag.
/// let model = field_fn!([0.0, 0.0], 1 => 1, |_t, y, u, p, dy| dy[0] = u[0] - p[0] * y[0] + p[1]);
/// let real = field_fn!([0.4, 0.0], 1 => 1, |_t, y, u, p, dy| dy[0] = u[0] - p[0] * y[0] + p[1]);
/// let integrator = Integrator::new(Tableau::tsit5(), PidController::new(1e-7, 1e-7));
/// let mut draw = 1_u32; // noise from a linear congruential generator
/// let mut noise = || {
///     draw = draw.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
///     0.01 * (f64::from(draw >> 8) / f64::from(1 << 24) - 0.5)
/// };
/// let mut runs = Vec::new();
/// for rate_rad_s in [1.0, 2.0, 3.0, 5.0] {
///     let force = InputFn::new(1, move |t: f64, u: &mut [f64]| u[0] = (rate_rad_s * t).sin());
///     let times_s: Vec<f64> = (0..400).map(|k| 0.05 * f64::from(k)).collect();
///     let run = integrator.solve(
///         &Term::new(&real, force), 0.0, times_s[399], &[0.0], SaveAt::Times(&times_s),
///     )?;
///     let measured = run.component(0).map(|v| v + noise()).collect();
///     runs.push(Experiment::new(&format!("{rate_rad_s} rad/s"), force, times_s, measured));
/// }
/// let candidates = [
///     Candidate::term("drag", (0, "per_s"), [0.0, 5.0], &[0.1]),
///     Candidate::term("drift", (1, "m_s2"), [-1.0, 1.0], &[0.05]),
/// ];
/// let problem = FieldProblem::new(&model, &runs, Outputs::of_unknown_noise([0]), &integrator);
/// let found = diagnose_field(&problem, &candidates, &FieldOptions::default())?;
/// assert_eq!(found.named(), ["drag"]);
/// assert_eq!(found.verdict, Verdict::Explained);
/// assert!((found.model.parameters[0] - 0.4).abs() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
    I: Input<f64> + Sync,
{
    with_setup(problem, candidates, options, |setup| {
        let Setup { problem, settings, roles, noise, prior, experiments, of_baseline } = setup;
        let mut prior = prior;
        let mut system = FieldSystem::new(problem, experiments, candidates, options);
        let baseline_roles = if of_baseline.is_empty() {
            None
        } else {
            Some(roles_of(&of_baseline, TestSource::Kept, &settings)?)
        };
        let mut on_baseline = FieldSystem::new(problem, of_baseline, candidates, options);
        let (mut baseline, mut baseline_discrepancy) = (None, Vec::new());
        let mut discrepancy = Discrepancy::default();
        if let Some(roles) = baseline_roles {
            let seed = options.seed;
            let own = prior.clone();
            let learned =
                Baseline::learn(&on_baseline, &roles, &noise, own, &settings, seed, &|_| {})?;
            let effects = learned.members.iter().map(|m| candidates[m.candidate].name.clone());
            let effects = effects.collect();
            for member in &learned.members {
                let indices = &candidates[member.candidate].parameters;
                for ((index, _), value) in indices.iter().zip(&member.values) {
                    (system.plain[*index], on_baseline.plain[*index]) = (*value, *value);
                }
            }
            Nuisance::widen(&mut system.local, &learned.local_widenings);
            baseline_discrepancy = learned.discrepancy.covariances.deviations();
            prior.discrepancy.add(&learned.discrepancy);
            discrepancy = learned.discrepancy;
            let (rms, recordings) = (learned.rms, learned.recordings);
            baseline = Some((FieldBaseline { effects, rms, recordings }, roles, learned.noise));
        }
        let prepared = Prepared {
            system: &system,
            roles: &roles,
            noise,
            prior,
            baseline_discrepancy,
            baseline: baseline
                .as_ref()
                .map(|(_, r, n)| r.whole(&on_baseline as &dyn Candidates, n, &settings)),
            settings: &settings,
            seed: options.seed,
        };
        let names = problem.field.names();
        let mut found = diagnosis::run(&prepared, &|_, _| {}, |best| DiagnosedField {
            parameters: system.parameters(best),
            parameter_names: (0..system.plain.len()).map(|k| names.parameter(k)).collect(),
            delay_s: (options.delay_deviation_s > 0.0).then(|| system.delay_s(best)),
            baseline: baseline.as_ref().map(|b| b.0.clone()),
            shared: best.shared.clone(),
            plain: system.plain.clone(),
            discrepancy: discrepancy.clone(),
        })?;
        put_properties_behind(&mut found.causes, candidates);
        Ok(found)
    })
}

/// A field problem before a search: settings for its lengths of time, roles, the first estimate of the noise.
pub(super) struct Setup<'s, F, I> {
    pub(super) problem: &'s FieldProblem<'s, F, I>,
    pub(super) settings: DiagnosisSettings,
    pub(super) roles: Roles,
    pub(super) noise: Vec<f64>,
    pub(super) prior: NoisePrior,
    pub(super) experiments: Vec<&'s Experiment<I>>,
    of_baseline: Vec<&'s Experiment<I>>,
}

fn duration_s<I>(e: &Experiment<I>) -> f64 {
    e.times_s[e.times_s.len() - 1] - e.times_s[0]
}

/// Ranges of the measured outputs.
fn ranges<I>(e: &Experiment<I>) -> Vec<[f64; 2]> {
    let outputs = e.measured.len() / e.times_s.len();
    let of = |output: usize| range(e.measured.iter().skip(output).step_by(outputs).copied());
    (0..outputs).map(of).collect()
}

fn roles_of<I>(
    experiments: &[&Experiment<I>],
    source: TestSource,
    settings: &DiagnosisSettings,
) -> Result<Roles, DiagnoseError> {
    let span = |e: &&Experiment<I>| Span {
        name: e.name.clone(),
        duration_s: duration_s(e),
        ranges: ranges(e),
    };
    let spans: Vec<Span> = experiments.iter().map(span).collect();
    Roles::assign(&spans, source, &settings.data)
}

/// Checks a problem and prepares it.
pub(super) fn with_setup<F, I, R>(
    problem: &FieldProblem<'_, F, I>,
    candidates: &[Candidate],
    options: &FieldOptions,
    then: impl FnOnce(Setup<'_, F, I>) -> Result<R, DiagnoseError>,
) -> Result<R, DiagnoseError>
where
    F: ParametricField + Sync,
    I: Input<f64> + Sync,
{
    problem.check()?;
    check(problem, candidates, options)?;
    let mut settings = options.settings;
    let (open, of_baseline) =
        problem.experiments.split_at(problem.experiments.len() - options.baseline);
    let experiments: Vec<&Experiment<I>> = open.iter().chain(problem.held_out).collect();
    let of_baseline: Vec<&Experiment<I>> = of_baseline.iter().collect();
    // An experiment of a field may be short or long: lengths of time follow from it.
    let shortest_s = experiments.iter().map(|e| duration_s(e)).fold(f64::INFINITY, f64::min);
    settings.data.shortest_s = 0.0;
    settings.intervals.shortest_block_s = 0.0;
    // What a wrong model leaves of a free motion drifts, and a filter that makes it white takes the motion with it. So
    // noise is white here, and what is correlated counts as fewer observations.
    settings.noise.order = 0;
    // A quarter of the oscillations of a short experiment may lie in half a second of the joint.
    settings.onset.cell_rows = settings.onset.cell_rows.min(FIELD_CELL_ROWS);
    settings.onset.fewest_cell_rows = 1;
    let residual = &mut settings.residual;
    residual.spectrum_piece_s = shortest_s / residual.field_spectrum_pieces;
    residual.spectrum_highest_hz = residual.field_spectrum_lines / residual.spectrum_piece_s;
    residual.profile_block_s = shortest_s / residual.field_profile_blocks;
    residual.jump_margin_s = shortest_s * residual.field_jump_margin;
    let source = if problem.held_out.is_empty() {
        TestSource::Kept
    } else {
        TestSource::GivenFrom(open.len())
    };
    let roles = roles_of(&experiments, source, &settings)?;
    let open = roles.open();
    let series = |output: usize| -> Vec<Vec<f64>> {
        let outputs = problem.outputs.len();
        let column = |part: &OpenPart| -> Vec<f64> {
            let e = experiments[part.experiment];
            let rows = e.times_s.partition_point(|t| t - e.times_s[0] < part.end_s);
            e.measured.iter().skip(output).step_by(outputs).take(rows).copied().collect()
        };
        open.iter().map(column).collect()
    };
    let prior = noise_prior(&problem.outputs.noise, options.noise, |output| {
        LEAST_SHARE * noise_deviation(&series(output), 1.0)
    });
    // Where the size of the noise is not given, the first estimate of it is one from the data.
    let first = problem.outputs.noise.iter().enumerate().map(|(output, &given)| {
        if given.is_nan() || options.noise == FieldNoise::Learned {
            noise_deviation(&series(output), settings.noise.relative)
        } else {
            given
        }
    });
    let noise: Vec<f64> = first.collect();
    let outputs = Outputs { noise: noise.clone(), ..problem.outputs.clone() };
    let problem = &FieldProblem { outputs, ..*problem };
    then(Setup { problem, settings, roles, noise, prior, experiments, of_baseline })
}

/// Moves every cause that is a property of another named one behind it; the rest keeps its order.
fn put_properties_behind(causes: &mut Vec<Cause>, candidates: &[Candidate]) {
    let owner_of = |cause: &Cause| candidates[cause.member.candidate].property_of.clone();
    for from in (0..causes.len()).rev() {
        let Some(owner) = owner_of(&causes[from]) else { continue };
        let behind = causes[from..].iter().position(|c| c.effect == owner);
        if let Some(places) = behind {
            let property = causes.remove(from);
            causes.insert(from + places, property);
        }
    }
}

/// Most rows of a cell of time in which a term of a field may begin.
const FIELD_CELL_ROWS: usize = 10;

/// Part of the variation of an output that is no noise but the error of solver and rounding, where noise is learned.
const LEAST_SHARE: f64 = 1e-6;

/// Prior knowledge of the noise, from the given levels and how they are to be taken; `least` is the least noise of an
/// output.
fn noise_prior(levels: &[f64], taken: FieldNoise, least: impl Fn(usize) -> f64) -> NoisePrior {
    let known = |n: &f64| (!n.is_nan()).then_some(*n);
    let at_least = taken == FieldNoise::AtLeast;
    let lowest = |(k, n): (usize, &f64)| known(n).filter(|_| at_least).unwrap_or_else(|| least(k));
    NoisePrior {
        given: match taken {
            FieldNoise::Given => levels.iter().map(known).collect(),
            FieldNoise::Learned | FieldNoise::AtLeast => Vec::new(),
        },
        ..NoisePrior::at_least(levels.iter().enumerate().map(lowest).collect())
    }
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
    let count = options.refitted.len();
    if let Some(d) = &options.refitted_deviation
        && (d.len() != count || d.iter().any(|v| v.partial_cmp(&0.0) != Some(Ordering::Greater)))
    {
        return fail(format!(
            "the prior standard deviations {d:?} of {count} refitted parameters must be as many and positive"
        ));
    }
    let present = problem.field.parameters();
    let positive = |i: &&usize| !(options.refitted.contains(i) && present[**i] > 0.0);
    if let Some(bad) = options.logarithmic.iter().find(positive) {
        return fail(format!(
            "parameter {bad} cannot be refitted by its logarithm; it must be among the refitted ones and positive"
        ));
    }
    if let Some(d) = &options.initial_state_deviation
        && (d.len() != states || d.iter().any(|v| !(v.is_finite() && *v >= 0.0)))
    {
        return fail(format!(
            "the prior standard deviations {d:?} of the initial state must be {states} finite values of at \
             least 0"
        ));
    }
    let delay = options.delay_deviation_s;
    if !(delay.is_finite() && delay >= 0.0) {
        return fail(format!(
            "the prior standard deviation {delay} s of the delay must be finite and at least 0"
        ));
    }
    let (baseline, all) = (options.baseline, problem.experiments.len());
    if baseline >= all {
        return fail(format!("of {all} experiments, {baseline} for the baseline leave none"));
    }
    options.settings.check()
}

#[cfg(feature = "report")]
impl ReportModel for DiagnosedField {
    fn notes(&self) -> Markup {
        html! {
            @if let Some(b) = &self.baseline {
                p {
                    "Baseline discrepancy of the field, from " (b.recordings.join(", ")) ": RMS "
                    (b.rms.iter().map(|r| pam_core::units::significant(*r, 3)).collect::<Vec<_>>().join(", "))
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
