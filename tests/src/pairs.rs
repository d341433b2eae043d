//! Pairs of effects that the published excitation does not distinguish and a designed protocol does, shown on the virtual rig.

use crate::csv_text;
use crate::experiment::EFFECTS;
use pam_core::{AnyForce, ForceModel};
use pam_data::{LoadOptions, RawLogOptions, Recording, Subject, open_recordings, parse_model};
use pam_diagnose::{DiagnoseOptions, RecordingSets, diagnose};
use pam_effects::ExtendedModel;
use pam_effects::effects::by_id;
use pam_experiment::certify::with_baseline;
use pam_experiment::design::{
    Design, DesignLimits, DesignOptions, LiveCause, Objective, design, standard,
};
use pam_experiment::detect::{DetectOptions, Detection, GivenValues, Limits, detect};
use pam_rig::{Protocol, RigParameters, Session};
use pam_train::curriculum::{Curriculum, Stage};
use pam_train::training::Training;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Multiples of the detection limit at which effects are hidden, in the order in which they are tried.
pub const MULTIPLES: [f64; 6] = [4.0, 3.0, 2.5, 2.0, 5.0, 6.0];
/// Designs that are tried for a pair at a magnitude, each with a seed of its own, and the protocols that each of them simulates.
const DESIGNS: u64 = 4;
const EVALUATIONS: usize = 200;
/// Margin of a design beyond which no other one is tried.
const MARGIN: f64 = 1.5;
/// Recordings at each pair of pressures of a protocol on which the model is trained further.
const TRAINED_ON: u64 = 2;
/// Epochs of this training, and its rate: three times that of the last stage from random weights, as it is short.
const EPOCHS: usize = 60;
const RATE: f64 = 3e-4;
/// Seed of the rig and of the designs.
const SEED: u64 = 8_100;

/// The shipped model of the virtual rig.
///
/// # Panics
/// If it cannot be read.
#[must_use]
pub fn model() -> ExtendedModel {
    let bytes = include_bytes!("../../pam-cli/models/default.safetensors");
    let saved = parse_model(Path::new("default"), bytes).expect("the shipped model");
    ExtendedModel::from_saved(saved).expect("known effects")
}

/// Limits of the designs: 20 s at three pairs of pressures where the model is accurate, with motions as large and as fast as those of the
/// published excitation, on which it was trained, not slower, and without rest.
#[must_use]
pub fn limits() -> DesignLimits {
    DesignLimits {
        seconds: 20.0,
        psi: [30, 65],
        travel_mm: 4.0,
        speed_mm_s: 35.0,
        hz: [0.5, 5.0],
        hold_s: 1.0,
        ..DesignLimits::default()
    }
}

/// Foretold limits and confusions under the published excitation, with the noise and the errors of the model that baseline recordings
/// of the rig show, and a diagnosis that knows these.
///
/// # Panics
/// If the rig cannot be recorded.
#[must_use]
pub fn foretold(model: &ExtendedModel) -> (Detection, DiagnoseOptions) {
    foretold_under(model, &standard(&limits()), &EFFECTS, SEED)
}

/// The limits of effects under a protocol, foretold from baseline recordings of the rig, and a diagnosis with this baseline.
fn foretold_under(
    model: &ExtendedModel,
    protocol: &Protocol,
    effects: &[&str],
    seed: u64,
) -> (Detection, DiagnoseOptions) {
    let baseline = recorded(model, RigParameters::default(), protocol, seed);
    let plain = DiagnoseOptions { law: false, ..DiagnoseOptions::default() };
    let diagnosis = with_baseline(model, &baseline, &plain).expect("a baseline");
    let options = detect_options(effects, &diagnosis);
    let detection = detect(model, &baseline, None, &options, &|_, _| {});
    (detection.expect("limits"), diagnosis)
}

fn detect_options(effects: &[&str], diagnosis: &DiagnoseOptions) -> DetectOptions {
    let given = |e: &&str| e.parse::<GivenValues>().expect("an effect with values");
    DetectOptions {
        effects: effects.iter().map(given).collect(),
        diagnosis: diagnosis.clone(),
        trials: Some(0),
        ..DetectOptions::default()
    }
}

