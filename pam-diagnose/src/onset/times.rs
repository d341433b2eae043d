//! When a named cause acts, in each recording.

use super::schedule::{Acts, Pattern};
use crate::fit::{Interval, Member};
use crate::search::Candidates;
use pam_core::units::significant;
use serde::Serialize;
use std::collections::BTreeMap;

/// When a cause acts in one recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RecordingTimes {
    /// The recording.
    pub recording: String,
    /// `always`, `never`, `begins`, `ends`, `grows` or `passes`.
    pub acts: &'static str,
    /// The times by their names, in the time of the recording (s); `ramp_s` is a duration.
    #[serde(flatten)]
    pub times: BTreeMap<&'static str, Interval>,
}

/// When a cause acts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Times {
    /// `shared`: every recording has the same times since its first sample; `once`: it comes or goes once in the order of the
    /// recordings; `each`: each recording has times of its own.
    pub pattern: &'static str,
    /// For each recording, those of the test set among them.
    pub recordings: Vec<RecordingTimes>,
}

impl Times {
    /// The times of a member with their intervals (s after the first sample); `None` for one that is always there.
    pub(crate) fn of<C: Candidates + ?Sized>(
        system: &C,
        experiments: &[usize],
        member: &Member,
        intervals: &[Interval],
    ) -> Option<Self> {
        let schedule = member.schedule.as_ref()?;
        let recordings = experiments
            .iter()
            .map(|&e| {
                let (acts, range) = (schedule.acts[e], schedule.times_in(e));
                let start_s = system.start_s(e);
                let times = range.map(|k| {
                    let (info, mut interval) = (schedule.times[k], intervals[k]);
                    if !info.logarithmic {
                        interval.value += start_s;
                        interval.ci95 = interval.ci95.map(|t| t + start_s);
                    }
                    (info.name, interval)
                });
                let acts = match acts {
                    Acts::Always => "always",
                    Acts::Never => "never",
                    Acts::Within(course, _) if course.ramp => "grows",
                    Acts::Within(course, _) if course.onset && course.end => "passes",
                    Acts::Within(course, _) if course.onset => "begins",
                    Acts::Within(..) => "ends",
                };
                let recording = system.name(e).to_owned();
                RecordingTimes { recording, acts, times: times.collect() }
            })
            .collect();
        Some(Self { pattern: schedule.pattern.name(), recordings })
    }

    /// Takes the times of recordings that were not fitted from a member.
    pub(crate) fn renew<C: Candidates + ?Sized>(&mut self, system: &C, member: &Member) {
        let Some(schedule) = &member.schedule else { return };
        for (e, recording) in self.recordings.iter_mut().enumerate() {
            for k in schedule.times_in(e) {
                let Some(interval) = recording.times.get_mut(schedule.times[k].name) else {
                    continue;
                };
                let scale = schedule.times[k].logarithmic;
                interval.value = member.times()[k] + if scale { 0.0 } else { system.start_s(e) };
            }
        }
    }

    /// In words: "coulomb_friction begins at t = 35.0 s [34.9, 35.1] in nn_4545".
    #[must_use]
    pub fn sentence(&self, effect: &str) -> String {
        let timed: Vec<&RecordingTimes> =
            self.recordings.iter().filter(|r| !r.times.is_empty()).collect();
        let names = |acts: &str| -> Vec<&str> {
            let own = self.recordings.iter().filter(|r| r.acts == acts);
            own.map(|r| r.recording.as_str()).collect()
        };
        if self.pattern == Pattern::Shared.name()
            && let Some(first) = timed.first()
        {
            let place = match self.recordings.len() {
                1 => first.recording.clone(),
                _ => "each recording".to_owned(),
            };
            return format!("{effect} {} in {place}", first.sentence());
        }
        let mut parts: Vec<String> =
            timed.iter().map(|r| format!("{} in {}", r.sentence(), r.recording)).collect();
        for (acts, verb) in [("always", "is there in"), ("never", "is not there in")] {
            let names = names(acts);
            if !names.is_empty() {
                parts.push(format!("{verb} {}", names.join(", ")));
            }
        }
        format!("{effect} {}", parts.join(", "))
    }
}

impl RecordingTimes {
    fn sentence(&self) -> String {
        let at = |name: &str| {
            let interval = self.times.get(name)?;
            // To a hundredth of a second, or to the digits that a short span asks for.
            let n = |v: f64| if v.abs() >= 1.0 { format!("{v:.2}") } else { significant(v, 3) };
            let [low, high] = interval.ci95;
            Some(format!("{} s [{}, {}]", n(interval.value), n(low), n(high)))
        };
        let onset = at("onset_s").unwrap_or_default();
        let end = at("end_s").unwrap_or_default();
        match self.acts {
            "grows" => {
                let ramp = at("ramp_s").unwrap_or_default();
                format!("grows about t = {onset} over {ramp}")
            }
            "passes" => format!("begins at t = {onset} and ends at t = {end}"),
            "ends" => format!("ends at t = {end}"),
            _ => format!("begins at t = {onset}"),
        }
    }
}
