//! Evaluation of a model on a data set.

mod result;

pub use result::{Evaluation, FailedRecording, RecordingEvaluation, SegmentScores};

use crate::balance::ForceBalance;
use crate::segments::{Segment, frequency_segments};
use pam_core::parallel;
use pam_core::units::MN_PER_N;
use pam_core::{AnyForce, ForceModel, JointModel};
use pam_data::{Recording, Subject};
use pam_trajectory::metrics::{PerChannel, Scores};
use pam_trajectory::predict::{Predictor, SolverSettings};

/// Predicts every recording from its first sample and scores the predictions, in parallel on the
/// current thread pool. Results stand in the order of the subjects and do not depend on the number
/// of threads. `done` is called after each recording.
///
/// A prediction that fails is listed with its reason and does not stop the others.
///
/// ```
/// use pam_core::{JointModel, SpringDamper};
/// use pam_data::{Recording, subjects};
/// use pam_train::evaluate;
/// use pam_trajectory::SolverSettings;
///
/// let model = JointModel::datasheet(SpringDamper::published());
/// let time_s = (0..1000).map(|k| 1e-3 * f64::from(k)).collect();
/// let rest = Recording::at_rest("rest", time_s, [412.0, 412.0]); // kPa absolute
/// let scores = evaluate(&model, subjects([rest], &model)?, &SolverSettings::default(), &|| {});
/// assert!(scores.failed.is_empty());
/// assert!(scores.recordings[0].scores.rmse.x < 1e-9); // the joint stays at rest
/// # Ok::<(), pam_data::DataError>(())
/// ```
pub fn evaluate<F: ForceModel<f64> + Sync>(
    model: &JointModel<f64, F>,
    subjects: Vec<Subject>,
    settings: &SolverSettings,
    done: &(dyn Fn() + Sync),
) -> Evaluation {
    evaluate_with(model, model, subjects, settings, done)
}

/// [`evaluate`] with predictions of any [`Predictor`]; the balance of forces is that of `joint`.
pub fn evaluate_with<F: ForceModel<f64> + Sync>(
    predictor: &dyn Predictor,
    joint: &JointModel<f64, F>,
    subjects: Vec<Subject>,
    settings: &SolverSettings,
    done: &(dyn Fn() + Sync),
) -> Evaluation {
    evaluate_keeping(predictor, joint, subjects, settings, &|r| r, done)
}

/// [`evaluate_with`] with a function that processes each result as soon as it is available and returns what to store: the result
/// itself, or [every n-th sample](RecordingEvaluation::every) of it.
pub fn evaluate_keeping<F: ForceModel<f64> + Sync>(
    predictor: &dyn Predictor,
    joint: &JointModel<f64, F>,
    subjects: Vec<Subject>,
    settings: &SolverSettings,
    keep: &(dyn Fn(RecordingEvaluation) -> RecordingEvaluation + Sync),
    done: &(dyn Fn() + Sync),
) -> Evaluation {
    let results: Vec<_> = parallel::map_each(subjects, |subject| {
        let result = evaluate_one(predictor, joint, subject, settings).map(keep);
        done();
        result
    });
    let mut recordings = Vec::new();
    let mut failed = Vec::new();
    for result in results {
        match result {
            Ok(r) => recordings.push(r),
            Err(f) => failed.push(f),
        }
    }
    let mean = Scores::mean(recordings.iter().map(|r| &r.scores));
    Evaluation { recordings, failed, mean }
}

/// [`evaluate_keeping`] for a joint with a force of any kind. It is compiled here: a generic function is compiled in the crate
/// that calls it, and commands are compiled without optimisation.
#[inline(never)]
pub fn evaluate_joint(
    predictor: &dyn Predictor,
    joint: &JointModel<f64, AnyForce<f64>>,
    subjects: Vec<Subject>,
    settings: &SolverSettings,
    keep: &(dyn Fn(RecordingEvaluation) -> RecordingEvaluation + Sync),
    done: &(dyn Fn() + Sync),
) -> Evaluation {
    evaluate_keeping(predictor, joint, subjects, settings, keep, done)
}

fn evaluate_one<F: ForceModel<f64>>(
    predictor: &dyn Predictor,
    joint: &JointModel<f64, F>,
    subject: Subject,
    settings: &SolverSettings,
) -> Result<RecordingEvaluation, FailedRecording> {
    let Subject { recording, masses, origin } = subject;
    let prediction =
        predictor.predict(&recording, masses, settings).map_err(|e| FailedRecording {
            name: recording.name.clone(),
            why: e.why,
            reached_s: e.partial.len().checked_sub(1).map(|i| recording.time_s[i]),
        })?;
    let segments = frequency_segments(&recording.time_s, &recording.force_mn)
        .into_iter()
        .map(|segment| score_segment(&recording, &prediction.channels, segment))
        .collect();
    Ok(RecordingEvaluation {
        samples: recording.len(),
        scores: Scores::over(&recording, &prediction.channels, 0..recording.len()),
        segments,
        balance: ForceBalance::of(joint, &recording, masses),
        masses,
        origin,
        prediction,
        recording,
    })
}

fn score_segment(
    recording: &Recording,
    predicted: &PerChannel<Vec<f64>>,
    segment: Segment,
) -> SegmentScores {
    let range = segment.range.clone();
    let cycles = segment.frequency_hz.map(|f| {
        let span = recording.time_s[range.end - 1] - recording.time_s[range.start];
        (span * f).max(f64::MIN_POSITIVE)
    });
    // N · mm = mJ.
    let work = |x: &[f64]| {
        let pairs = x[range.clone()].windows(2).zip(recording.force_mn[range.clone()].windows(2));
        let total: f64 = pairs.map(|(x, f)| 0.5 * (f[0] + f[1]) * (x[1] - x[0])).sum();
        cycles.map(|c| total / MN_PER_N / c)
    };
    SegmentScores {
        from_s: recording.time_s[range.start],
        to_s: recording.time_s[range.end - 1],
        scores: Scores::over(recording, predicted, range.clone()),
        loop_work_measured_mj: work(&recording.displacement_mm),
        loop_work_predicted_mj: work(&predicted.x),
        segment,
    }
}
