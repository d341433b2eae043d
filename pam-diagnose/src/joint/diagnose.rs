//! The diagnosis of a joint, from recordings on.

use super::baseline::BaselineDiscrepancy;
use super::design::{Separation, separate};
use super::divergence::{CutRecording, before_divergence, cut_recordings};
use super::force_noise::{doubtful_force_n, quiet_forces, with_doubtful_force};
use super::ladder::{EffectLadder, joint_ladder};
use super::law;
use super::spans::roles;
use super::system::JointSystem;
use crate::data::{OpenPart, Roles};
use crate::diagnosis::{self, Diagnosis, Prepared, Stage};
use crate::error::DiagnoseError;
use crate::settings::DiagnosisSettings;
use crate::verdict::Verdict;
use pam_data::Subject;
use pam_data::plausibility::{self, Finding, PlausibilitySettings};
use pam_effects::effects::{self, AnyEffect, DataScales};
use pam_effects::model::{ActiveEffect, ExtendedModel};
use pam_effects::simulation::{ResampledRecord, Trial, needed_substeps};
use serde::Serialize;

/// The recordings of a diagnosis.
#[derive(Debug, Clone, Copy, Default)]
pub struct RecordingSets<'a> {
    /// Recordings in which something may be wrong: training and validation data.
    pub data: &'a [Subject],
    /// The test set; taken from the data if absent.
    pub test: Option<&'a [Subject]>,
    /// Recordings on which the model was validated: their error is its baseline discrepancy.
    pub baseline: Option<&'a [Subject]>,
}

/// Candidates, seed and settings of [`diagnose`].
#[derive(Debug, Clone)]
pub struct DiagnoseOptions {
    /// Effects that may be named; all that this process knows unless changed.
    pub candidates: Vec<&'static dyn AnyEffect>,
    /// Seed of the null tests and the bootstrap; `data.split_seed` draws the split.
    pub seed: u64,
    /// Every other number on which the diagnosis depends.
    pub settings: DiagnosisSettings,
    /// Thresholds of the check of units, signs and columns that comes before the diagnosis.
    pub plausibility: PlausibilitySettings,
    /// Diagnose recordings that contradict the physics of the joint all the same.
    pub allow_implausible: bool,
    /// Known standard deviations of the noise of x (mm), P_f and P_e (kPa), in means over
    /// [`points_per_row`](crate::settings::DataSettings::points_per_row) grid points; learned from the data where absent.
    pub noise: [Option<f64>; 3],
    /// A ladder to climb on the same data, beside the model as it is given.
    pub ladder: Option<EffectLadder>,
    /// Whether to [fit the error that remains](super::learn_remainder) after the named causes, unless the model is inadequate.
    /// Without such an error it takes no time.
    pub law: bool,
    /// What [`BaselineDiscrepancy::learn`] has learned from the baseline recordings, so that several diagnoses with one model
    /// need not learn it again; learned where absent.
    pub discrepancy: Option<BaselineDiscrepancy>,
}

impl Default for DiagnoseOptions {
    fn default() -> Self {
        Self {
            candidates: effects::all(),
            seed: 1,
            settings: DiagnosisSettings::default(),
            plausibility: PlausibilitySettings::default(),
            allow_implausible: false,
            noise: [None; 3],
            ladder: None,
            law: true,
            discrepancy: None,
        }
    }
}

/// The joint's own part of a diagnosis.
#[derive(Debug, Clone, Serialize)]
pub struct DiagnosedJoint {
    /// The model with the effects of the baseline and the named causes; the given model if none is named.
    #[serde(skip)]
    pub extended: ExtendedModel,
    /// The baseline discrepancy, if baseline recordings were given.
    pub baseline: Option<BaselineDiscrepancy>,
    /// By how many of its samples the force acts earlier than a held one, as fitted with the named causes:
    /// 0 held, ½ smooth.
    pub force_lead_samples: f64,
    /// Root mean square of the part of the measured force that counts as noise, as fitted with the named causes, N: at frequencies
    /// that the excitation does not have. Absent where there is none.
    pub force_noise_n: Option<f64>,
    /// Contradictions between the recordings and the physics of the joint.
    pub plausibility: Vec<Finding>,
    /// Recordings on which the model diverges, of which only the beginning is used.
    pub cut_recordings: Vec<CutRecording>,
    /// Magnitudes of the fitted recordings.
    #[serde(skip)]
    pub scales: DataScales,
    /// The candidates of the options.
    #[serde(skip)]
    pub candidates: Vec<&'static dyn AnyEffect>,
}

