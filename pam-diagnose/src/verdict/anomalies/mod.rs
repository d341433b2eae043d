//! Features that noise does not have: steps, changes of size, foreign lines and events in a residual.

mod events;
mod lines;
mod steps;

use crate::fit::{Hypothesis, Problem, fitted_outputs};
use crate::search::{Candidates, OutputInfo};
use serde::Serialize;
use std::cell::OnceCell;

/// Something in the residual of one channel that no noise does.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Anomaly {
    /// `step` of the mean, `drift`, `change` of the size, `event` of one row, `line` of the spectrum, `unmodelled` motion
    /// that goes with nothing, or `start` of recordings that is not as measured.
    pub kind: &'static str,
    /// Key of the channel.
    pub channel: String,
    /// The recording; absent for a line, which is one of all recordings together.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recording: Option<String>,
    /// When, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_s: Option<f64>,
    /// Frequency, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frequency_hz: Option<f64>,
    /// In words.
    pub description: String,
}

/// Anomalies in the residuals of a fitted hypothesis. Experiments whose simulation fails contribute none.
pub(crate) fn anomalies<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    hypothesis: &Hypothesis,
) -> Vec<Anomaly> {
    let residuals = Residuals::of(problem, hypothesis);
    let mut found = Vec::new();
    for (index, (place, output)) in fitted_outputs(problem.system).enumerate() {
        let discrepancy = problem.noise.discrepancy(index);
        let own = problem.settings.verdict.inadequate_ratio * discrepancy;
        let channel = Channel { of: &residuals, index, place, output, own };
        for part in channel.recordings() {
            found.extend(part.step());
            found.extend(part.drift());
            found.extend(part.change());
            found.extend(part.event());
        }
        found.extend(channel.line());
    }
    found
}

/// Residuals of all experiments for a fitted hypothesis.
struct Residuals<'a, C: ?Sized> {
    problem: &'a Problem<'a, C>,
    hypothesis: &'a Hypothesis,
    /// By experiment and channel; none where the simulation fails.
    rows: Vec<Option<Rows>>,
    /// Rows of all experiments.
    count: usize,
    excitations: Vec<Vec<f64>>,
    /// For each experiment, channel and row the error that the unknown timing of the excitation can cause. Needed only where there are
    /// events, and for all channels at once.
    by_timing: Vec<OnceCell<Vec<Vec<f64>>>>,
}

/// Residuals of one experiment by channel.
struct Rows {
    plain: Vec<Vec<f64>>,
    white: Vec<Vec<f64>>,
}

/// One channel of all experiments.
struct Channel<'a, C: ?Sized> {
    of: &'a Residuals<'a, C>,
    /// Its index among the fitted outputs, and its place among all outputs.
    index: usize,
    place: usize,
    output: &'a OutputInfo,
    /// A drift, a step or a line of this root mean square are errors that the model has by itself.
    own: f64,
}

/// One channel of one experiment.
struct Part<'a, C: ?Sized> {
    channel: &'a Channel<'a, C>,
    /// Place of the experiment in the problem.
    experiment: usize,
    rows: &'a Rows,
    row_s: f64,
    /// Time of the first row, s.
    start_s: f64,
}

impl<'a, C: Candidates + ?Sized> Residuals<'a, C> {
    fn of(problem: &'a Problem<'a, C>, hypothesis: &'a Hypothesis) -> Self {
        let rows = |i| {
            let plain = problem.residuals(hypothesis, i).ok()?;
            Some(Rows { plain, white: problem.whitened_residuals(hypothesis, i).ok()? })
        };
        Self {
            problem,
            hypothesis,
            rows: (0..problem.len()).map(rows).collect(),
            count: (0..problem.len()).map(|i| problem.rows(i)).sum(),
            excitations: problem.excitation_rows(),
            by_timing: vec![OnceCell::new(); problem.len()],
        }
    }
}

impl<C: Candidates + ?Sized> Channel<'_, C> {
    /// The experiments that can be simulated.
    fn recordings(&self) -> impl Iterator<Item = Part<'_, C>> {
        let problem = self.of.problem;
        let part = move |(experiment, rows): (usize, _)| {
            let e = problem.experiments[experiment];
            let start_s = problem.system.start_s(e)
                + problem.system.time_s(e, problem.windows[experiment].start);
            let row_s = problem.row_s(experiment);
            Part { channel: self, experiment, rows, row_s, start_s }
        };
        let rows = self.of.rows.iter().enumerate();
        rows.filter_map(|(k, rows)| Some((k, rows.as_ref()?))).map(part)
    }

    fn anomaly(&self, kind: &'static str, description: String) -> Anomaly {
        Anomaly {
            kind,
            channel: self.output.key.clone(),
            recording: None,
            time_s: None,
            frequency_hz: None,
            description,
        }
    }
}

impl<C: Candidates + ?Sized> Part<'_, C> {
    fn plain(&self) -> &[f64] {
        &self.rows.plain[self.channel.index]
    }

    fn white(&self) -> &[f64] {
        &self.rows.white[self.channel.index]
    }

    /// Name of the recording.
    fn name(&self) -> &str {
        let problem = self.channel.of.problem;
        problem.system.name(problem.experiments[self.experiment])
    }

    fn anomaly(&self, kind: &'static str, time_s: Option<f64>, description: String) -> Anomaly {
        let recording = Some(self.name().to_owned());
        Anomaly { recording, time_s, ..self.channel.anomaly(kind, description) }
    }
}
