//! Features that noise does not have: steps, changes of size, foreign lines and events in a residual.

use crate::fit::{Hypothesis, Problem, fitted_outputs};
use crate::noise::{Autoregression, autocovariance};
use crate::residual::{Line, Spectrum, TimeProfile};
use crate::search::Candidates;
use pam_core::units::significant;
use pam_numerics::statistics::{chi_square_quantile, mean, root_mean_square, t_quantile};
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

/// The anomalies in what a hypothesis leaves; experiments that cannot be simulated have none.
pub(crate) fn anomalies<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    hypothesis: &Hypothesis,
) -> Vec<Anomaly> {
    let settings = problem.settings;
    let excitations = problem.excitation_rows();
    let mut found = Vec::new();
    let rows: Vec<Option<[Vec<Vec<f64>>; 2]>> = (0..problem.len())
        .map(|i| {
            let plain = problem.residuals(hypothesis, i).ok()?;
            Some([plain, problem.whitened_residuals(hypothesis, i).ok()?])
        })
        .collect();
    let count: usize = (0..problem.len()).map(|i| problem.rows(i)).sum();
    let tail = (1.0 - settings.verdict.event_probability) / (2 * count.max(1)) as f64;
    // Heavy tails, and a size of the noise that few rows tell.
    let largest = |c: usize| {
        let freedom = 1.0 / (1.0 / settings.verdict.event_freedom + 1.0 / problem.noise.freedom(c));
        t_quantile(1.0 - tail, freedom) * problem.noise.unseen_level(c).median.sqrt()
    };
    // Needed only where there are events, and for all channels at once.
    let by_timing = vec![OnceCell::new(); problem.len()];
    for (c, (place, output)) in fitted_outputs(problem.system).enumerate() {
        let anomaly = |kind, recording: Option<usize>, time_s, frequency_hz, description| Anomaly {
            kind,
            channel: output.key.clone(),
            recording: recording.map(|i| problem.system.name(problem.experiments[i]).to_owned()),
            time_s,
            frequency_hz,
            description,
        };
        // A drift, a step or a line of the root mean square that errors of the model have by themselves is none of the recordings.
        let own = settings.verdict.inadequate_ratio * problem.noise.discrepancy(c);
        for (i, rows) in rows.iter().enumerate() {
            let Some([plain, white]) = rows else { continue };
            let (e, row_s) = (problem.experiments[i], problem.row_s(i));
            let moments = moments(problem.system, hypothesis, e);
            let start_s =
                problem.system.start_s(e) + problem.system.time_s(e, problem.windows[i].start);
            let name = problem.system.name(e);
            let profile = |r| TimeProfile::new(row_s, start_s, r, &settings.residual).jump;
            if let Some(jump) = profile(&plain[c]) {
                let at = ((jump.time_s - start_s) / row_s).round() as usize;
                let ratio = step_ratio(&plain[c], at, settings.noise.order);
                let share = at as f64 / plain[c].len().max(1) as f64;
                let size =
                    (jump.after - jump.before).abs() * (share * (1.0 - share)).max(0.0).sqrt();
                if ratio > settings.verdict.step_ratio && size > own {
                    let text = format!(
                        "the {} shifts by {} {} at t = {} s in {name}",
                        output.name,
                        significant(jump.after - jump.before, 3),
                        output.unit,
                        significant(jump.time_s, 3)
                    );
                    found.push(anomaly("step", Some(i), Some(jump.time_s), None, text));
                }
            }
            let (drift, ratio) = drift(&plain[c], settings.noise.order);
            // The root mean square of a straight line of this height.
            let size = drift.abs() / 12_f64.sqrt();
            if ratio > settings.verdict.step_ratio && size > own {
                let text = format!(
                    "the {} drifts by {} {} in {name}",
                    output.name,
                    significant(drift, 3),
                    output.unit
                );
                found.push(anomaly("drift", Some(i), None, None, text));
            }
            if let Some(jump) = profile(&white[c]) {
                let ratio = settings.verdict.unlearnable_ratio;
                let verb = if jump.rms_after > ratio * jump.rms_before {
                    "begins"
                } else if jump.rms_before > ratio * jump.rms_after {
                    "ends"
                } else {
                    ""
                };
                // A part that is as quiet as the noise, beside one that is not.
                if !verb.is_empty() && jump.rms_before.max(jump.rms_after) > ratio {
                    let at = significant(jump.time_s, 3);
                    let text =
                        format!("an error of the {} {verb} at t = {at} s in {name}", output.name);
                    found.push(anomaly("change", Some(i), Some(jump.time_s), None, text));
                }
            }
            // Where a cause comes or goes, its course is known to the ramp only.
            let passing = |k: usize| {
                let time_s = start_s - problem.system.start_s(e) + k as f64 * row_s;
                moments
                    .iter()
                    .any(|[from, to]| time_s > from - 1.5 * row_s && time_s < to + 0.5 * row_s)
            };
            let sizes = white[c].iter().map(|w| w.abs()).enumerate().filter(|(k, _)| !passing(*k));
            let mut events: Vec<(usize, f64)> = sizes.filter(|e| e.1 > largest(c)).collect();
            if !events.is_empty() {
                let by_timing = by_timing[i].get_or_init(|| by_timing_of(problem, hypothesis, i));
                let own = by_timing.get(c).map_or(&[][..], Vec::as_slice);
                events.retain(|(k, size)| *size > largest(c) + own.get(*k).unwrap_or(&0.0));
            }
            if let Some((k, size)) = events.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)) {
                let time_s = start_s + k as f64 * row_s;
                let text = format!(
                    "the {} has an event of {} times its noise at t = {} s in {name}",
                    output.name,
                    significant(size, 2),
                    significant(time_s, 3)
                );
                found.push(anomaly("event", Some(i), Some(time_s), None, text));
            }
        }
        let white: Vec<&[f64]> =
            rows.iter().flatten().map(|[_, white]| white[c].as_slice()).collect();
        if excitations.iter().all(Vec::is_empty) || problem.is_empty() {
            continue;
        }
        let row_s = problem.row_s(0);
        let spectrum = Spectrum::new(row_s, &white, &excitations, &settings.residual);
        let piece = (settings.residual.spectrum_piece_s / row_s) as usize;
        let pieces: usize = white.iter().map(|w| 2 * w.len() / piece.max(1)).sum();
        // The power of a lobe of three lines of white noise is distributed as χ², with three degrees of freedom for each
        // independent piece (pieces overlap by half).
        let lobes = spectrum.frequency_hz.len().max(3) as f64;
        let freedom = 3.0 * (0.55 * pieces as f64).max(1.0);
        let tail = (1.0 - settings.verdict.event_probability) / lobes;
        let by_chance = 3.0 / lobes * chi_square_quantile(1.0 - tail, freedom) / freedom;
        // In units of the noise: the largest part of next to nothing is nothing.
        let squares = white.iter().flat_map(|w| w.iter()).map(|v| v * v);
        let level = squares.sum::<f64>() / count.max(1) as f64;
        let least = by_chance.max(settings.residual.foreign_line_share);
        let size = |l: &Line| {
            let plain: Vec<&[f64]> =
                rows.iter().flatten().map(|[plain, _]| plain[c].as_slice()).collect();
            let lobe = Spectrum::new(row_s, &plain, &[], &settings.residual).lobe(l.frequency_hz);
            (lobe * root_mean_square(&centred(&plain)).powi(2)).sqrt()
        };
        // The error of an integration step at a kink of the force depends on the phase within the step, which beats with the
        // excitation: the simulation has lines of its own.
        let smallest = own.max(settings.noise.relative * problem.variation(place));
        let clear = |l: &Line| l.share > by_chance && l.share * level > least && size(l) > smallest;
        if let Some(line) = spectrum.foreign_line(&settings.residual).filter(clear)
            && !rings(problem, hypothesis, c, line.frequency_hz)
        {
            let text = format!(
                "{:.0} % of what is left of the {} is at {} Hz, where the excitation has nothing: something else drives \
                 it",
                100.0 * line.share,
                output.name,
                significant(line.frequency_hz, 3)
            );
            found.push(anomaly("line", None, None, Some(line.frequency_hz), text));
        }
    }
    found
}