/// A diagnosis of a joint.
pub type JointDiagnosis = Diagnosis<DiagnosedJoint>;

/// Diagnoses recordings with a model. The same seed gives the same answer at any number of threads.
///
/// ```no_run
/// use pam_data::{LoadOptions, load_model, read_recordings, subjects};
/// use pam_diagnose::{DiagnoseOptions, RecordingSets, diagnose};
/// use pam_effects::ExtendedModel;
///
/// let model = ExtendedModel::from_saved(load_model("model.safetensors")?)?;
/// let data = subjects(read_recordings(["logs"], &LoadOptions::default())?, &model.joint)?;
/// let sets = RecordingSets { data: &data, ..RecordingSets::default() };
/// let found = diagnose(&model, &sets, &DiagnoseOptions::default(), &|_stage, _share| {})?;
/// for cause in &found.causes {
///     println!("{} {:?}", cause.description, cause.parameters);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`DiagnoseError`] if there is too little data, the model itself diverges on them, or they contradict the physics of
/// the joint ([`DiagnoseError::Implausible`], unless the options allow it). That nothing is found, or nothing is
/// explained, is no error.
pub fn diagnose(
    model: &ExtendedModel,
    sets: &RecordingSets<'_>,
    options: &DiagnoseOptions,
    progress: &(dyn Fn(Stage, f64) + Sync),
) -> Result<JointDiagnosis, DiagnoseError> {
    let settings = &options.settings;
    settings.check()?;
    progress(Stage::Preparing, 0.0);
    let plausibility = plausible(model, sets, options)?;
    let (trials, roles) = prepare(model, sets, options)?;
    let all: Vec<&Trial> = trials.iter().collect();
    let open = roles.open();
    let effects = options.candidates.clone();
    let base = model.base();
    let mut system = JointSystem::new(all, &open, base, &model.effects, effects.clone(), settings);
    let (noise, mut prior) = system.first_noise(&open, options.noise);
    let mut baseline = None;
    let mut known = model.clone();
    let subjects: Vec<&Subject> = sets.baseline.unwrap_or_default().iter().collect();
    let every = OpenPart::whole(subjects.len());
    let baseline_trials = ready_trials(model, &subjects, settings)?;
    let recordings = sets.data.iter().chain(sets.test.unwrap_or_default()).chain(subjects);
    let cut_recordings = cut_recordings(recordings, trials.iter().chain(&baseline_trials));
    if sets.baseline.is_some() {
        let done = |s| progress(Stage::Baseline, s);
        let learned = match &options.discrepancy {
            Some(learned) => learned.clone(),
            None => BaselineDiscrepancy::from_trials(model, &baseline_trials, options, &done)?,
        };
        prior.discrepancy.add(&learned.discrepancy);
        known = model.with(learned.effects.iter().cloned());
        system.learn(&learned);
        baseline = Some(learned);
    }
    let baseline_system = JointSystem::new(
        baseline_trials.iter().collect(),
        &every,
        base,
        &known.effects,
        effects,
        settings,
    );
    let on_baseline = match &baseline {
        Some(b) => Some(b.problem(&baseline_system, settings)?),
        None => None,
    };
    let prepared = Prepared {
        system: &system,
        roles: &roles,
        noise,
        prior,
        baseline_discrepancy: baseline.as_ref().map_or_else(Vec::new, BaselineDiscrepancy::sizes),
        baseline: on_baseline,
        settings,
        seed: options.seed,
    };
    let mut found = diagnosis::run(&prepared, progress, |best| {
        let causes: Vec<ActiveEffect> = best.members.iter().map(|m| system.active(m)).collect();
        let learned = system.learned_in_part(best);
        if let Some(baseline) = &mut baseline {
            baseline.shares = JointSystem::shares(best);
        }
        let extended = learned.into_iter().chain(causes.iter().cloned());
        DiagnosedJoint {
            extended: if causes.is_empty() { model.clone() } else { model.with(extended) },
            baseline,
            force_lead_samples: best.shared[JointSystem::LEAD],
            force_noise_n: doubtful_force_n(&trials)
                .map(|doubtful_n| best.shared[JointSystem::FORCE_NOISE] * doubtful_n)
                .filter(|noise_n| *noise_n > 0.0),
            plausibility,
            cut_recordings,
            scales: system.scales.clone(),
            candidates: options.candidates.clone(),
        }
    })?;
    if let Some(ladder) = &options.ladder {
        let done = |s| progress(Stage::Judging, 0.5 + 0.5 * s);
        found.ladder = Some(joint_ladder(model, sets, ladder, options, &done)?);
    }
    if options.law && found.verdict != Verdict::ModelInadequate {
        let done = |s| progress(Stage::Learning, s);
        done(0.0);
        found = law::from_trials(model, (&trials, &roles), options, found, &done)?;
        done(1.0);
    }
    Ok(found)
}

