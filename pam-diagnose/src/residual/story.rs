//! The residual in numbers and in sentences that are filled from them.

use super::dependence::{Dependence, all_residuals, dependences};
use super::spectrum::Spectrum;
use super::timing::TimeProfile;
use crate::fit::{Floors, Hypothesis, POINTS_PER_ROW, Problem};
use pam_effects::model::significant;
use serde::Serialize;

/// Names of the fitted channels, with their units.
const NAMES: [(&str, &str, &str); 3] = [
    ("x", "displacement", "mm"),
    ("pf", "flexor pressure", "kPa"),
    ("pe", "extensor pressure", "kPa"),
];

/// One channel's residual.
#[derive(Debug, Clone, Serialize)]
pub struct ChannelStory {
    /// Key of the channel.
    pub channel: &'static str,
    /// Unit of the numbers.
    pub unit: &'static str,
    /// Root mean square of the residual.
    pub rms: f64,
    /// Root mean square that counts as explained: noise, and what is ordinary for the model.
    pub floor: f64,
    /// Mean of the residual.
    pub mean: f64,
    /// Correlation of neighbouring rows (20 ms apart); near zero for white noise.
    pub next_correlation: f64,
    /// What the residual goes with, strongest first.
    pub dependence: Vec<Dependence>,
    /// At which frequencies it lives.
    pub spectrum: Spectrum,
    /// When it lives, recording by recording.
    pub profiles: Vec<(String, TimeProfile)>,
}

/// The whole residual.
#[derive(Debug, Clone, Serialize)]
pub struct ResidualStory {
    /// Its channels.
    pub channels: Vec<ChannelStory>,
    /// What is to be said.
    pub description: String,
}

impl ResidualStory {
    /// The story of what a hypothesis leaves.
    #[must_use]
    pub fn of(problem: &Problem<'_>, hypothesis: &Hypothesis<'_>, floors: &Floors) -> Self {
        let residuals = all_residuals(problem, hypothesis);
        let row_s = problem.trials[0].record.step_s * POINTS_PER_ROW as f64;
        let forces: Vec<Vec<f64>> = (0..problem.len())
            .map(|i| {
                let force = problem.trials[i].record.force.values_mn();
                let window = problem.windows[i].clone();
                window.step_by(POINTS_PER_ROW).map(|k| force[2 * (k + 2)]).collect()
            })
            .collect();
        let channels: Vec<ChannelStory> = (0..3)
            .map(|c| {
                let each: Vec<&[f64]> = residuals.iter().map(|r| r[c].as_slice()).collect();
                let n = each.iter().map(|r| r.len()).sum::<usize>().max(1) as f64;
                let sum = |f: fn(f64) -> f64| {
                    each.iter().flat_map(|r| r.iter()).map(|&v| f(v)).sum::<f64>()
                };
                let square = sum(|v| v * v);
                let mean = sum(|v| v) / n;
                let next: f64 = each
                    .iter()
                    .flat_map(|r| r.windows(2))
                    .map(|w| (w[0] - mean) * (w[1] - mean))
                    .sum();
                let spread = (square / n - mean * mean).max(1e-300);
                ChannelStory {
                    channel: NAMES[c].0,
                    unit: NAMES[c].2,
                    rms: (square / n).sqrt(),
                    floor: floors.0[c],
                    mean,
                    next_correlation: next / n / spread,
                    dependence: dependences(problem, &residuals, c),
                    spectrum: Spectrum::new(row_s, &each, &forces),
                    profiles: (0..problem.len())
                        .map(|i| {
                            let t = problem.trials[i];
                            let start_s = problem.windows[i].start as f64 * t.record.step_s;
                            (
                                t.record.source.name.clone(),
                                TimeProfile::new(row_s, start_s, &residuals[i][c]),
                            )
                        })
                        .collect(),
                }
            })
            .collect();
        let description = channels.iter().map(ChannelStory::sentence).collect::<Vec<_>>().join(" ");
        Self { channels, description }
    }
}

impl ChannelStory {
    /// How far the residual is above what counts as explained.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.rms / self.floor
    }

    /// The channel in a few sentences.
    #[must_use]
    pub fn sentence(&self) -> String {
        let name = NAMES.iter().find(|n| n.0 == self.channel).map_or(self.channel, |n| n.1);
        let unit = self.unit;
        let n = |v: f64| significant(v, 3);
        let mut text = format!(
            "The {name} is off by {} {unit} (RMS), {} times the {} {unit} that noise and ordinary error \
             leave",
            n(self.rms),
            significant(self.ratio(), 2),
            n(self.floor)
        );
        if self.ratio() < 2.0 {
            return text + ": nothing to explain.";
        }
        if self.mean.abs() > 0.5 * self.rms {
            text += &format!("; most of it is a steady {} {unit}", n(self.mean));
        }
        text += ".";
        let strong: Vec<String> = self
            .dependence
            .iter()
            .filter(|d| d.share > 0.15)
            .take(3)
            .map(|d| format!("{} ({:.0} %)", d.factor, 100.0 * d.share))
            .collect();
        if strong.is_empty() {
            text += " No single factor (position, velocity, direction, force, phase, amplitude, time) \
                     explains more than 15 % of it.";
        } else {
            text += &format!(" Its variance goes with {}.", strong.join(", "));
        }
        if let Some(line) = self.spectrum.foreign_line() {
            text += &format!(
                " {:.0} % of its power is at {} Hz, where the force has none: something else drives it.",
                100.0 * line.share,
                significant(line.frequency_hz, 3)
            );
        } else if let Some(line) = self.spectrum.lines(1).first() {
            text += &format!(
                " {:.0} % of its power is at {} Hz.",
                100.0 * line.share,
                significant(line.frequency_hz, 3)
            );
        }
        let worst = self
            .profiles
            .iter()
            .filter_map(|(name, p)| {
                let square: f64 = p.rms.iter().map(|r| r * r).sum();
                (!p.rms.is_empty()).then(|| (name, (square / p.rms.len() as f64).sqrt()))
            })
            .max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((name, rms)) = worst
            && self.profiles.len() > 1
        {
            text += &format!(" It is largest in {name} ({} {unit}).", n(rms));
        }
        for (name, jump) in
            self.profiles.iter().filter_map(|(name, p)| p.jump.map(|j| (name, j))).take(2)
        {
            text += &format!(
                " In {name} it changes at t = {} s: mean {} {unit} before and {} {unit} after, RMS {} and \
                 {} {unit}.",
                significant(jump.time_s, 3),
                n(jump.before),
                n(jump.after),
                n(jump.rms_before),
                n(jump.rms_after)
            );
        }
        text
    }
}