/// For each channel and whitened row the largest error that the unknown course of the excitation between two samples can cause: a jump
/// may occur at any time within a sample ([`Candidates::timing`]) and appears in the adjacent rows. Empty if no timing is uncertain.
fn by_timing_of<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    hypothesis: &Hypothesis,
    place: usize,
) -> Vec<Vec<f64>> {
    let Some(timing) = problem.system.timing() else { return Vec::new() };
    let Ok(s) = problem.whitened_sensitivities(hypothesis, place) else { return Vec::new() };
    let shared = s.columns.len() - hypothesis.locals[place].len() - hypothesis.shared.len();
    let [least, most] = problem.system.shared()[timing].limits;
    let of_channel = |rows: &Vec<f64>| -> Vec<f64> {
        let size = |k: usize| (most - least) * rows.get(k).map_or(0.0, |r| r.abs());
        (0..rows.len()).map(|k| size(k).max(size(k + 1)).max(size(k.wrapping_sub(1)))).collect()
    };
    s.columns[shared + timing].iter().map(of_channel).collect()
}

/// The rows of several series, each less its mean.
fn centred(series: &[&[f64]]) -> Vec<f64> {
    let of = |rows: &&[f64]| {
        let centre = mean(rows);
        rows.iter().map(move |r| r - centre).collect::<Vec<_>>()
    };
    series.iter().flat_map(of).collect()
}