/// Contradictions between the recordings and the physics of the joint; an error if it is certain and not allowed.
pub(super) fn plausible(
    model: &ExtendedModel,
    sets: &RecordingSets<'_>,
    options: &DiagnoseOptions,
) -> Result<Vec<Finding>, DiagnoseError> {
    let sets = [Some(sets.data), sets.test, sets.baseline];
    let subjects = sets.into_iter().flatten().flatten();
    let findings = plausibility::check_with(&model.joint, subjects, &options.plausibility);
    let errors = plausibility::errors(&findings);
    if errors.is_empty() || options.allow_implausible {
        Ok(findings)
    } else {
        Err(DiagnoseError::Implausible(errors))
    }
}

/// The recordings under diagnosis and of the test set ready for simulation, and their roles.
pub(super) fn prepare(
    model: &ExtendedModel,
    sets: &RecordingSets<'_>,
    options: &DiagnoseOptions,
) -> Result<(Vec<Trial>, Roles), DiagnoseError> {
    let subjects: Vec<&Subject> = sets.data.iter().chain(sets.test.unwrap_or_default()).collect();
    let trials = ready_trials(model, &subjects, &options.settings)?;
    let roles = roles(&trials.iter().collect::<Vec<_>>(), sets, options)?;
    Ok((trials, roles))
}

/// The recordings ready for simulation, as far as the model does not diverge on them, with the part of their force that may be
/// noise.
pub(super) fn ready_trials(
    model: &ExtendedModel,
    subjects: &[&Subject],
    settings: &DiagnosisSettings,
) -> Result<Vec<Trial>, DiagnoseError> {
    let trials = resampled(model, subjects, settings)?;
    let trials = with_doubtful_force(trials, &quiet_forces(subjects, settings));
    trials.into_iter().map(|trial| before_divergence(trial, model, &settings.data)).collect()
}

/// The recordings with their tables of the base model's force, which has to be of mechanics that can be simulated often.
pub(super) fn resampled(
    model: &ExtendedModel,
    subjects: &[&Subject],
    settings: &DiagnosisSettings,
) -> Result<Vec<Trial>, DiagnoseError> {
    let (base, most) = (model.base(), settings.data.most_substeps);
    let trial = |s: &&Subject| {
        ResampledRecord::check(s)?;
        let trial = Trial::new(&model.joint, s);
        let substeps = needed_substeps(&trial, &base);
        if substeps > most {
            let recording = trial.record.source.name.clone();
            return Err(DiagnoseError::TooFast { recording, substeps, most });
        }
        Ok(trial)
    };
    subjects.iter().map(trial).collect()
}

impl JointDiagnosis {
    /// Excitations that would distinguish the first confusable cause from its alternatives, best first; empty if
    /// nothing is confusable.
    #[must_use]
    pub fn design(&self) -> Vec<Separation> {
        let model = &self.model;
        let confusable = self.causes.iter().find(|c| !c.alternatives.is_empty());
        let Some(cause) = confusable else { return Vec::new() };
        let alternatives: Vec<ActiveEffect> = cause
            .alternatives
            .iter()
            .map(|m| ActiveEffect {
                effect: model.candidates[m.candidate],
                values: m.own().to_vec(),
            })
            .collect();
        let place = model.extended.effects.iter().rposition(|a| a.effect.info().id == cause.effect);
        place.map_or_else(Vec::new, |place| {
            separate(&model.extended, place, &alternatives, &model.scales, &self.noise)
        })
    }
}
