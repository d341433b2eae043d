//! How a fitted model is scored: predictions from both starts, force and stiffness.

use super::result::{BothSets, Drawn, Mechanics, ModelResult, RecordingScore, SetScores};
use super::split::Split;
use crate::method::{FittedModel, Needs, Run, Stopped, Trajectory};
use crate::points::motion_points;
use pam_control::equilibrium_point::observe;
use pam_core::SealedMasses;
use pam_core::parallel;
use pam_data::{Channel, Recording, Subject};
use pam_numerics::statistics::mean;
use pam_train::frequency_segments;
use pam_trajectory::metrics::{r2, rmse};

/// Points of the equation of motion, s apart.
const FORCE_SPACING_S: f64 = 0.05;
/// Most points of a drawn trajectory.
const DRAWN_POINTS: usize = 7000;

/// Training recordings, then held-out ones.
pub(super) fn all(sets: &Split) -> Vec<&Subject> {
    sets.train.iter().chain(&sets.held_out).collect()
}

/// Data and settings with which all models are scored.
pub(super) struct Scoring<'a> {
    sets: &'a Split,
    warm_up: usize,
    drawn: &'a [String],
    /// Of each recording of [`all`].
    measured_stiffness: Vec<Option<f64>>,
}

impl<'a> Scoring<'a> {
    /// Scores on these recordings, after `warm_up` samples; trajectories of those called `drawn` are kept.
    pub(super) fn new(sets: &'a Split, warm_up: usize, drawn: &'a [String]) -> Self {
        let measured_stiffness =
            parallel::map_each(all(sets), |s| observe(&s.recording).ok().map(|o| o.stiffness_n_mm));
        Self { sets, warm_up, drawn, measured_stiffness }
    }

    /// Predicts all recordings from both starts.
    pub(super) fn score(
        &self,
        name: &str,
        kind: &str,
        model: &dyn FittedModel,
        progress: &(dyn Fn(f64) + Sync),
    ) -> (ModelResult, Vec<Drawn>) {
        let total = 2 * all(self.sets).len();
        let done = std::sync::atomic::AtomicUsize::new(0);
        let count = |n: usize| {
            let before = done.fetch_add(n, std::sync::atomic::Ordering::Relaxed);
            progress((before + n) as f64 / total as f64);
        };
        let mut drawn = Vec::new();
        let mut both = |start: usize, keep: bool| {
            let mut set = |subjects: &[Subject]| {
                // A few recordings at a time: trajectories of all would fill the memory.
                let mut scores = Vec::new();
                for part in subjects.chunks(32) {
                    let runs: Vec<Run<'_>> = part
                        .iter()
                        .map(|s| Run { recording: &s.recording, masses: s.masses, start })
                        .collect();
                    let predicted = model.simulate_all(&runs, &count);
                    if keep {
                        for (run, p) in runs.iter().zip(&predicted) {
                            if self.drawn.contains(&run.recording.name) {
                                let x = p.as_ref().map_or(&[][..], |p| &p.x[..]);
                                drawn.push(draw(run.recording, x));
                            }
                        }
                    }
                    let warm_up = self.warm_up;
                    let both = runs.iter().zip(predicted).collect();
                    scores.extend(parallel::map_each(both, |(run, p)| score(run, p, warm_up)));
                }
                SetScores::of(scores)
            };
            BothSets { train: set(&self.sets.train), held_out: set(&self.sets.held_out) }
        };
        let cold = both(0, true);
        let warm = both(self.warm_up, false);
        let mechanics = self.mechanics(model, &cold);
        let result = ModelResult {
            name: name.to_owned(),
            kind: kind.to_owned(),
            structure: model.structure(),
            needs: model.needs(),
            parameters: model.parameter_count(),
            cold,
            warm,
            mechanics,
            details: model.details(),
        };
        (result, drawn)
    }

    fn mechanics(&self, model: &dyn FittedModel, cold: &BothSets) -> Mechanics {
        let held = !self.sets.held_out.is_empty();
        let (subjects, scores) = if held {
            (&self.sets.held_out, &cold.held_out.recordings)
        } else {
            (&self.sets.train, &cold.train.recordings)
        };
        let skip = if held { self.sets.train.len() } else { 0 };
        let measured = &self.measured_stiffness[skip..][..subjects.len()];
        let error = |values: &[Option<f64>]| {
            let errors: Vec<f64> = values
                .iter()
                .zip(measured)
                .filter_map(|(k, m)| Some(100.0 * ((*k)? - (*m)?).abs() / (*m)?))
                .collect();
            (!errors.is_empty()).then(|| mean(&errors))
        };
        let direct: Vec<Option<f64>> = subjects
            .iter()
            .map(|s| {
                let rest = s.recording.reading_at_rest();
                let masses = model.masses(&s.recording).unwrap_or(s.masses);
                let at = input(rest.displacement_mm, 0.0, masses);
                let pressures = [rest.pressure_flexor_kpa, rest.pressure_extensor_kpa];
                model.stiffness_n_mm(&at, pressures).filter(|k| k.is_finite())
            })
            .collect();
        let shown: Vec<Option<f64>> = scores.iter().map(|s| s.shown_stiffness_n_mm).collect();
        let known = || direct.iter().flatten().copied();
        let range = known()
            .next()
            .map(|first| known().fold([first, first], |[low, high], k| [low.min(k), high.max(k)]));
        Mechanics {
            force_r2: force_r2(model, subjects),
            stiffness_error_percent: error(&direct),
            shown_stiffness_error_percent: error(&shown),
            stiffness_range_n_mm: range,
            single_muscle_r2: model.details().get("single_muscle_r2").and_then(|v| v.as_f64()),
        }
    }
}