/// The values of an effect at a multiple of its limit; `None` without a limit, and for friction with two magnitudes (Stribeck), of which
/// Coulomb friction is a part.
fn values(limits: &Limits, multiple: f64) -> Option<Vec<f64>> {
    let effect = by_id(&limits.effect)?;
    let info = effect.info();
    if info.parameters.iter().any(|p| p.not_below.is_some()) {
        return None;
    }
    let k = info.parameters.iter().position(|p| p.name == limits.parameter)?;
    let p = &info.parameters[k];
    let limit = limits.named?.value;
    let value = match p.off.filter(|_| !p.logarithmic) {
        Some(off) => off + multiple * (limit - off),
        None => limit / multiple,
    };
    let value = value.clamp(p.range[0], p.range[1]);
    let of = |name: &str| limits.kept.iter().find(|kept| kept.0 == name).map(|kept| kept.1);
    let parameters = info.parameters.iter().enumerate();
    let switches = info.switches.iter().map(|switch| of(switch.name).unwrap_or(0.0));
    Some(
        parameters
            .map(|(j, p)| if j == k { value } else { of(p.name).or(p.off).unwrap_or(value) })
            .chain(switches)
            .collect(),
    )
}

/// Verdict and named causes of a diagnosis of the rig, or why it was refused.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Said {
    /// The verdict.
    pub verdict: String,
    /// Named causes with those that are not distinguished from them.
    pub named: Vec<(String, Vec<String>)>,
}

impl Said {
    /// Whether only `effect` is named, and `other` is not confusable with it.
    #[must_use]
    pub fn separates(&self, effect: &str, other: &str) -> bool {
        matches!(&self.named[..], [(id, confusable)] if id == effect && confusable.iter().all(|c| c != other))
    }

    /// The verdict and the named causes, each with its alternatives, on one line.
    #[must_use]
    pub fn text(&self) -> String {
        let of = |(id, confusable): &(String, Vec<String>)| match &confusable[..] {
            [] => id.clone(),
            others => format!("{id} (or {})", others.join(" or ")),
        };
        let named: Vec<String> = self.named.iter().map(of).collect();
        format!("{}: {}", self.verdict, named.join(" + "))
    }

    /// Whether `other` is named, or `effect` is named and confusable with it.
    #[must_use]
    pub fn confuses(&self, effect: &str, other: &str) -> bool {
        self.named.iter().any(|(id, confusable)| {
            id == other || (id == effect && confusable.iter().any(|c| c == other))
        })
    }
}

/// The diagnosis of an effect hidden in recordings of the published excitation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Published {
    /// Label of the effect that is hidden: its id, with the chamber where each has limits of its own.
    pub effect: String,
    /// Multiple of its limit of detection.
    pub multiple: f64,
    /// Its values.
    pub values: Vec<(String, f64)>,
    /// Verdict and named causes.
    pub said: Said,
}

impl Published {
    /// Ids of the causes that are said not to be distinguished from the hidden effect `id`.
    #[must_use]
    pub fn taken_for(&self, id: &str) -> Vec<&str> {
        let causes = self.said.named.iter().flat_map(|(own, others)| {
            std::iter::once(own.as_str()).chain(others.iter().map(String::as_str))
        });
        let mut all: Vec<&str> = causes.filter(|c| *c != id && self.said.confuses(id, c)).collect();
        all.dedup();
        all
    }
}

/// A pair under both protocols.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PairOutcome {
    /// Label of the effect that is hidden.
    pub effect: String,
    /// Its id.
    pub id: String,
    /// Multiple of its limit of detection under the published excitation.
    pub multiple: f64,
    /// Its values.
    pub values: Vec<(String, f64)>,
    /// Id of the one that may be taken for it.
    pub other: String,
    /// Designs that were made.
    pub designs: u64,
    /// Distance over the one that is needed, under the published excitation and under the design, as foretold before anything is measured
    /// under it.
    pub foretold: [f64; 2],
    /// The magnitude over the one from which the effect is named and distinguished under the design, as foretold from baseline recordings
    /// of it: from the noise and the errors of the model there.
    pub margin: f64,
    /// The protocol of the design.
    pub protocol: Protocol,
    /// What diagnoses of the rig say with recordings of the published excitation, and with those of the design, which are as long; absent
    /// where no design is foretold to separate the pair.
    pub said: Option<[Said; 2]>,
}

impl PairOutcome {
    /// Whether the diagnosis confuses the two effects under the published excitation but distinguishes them under the design.
    #[must_use]
    pub fn is_shown(&self) -> bool {
        self.said.as_ref().is_some_and(|[standard, designed]| {
            standard.confuses(&self.id, &self.other) && designed.separates(&self.id, &self.other)
        })
    }

    /// Whether it is about these two effects, either of them hidden.
    #[must_use]
    pub fn is_about(&self, one: &str, other: &str) -> bool {
        (self.id == one && self.other == other) || (self.id == other && self.other == one)
    }
}

