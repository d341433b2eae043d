//! Single rows that no noise explains.

use super::{Anomaly, Part};
use crate::fit::{Hypothesis, Problem};
use crate::search::Candidates;
use pam_core::units::significant;
use pam_numerics::statistics::t_quantile;

impl<C: Candidates + ?Sized> Part<'_, C> {
    /// The largest row that is larger than noise.
    pub(super) fn event(&self) -> Option<Anomaly> {
        let residuals = self.channel.of;
        let (problem, hypothesis) = (residuals.problem, residuals.hypothesis);
        let experiment = problem.experiments[self.experiment];
        let moments = moments(problem.system, hypothesis, experiment);
        // Where a cause comes or goes, its course is known to the ramp only.
        let passing = |k: usize| {
            let time_s = self.start_s - problem.system.start_s(experiment) + k as f64 * self.row_s;
            let near = |[from, to]: &[f64; 2]| {
                time_s > from - 1.5 * self.row_s && time_s < to + 0.5 * self.row_s
            };
            moments.iter().any(near)
        };
        let largest = self.largest_of_noise();
        let sizes = self.white().iter().map(|w| w.abs()).enumerate().filter(|(k, _)| !passing(*k));
        let mut events: Vec<(usize, f64)> = sizes.filter(|e| e.1 > largest).collect();
        if !events.is_empty() {
            let by_timing = residuals.by_timing[self.experiment]
                .get_or_init(|| by_timing_of(problem, hypothesis, self.experiment));
            let own = by_timing.get(self.channel.index).map_or(&[][..], Vec::as_slice);
            events.retain(|(k, size)| *size > largest + own.get(*k).unwrap_or(&0.0));
        }
        let (k, size) = events.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let time_s = self.start_s + k as f64 * self.row_s;
        let text = format!(
            "the {} has an event of {} times its noise at t = {} s in {}",
            self.channel.output.name,
            significant(size, 2),
            significant(time_s, 3),
            self.name()
        );
        Some(self.anomaly("event", Some(time_s), text))
    }

    /// The largest whitened row that noise has: with heavy tails, and a size of the noise that few rows tell.
    fn largest_of_noise(&self) -> f64 {
        let problem = self.channel.of.problem;
        let settings = &problem.settings.verdict;
        let tail = (1.0 - settings.event_probability) / (2 * self.channel.of.count.max(1)) as f64;
        let own = problem.noise.freedom(self.channel.index);
        let freedom = 1.0 / (1.0 / settings.event_freedom + 1.0 / own);
        let level = problem.noise.unseen_level(self.channel.index).median;
        t_quantile(1.0 - tail, freedom) * level.sqrt()
    }
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