fn input(x: f64, v: f64, masses: SealedMasses) -> pam_core::ForceInput<f64> {
    pam_core::ForceInput {
        displacement_mm: x,
        velocity_mm_s: v,
        mass_flexor_g: masses.flexor_g,
        mass_extensor_g: masses.extensor_g,
    }
}

/// R² of the restoring force against `F − m ẍ` along all measured motions.
fn force_r2(model: &dyn FittedModel, subjects: &[Subject]) -> Option<f64> {
    let mass = model.mass_kg()?;
    let parts: Vec<Option<Vec<[f64; 2]>>> =
        parallel::map_each(subjects.iter().collect(), |s: &Subject| {
            // Masses by the sealed reading, as the model itself would take them; pressures of a model
            // that needs them are those of the moment.
            let rest = s.recording.reading_at_rest();
            let sealed = [rest.pressure_flexor_kpa, rest.pressure_extensor_kpa];
            let masses = model.masses(&s.recording).unwrap_or(s.masses);
            motion_points(&s.recording, FORCE_SPACING_S)
                .iter()
                .map(|p| {
                    let at = p.input(masses);
                    let pressures = match model.needs() {
                        Needs::Pressures => p.pressures_kpa,
                        Needs::State => sealed,
                    };
                    let force = model.restoring_force_mn(&at, pressures)?;
                    Some([p.force_mn - mass * p.acceleration_mm_s2, force])
                })
                .collect()
        });
    let parts: Option<Vec<Vec<[f64; 2]>>> = parts.into_iter().collect();
    let (measured, own): (Vec<f64>, Vec<f64>) =
        parts?.into_iter().flatten().map(|[m, f]| (m, f)).unzip();
    Some(r2(&measured, &own)).filter(|v| v.is_finite())
}

fn score(run: &Run<'_>, predicted: Result<Trajectory, Stopped>, warm_up: usize) -> RecordingScore {
    let r = run.recording;
    let rest = r.reading_at_rest();
    let mut score = RecordingScore {
        name: r.name.clone(),
        pressures_kpa: [rest.pressure_flexor_kpa, rest.pressure_extensor_kpa],
        r2: [None; 4],
        rmse_mm: None,
        by_frequency: Vec::new(),
        shown_stiffness_n_mm: None,
        stopped: None,
    };
    let segments = frequency_segments(&r.time_s, &r.force_mn);
    let segments = segments.iter().filter_map(|s| Some((nominal_hz(s.frequency_hz?), s)));
    let predicted = match predicted {
        Ok(p) => p,
        Err(stopped) => {
            score.by_frequency = segments.map(|(f, _)| (f, None)).collect();
            score.stopped = Some(stopped.why);
            return score;
        }
    };
    let finite = |v: f64| Some(v).filter(|v| v.is_finite());
    // Both kinds of start are scored on the same samples.
    let own = |c: Channel| predicted.channel(c).get(warm_up - run.start..).unwrap_or_default();
    for (c, to) in Channel::ALL.into_iter().zip(&mut score.r2) {
        if !own(c).is_empty() {
            *to = finite(r2(&r.channel(c)[warm_up..], own(c)));
        }
    }
    score.rmse_mm = finite(rmse(&r.displacement_mm[warm_up..], own(Channel::X)));
    for (f, s) in segments {
        let range = s.range.start.max(warm_up)..s.range.end;
        let predicted = &own(Channel::X)[range.start - warm_up..range.end - warm_up];
        score.by_frequency.push((f, finite(r2(&r.displacement_mm[range], predicted))));
    }
    let shown = Recording {
        displacement_mm: own(Channel::X).to_vec(),
        velocity_mm_s: own(Channel::V).to_vec(),
        time_s: r.time_s[warm_up..].to_vec(),
        force_mn: r.force_mn[warm_up..].to_vec(),
        sealed: Some(rest),
        ..r.without_samples()
    };
    score.shown_stiffness_n_mm = observe(&shown).ok().map(|o| o.stiffness_n_mm);
    score
}

/// A frequency rounded to a tenth of a hertz, so that recordings fall into the same groups.
fn nominal_hz(f: f64) -> f64 {
    (10.0 * f).round() / 10.0
}

/// Thins a trajectory out for drawing.
pub(super) fn draw(recording: &Recording, displacement_mm: &[f64]) -> Drawn {
    let stride = recording.len().div_ceil(DRAWN_POINTS).max(1);
    Drawn {
        recording: recording.name.clone(),
        time_s: recording.time_s.iter().step_by(stride).copied().collect(),
        displacement_mm: displacement_mm.iter().step_by(stride).copied().collect(),
    }
}