/// The pairs that were shown, as CSV.
///
/// # Errors
/// A sentence if the table cannot be written.
pub fn shown_table(all: &[PairOutcome]) -> Result<String, String> {
    let columns = [
        "hidden",
        "taken_for",
        "limits",
        "designs",
        "distance_published",
        "distance_designed",
        "margin",
        "said_published",
        "said_designed",
    ];
    let rows = all.iter().filter(|o| o.is_shown()).map(|o| {
        let own =
            [o.effect.clone(), o.other.clone(), o.multiple.to_string(), o.designs.to_string()];
        let foretold = o.foretold.iter().chain([&o.margin]).map(|d| format!("{d:.2}"));
        let said = o.said.iter().flatten().map(Said::text);
        own.into_iter().chain(foretold).chain(said).collect::<Vec<String>>()
    });
    csv_text(&columns, rows)
}

/// Hides an effect at a multiple of its detection limit in the rig, records the published excitation and diagnoses the recordings; `None`
/// if the effect has no limit.
///
/// # Panics
/// If the rig fails.
#[must_use]
pub fn published(model: &ExtendedModel, own: &Limits, multiple: f64) -> Option<Published> {
    let info = by_id(&own.effect)?.info();
    // The rig has no switches: its chambers push on the joint as they are.
    let names = info.parameters.iter().map(|p| p.name.to_owned());
    let values: Vec<(String, f64)> = names.zip(values(own, multiple)?).collect();
    let said = diagnosed(model, &standard(&limits()), &hidden(&own.effect, &values));
    Some(Published { effect: own.label.clone(), multiple, values, said })
}

/// Designs protocols for an effect and one that is taken for it under the published excitation, and measures the one of which baseline
/// recordings on the rig promise most. `None` if an effect has no limit.
///
/// # Panics
/// If the rig or a training fails.
#[must_use]
pub fn measured(
    model: &ExtendedModel,
    (detection, diagnosis): &(Detection, DiagnoseOptions),
    case: &Published,
    other: &str,
) -> Option<PairOutcome> {
    let own = detection.of(&case.effect)?;
    let rival = detection.limits.iter().find(|l| l.effect == other)?;
    let (own_values, other_values) = (values(own, case.multiple)?, values(rival, case.multiple)?);
    let detect = detect_options(&[], diagnosis);
    let place = |id: &str| detect.diagnosis.candidates.iter().position(|e| e.info().id == id);
    let live = LiveCause {
        cause: (place(&own.effect)?, own_values),
        others: vec![(place(other)?, other_values)],
    };
    let mut options = DesignOptions {
        detect,
        limits: limits(),
        objective: Objective::Separation(vec![live]),
        evaluations: EVALUATIONS,
        ..DesignOptions::default()
    };
    let mut best: Option<(PairOutcome, ExtendedModel)> = None;
    for k in 0..DESIGNS {
        options.seed = SEED + k;
        let designed: Design = design(model, &options, &|_| {}).expect("a design");
        let separated = designed.separations.first()?;
        let (margin, trained) = if separated.designed < 1.0 {
            (0.0, model.clone())
        } else {
            let trained = trained_further(model, [&designed.standard, &designed.protocol]);
            (margin(&trained, own, other, case.multiple, &designed.protocol), trained)
        };
        if best.as_ref().is_none_or(|(so_far, _)| margin > so_far.margin) {
            let outcome = PairOutcome {
                effect: case.effect.clone(),
                id: own.effect.clone(),
                other: other.to_owned(),
                multiple: case.multiple,
                values: case.values.clone(),
                designs: 0,
                foretold: [separated.standard, separated.designed],
                margin,
                protocol: designed.protocol,
                said: None,
            };
            best = Some((outcome, trained));
        }
        let (so_far, _) = best.as_mut()?;
        so_far.designs = k + 1;
        if so_far.margin >= MARGIN {
            break;
        }
    }
    let (mut outcome, trained) = best?;
    if outcome.foretold[1] >= 1.0 {
        let hidden = hidden(&own.effect, &case.values);
        let protocols = [standard(&limits()), outcome.protocol.clone()];
        outcome.said = Some(protocols.map(|protocol| diagnosed(&trained, &protocol, &hidden)));
    }
    Some(outcome)
}

/// An effect at a multiple of its limit under the published excitation over the magnitude from which it is named and distinguished from
/// another one under a design, as foretold from baseline recordings of the rig; 0 if it never is.
fn margin(
    model: &ExtendedModel,
    own: &Limits,
    other: &str,
    multiple: f64,
    protocol: &Protocol,
) -> f64 {
    let kept: Vec<String> = own.kept.iter().map(|(name, v)| format!("{name}={v}")).collect();
    let given = format!("{}:{}", own.effect, kept.join(";"));
    let (foretold, _) = foretold_under(model, protocol, &[&given, other], SEED + 1);
    let limit = foretold.of(&own.label).and_then(|l| l.named);
    let pair = foretold.pairs.iter().find(|p| p.effect == own.label && p.other == other);
    let from = pair.and_then(|p| p.distinguished_from).zip(limit);
    let magnitude = own.named.map(|l| multiple * l.magnitude);
    magnitude.zip(from).map_or(0.0, |(own, (times, limit))| own / (times * limit.magnitude))
}

