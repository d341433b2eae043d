//! The residual in numbers and in sentences that are filled from them.

use super::dependence::{Dependence, Factors};
use super::spectrum::Spectrum;
use super::timing::TimeProfile;
use crate::fit::{Hypothesis, Problem, fitted_outputs};
use crate::noise::correlated_rows;
use crate::search::Candidates;
use crate::settings::ResidualSettings;
use pam_core::units::significant;
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

/// The residual of one channel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChannelResidual {
    /// Key of the channel.
    #[serde(skip)]
    pub key: String,
    /// Its name.
    #[serde(skip)]
    pub name: String,
    /// Unit of the numbers.
    pub unit: String,
    /// Root mean square of the residual.
    pub rms: f64,
    /// Root mean square of the residual that remains after the named causes.
    pub rms_left: f64,
    /// Standard deviation below which an error counts as noise, with the baseline discrepancy.
    pub noise: f64,
    /// Mean of the residual.
    pub mean: f64,
    /// Correlation of neighbouring rows; near zero for white noise.
    pub next_correlation: f64,
    /// Factors on which the residual depends, strongest first.
    #[serde(serialize_with = "by_factor")]
    pub dependence: Vec<Dependence>,
    /// Strongest lines of its spectrum.
    pub lines: Vec<super::Line>,
    /// Its spectrum.
    #[serde(skip)]
    pub spectrum: Spectrum,
    /// Its time profile, one entry per recording.
    #[serde(skip)]
    pub profiles: Vec<(String, TimeProfile)>,
    /// The channel in a few sentences.
    #[serde(skip)]
    pub description: String,
}

/// The residuals of all fitted channels.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ResidualSummary {
    /// The channels.
    #[serde(serialize_with = "by_key")]
    pub channels: Vec<ChannelResidual>,
    /// All channels in sentences.
    pub description: String,
}

fn by_factor<S: Serializer>(list: &[Dependence], to: S) -> Result<S::Ok, S::Error> {
    let mut map = to.serialize_map(Some(list.len()))?;
    for d in list {
        map.serialize_entry(&d.factor.replace(' ', "_"), &d.share)?;
    }
    map.end()
}

fn by_key<S: Serializer>(list: &[ChannelResidual], to: S) -> Result<S::Ok, S::Error> {
    let mut map = to.serialize_map(Some(list.len()))?;
    for channel in list {
        map.serialize_entry(&channel.key, channel)?;
    }
    map.end()
}

/// Residuals of every experiment at a hypothesis; one that cannot be simulated has none.
fn residuals<C: Candidates + ?Sized>(p: &Problem<'_, C>, h: &Hypothesis) -> Vec<Vec<Vec<f64>>> {
    let none = || vec![Vec::new(); p.noise.channels()];
    (0..p.len()).map(|i| p.residuals(h, i).unwrap_or_else(|_| none())).collect()
}

fn rms<'r>(each: impl Iterator<Item = &'r f64> + Clone) -> f64 {
    let n = each.clone().count().max(1) as f64;
    (each.map(|v| v * v).sum::<f64>() / n).sqrt()
}

impl ResidualSummary {
    /// The residual of `before`, with the size of what `after` leaves, with the `noise` of each channel: its noise from
    /// one row to the next, and the errors of the model on baseline recordings.
    #[must_use]
    pub fn of<C: Candidates + ?Sized>(
        problem: &Problem<'_, C>,
        before: &Hypothesis,
        after: &Hypothesis,
        noise: &[f64],
    ) -> Self {
        let settings = &problem.settings.residual;
        let all = residuals(problem, before);
        let left = residuals(problem, after);
        let factors = Factors::of(problem, before, &all);
        let row_s = problem.row_s(0);
        let excitations = problem.excitation_rows();
        let channels: Vec<ChannelResidual> = fitted_outputs(problem.system)
            .enumerate()
            .map(|(c, (_, output))| {
                let each: Vec<&[f64]> = all.iter().map(|r| r[c].as_slice()).collect();
                let values = each.concat();
                let n = values.len().max(1) as f64;
                let square: f64 = values.iter().map(|v| v * v).sum();
                let mean = values.iter().sum::<f64>() / n;
                let next: f64 = each
                    .iter()
                    .flat_map(|r| r.windows(2))
                    .map(|w| (w[0] - mean) * (w[1] - mean))
                    .sum();
                let variance = (square / n - mean * mean).max(1e-300);
                let per_experiment =
                    each.iter().map(|r| correlated_rows(r, &problem.settings.noise));
                let observation = per_experiment.fold(1.0, f64::max);
                let spectrum = Spectrum::new(row_s, &each, &excitations, settings);
                let profile = |(i, r): (usize, &&[f64])| {
                    let (e, window) = (problem.experiments[i], &problem.windows[i]);
                    let start_s = problem.system.time_s(e, window.start);
                    let profile = TimeProfile::new(problem.row_s(i), start_s, r, settings);
                    (problem.system.name(e).to_owned(), profile)
                };
                let mut channel = ChannelResidual {
                    key: output.key.clone(),
                    name: output.name.clone(),
                    unit: output.unit.clone(),
                    rms: (square / n).sqrt(),
                    rms_left: rms(left.iter().flat_map(|r| &r[c])),
                    noise: noise[c],
                    mean,
                    next_correlation: next / n / variance,
                    dependence: factors.dependences(&values, observation, settings.groups),
                    lines: spectrum.lines(settings.lines),
                    spectrum,
                    profiles: each.iter().enumerate().map(profile).collect(),
                    description: String::new(),
                };
                channel.description = channel.describe(settings);
                channel
            })
            .collect();
        let sentences: Vec<&str> = channels.iter().map(|c| c.description.as_str()).collect();
        let description = sentences.join(" ");
        Self { channels, description }
    }
}

impl ChannelResidual {
    /// The residual over the noise.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.rms / self.noise
    }

    /// The channel in a few sentences.
    fn describe(&self, settings: &ResidualSettings) -> String {
        let (name, unit) = (&self.name, &self.unit);
        let n = |v: f64| significant(v, 3);
        let mut text = format!(
            "The RMS residual of the {name} is {} {unit}, {} times its noise and baseline discrepancy ({} {unit})",
            n(self.rms),
            significant(self.ratio(), 2),
            n(self.noise)
        );
        if self.ratio() < settings.nothing_ratio {
            let ratio = significant(settings.nothing_ratio, 2);
            return text + &format!("; below {ratio} times, its structure is not described.");
        }
        if self.mean.abs() > settings.steady_share * self.rms {
            text += &format!("; most of it is a steady {} {unit}", n(self.mean));
        }
        text += ".";
        let strong: Vec<String> = self
            .dependence
            .iter()
            .filter(|d| d.share > settings.mentioned_share)
            .take(settings.mentioned_factors)
            .map(|d| format!("{} ({:.0} %)", d.factor, 100.0 * d.share))
            .collect();
        if strong.is_empty() {
            let share = 100.0 * settings.mentioned_share;
            text += &format!(" No single factor explains more than {share:.0} % of it.");
        } else {
            text += &format!(" Its variance depends on {}.", strong.join(", "));
        }
        if let Some(line) = self.spectrum.foreign_line(settings) {
            text += &format!(
                " {:.0} % of its power is at {} Hz, where the excitation has none: something else drives it, or it rings by itself.",
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
        for (name, jump) in self
            .profiles
            .iter()
            .filter_map(|(name, p)| p.jump.map(|j| (name, j)))
            .take(settings.mentioned_jumps)
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