/// Whether an error in a nuisance of an experiment, such as the initial state, produces a line at this frequency in a channel: a lightly
/// damped system rings at its natural frequency.
fn rings<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    hypothesis: &Hypothesis,
    channel: usize,
    frequency_hz: f64,
) -> bool {
    let settings = &problem.settings.residual;
    (0..problem.len()).any(|i| {
        let Ok(s) = problem.whitened_sensitivities(hypothesis, i) else { return false };
        let first = s.columns.len().saturating_sub(hypothesis.locals[i].len());
        s.columns[first..].iter().any(|column| {
            let rows = column.get(channel).map_or(&[][..], Vec::as_slice);
            let spectrum = Spectrum::new(problem.row_s(i), &[rows], &[], settings);
            spectrum.lobe(frequency_hz) > settings.foreign_line_share
        })
    })
}

/// Spans in which members of a hypothesis come or go in an experiment, s after its first sample.
fn moments<C: Candidates + ?Sized>(
    system: &C,
    hypothesis: &Hypothesis,
    experiment: usize,
) -> Vec<[f64; 2]> {
    let half = 0.5 * system.ramp_s();
    let timed = hypothesis.members.iter().filter_map(|m| Some((m, m.schedule.as_ref()?)));
    timed
        .flat_map(|(m, s)| {
            let times = s.times_in(experiment).filter(|&k| !s.times[k].logarithmic);
            times.map(|k| [m.times()[k] - half, m.times()[k] + half]).collect::<Vec<_>>()
        })
        .collect()
}

/// The drift of a residual over its rows by a straight line, and its size over its standard error, if what is left beside
/// the line is a stationary noise.
fn drift(rows: &[f64], order: usize) -> (f64, f64) {
    let n = rows.len() as f64;
    let (middle, centre) = (0.5 * (n - 1.0), mean(rows));
    let at = |k: usize| k as f64 - middle;
    let spread = n * (n * n - 1.0) / 12.0;
    let slope = rows.iter().enumerate().map(|(k, r)| at(k) * r).sum::<f64>() / spread.max(1.0);
    let rest: Vec<f64> = rows.iter().enumerate().map(|(k, r)| r - centre - slope * at(k)).collect();
    let noise = Autoregression::of_autocovariance(&autocovariance(&[&rest], order), n);
    let error = noise.deviation() * (noise.correlated_rows() / spread.max(1.0)).sqrt();
    (slope * n, slope.abs() / error.max(f64::MIN_POSITIVE))
}

/// The step of the mean at a row over its standard error, if what is left beside it is a stationary noise.
fn step_ratio(rows: &[f64], at: usize, order: usize) -> f64 {
    let (before, after) = rows.split_at(at.clamp(1, rows.len() - 1));
    let sides = [before, after].map(|side| {
        let centre = mean(side);
        side.iter().map(|r| r - centre).collect::<Vec<f64>>()
    });
    let gamma = autocovariance(&[&sides[0], &sides[1]], order);
    let noise = Autoregression::of_autocovariance(&gamma, rows.len() as f64);
    let share = 1.0 / before.len() as f64 + 1.0 / after.len() as f64;
    let error = noise.deviation() * (noise.correlated_rows() * share).sqrt();
    (mean(after) - mean(before)).abs() / error.max(f64::MIN_POSITIVE)
}