/// The model trained further on recordings of the rig with nothing hidden under both protocols, as a laboratory would that has a new
/// protocol: it was trained on the published excitation alone.
///
/// # Panics
/// If the training fails.
#[must_use]
pub fn trained_further(model: &ExtendedModel, protocols: [&Protocol; 2]) -> ExtendedModel {
    let mut recordings = Vec::new();
    for (protocol, prefix) in protocols.into_iter().zip(["standard", "designed"]) {
        for seed in 0..TRAINED_ON {
            let of_rig = recorded(model, RigParameters::default(), protocol, SEED + 10 + seed);
            recordings.extend(of_rig.into_iter().enumerate().map(|(k, subject)| {
                let name = format!("{prefix}-{seed}-{k}");
                Recording { name, ..subject.recording }
            }));
        }
    }
    let network = model.joint.force.network().expect("a network");
    let joint = model.joint.map(|s| s, |_| network.clone());
    let mut curriculum = Curriculum::open("recommended", &[]).expect("a built-in curriculum");
    curriculum.stages.retain(|stage| matches!(stage, Stage::Solve(_)));
    let trained = Training::new(recordings)
        .with_curriculum(curriculum)
        .with_model(joint)
        .with_rate(RATE)
        .with_epochs(EPOCHS)
        .with_seed(SEED)
        .run()
        .expect("a training");
    let joint = trained.model.map(|s| s, |force| AnyForce::Network(force.clone()));
    ExtendedModel { joint, ..model.clone() }
}

fn hidden(id: &str, values: &[(String, f64)]) -> String {
    let values: Vec<String> = values.iter().map(|(name, v)| format!("{name}={v}")).collect();
    format!("{id}:{}", values.join(","))
}

/// The diagnosis of recordings of the rig with a hidden effect under a protocol, beside a baseline of the same protocol.
fn diagnosed(model: &ExtendedModel, protocol: &Protocol, hidden: &str) -> Said {
    let rig = RigParameters::default();
    let baseline = recorded(model, rig.clone(), protocol, SEED + 1);
    let mut faulty = rig;
    faulty.effects.push(hidden.parse().expect("an effect of the rig"));
    let data = recorded(model, faulty, protocol, SEED + 2);
    let options = DiagnoseOptions { law: false, ..DiagnoseOptions::default() };
    let sets = RecordingSets { data: &data, baseline: Some(&baseline), ..RecordingSets::default() };
    match diagnose(model, &sets, &options, &|_, _| {}) {
        Ok(found) => {
            let named = found.causes.iter().map(|c| (c.effect.clone(), c.confusable_with.clone()));
            Said { verdict: found.verdict.to_string(), named: named.collect() }
        }
        // A large effect may contradict the physics of the joint.
        Err(refusal) => Said { verdict: format!("refused: {refusal}"), named: Vec::new() },
    }
}

/// Recordings of a protocol on a rig, through its raw logs. The excitation is looked for after two seconds, as at 1 kHz by default, and
/// logs that are too slow for the low-pass of 20 Hz are not filtered.
///
/// # Panics
/// If the rig fails.
#[must_use]
pub fn recorded(
    model: &ExtendedModel,
    rig: RigParameters,
    protocol: &Protocol,
    seed: u64,
) -> Vec<Subject> {
    let rate_hz = rig.sensors.clock.rate_hz;
    let published = RawLogOptions::default();
    let filtered = 0.5 * rate_hz > published.cutoff_hz;
    let options = LoadOptions {
        raw_log: RawLogOptions {
            search_from_row: (2.0 * rate_hz) as usize,
            cutoff_hz: if filtered { published.cutoff_hz } else { 0.0 },
            ..published
        },
        ..LoadOptions::default()
    };
    let session =
        Session { rig, protocol: protocol.clone(), seed, truth: false, note: String::new() };
    let folder = tempfile::tempdir().expect("a folder");
    let entries = session.record_into(folder.path(), true, &|_| {}).expect("the rig records");
    let read = |log: &Path| {
        let runs = open_recordings(log, &options).expect("a log");
        Subject::of(runs.into_iter().next().expect("a run"), &model.joint).expect("masses")
    };
    entries.iter().map(|e| read(&e.log)).collect()
}
