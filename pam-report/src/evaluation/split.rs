//! Recordings that a model was trained on, and those it never saw.

use crate::page::{card, number};
use maud::{Markup, html};
use pam_train::RecordingEvaluation;
use pam_trajectory::Scores;
use std::collections::HashSet;

/// Which of the evaluated recordings were trained on.
pub(super) struct Split<'a> {
    recordings: &'a [RecordingEvaluation],
    trained_on: HashSet<&'a str>,
}

impl<'a> Split<'a> {
    /// The split by the names of the recordings trained on.
    pub(super) fn new(recordings: &'a [RecordingEvaluation], trained_on: &'a [String]) -> Self {
        Self { recordings, trained_on: trained_on.iter().map(String::as_str).collect() }
    }

    /// True if the model was trained on the recording of this name.
    pub(super) fn trained_on(&self, name: &str) -> bool {
        self.trained_on.contains(name)
    }

    /// True if any recording here is known to be trained on.
    pub(super) fn is_known(&self) -> bool {
        self.recordings.iter().any(|r| self.trained_on(&r.recording.name))
    }

    /// Mean scores of both kinds with their names, if both are present.
    pub(super) fn means(&self) -> Vec<(String, Scores)> {
        let [seen, held] = [true, false].map(|kind| {
            let of_kind = |r: &&RecordingEvaluation| self.trained_on(&r.recording.name) == kind;
            self.recordings.iter().filter(of_kind).collect::<Vec<_>>()
        });
        if seen.is_empty() || held.is_empty() {
            return Vec::new();
        }
        [("trained on", seen), ("held out", held)]
            .into_iter()
            .map(|(name, group)| {
                let mean = Scores::mean(group.iter().map(|r| &r.scores));
                (format!("mean, {name} ({})", group.len()), mean)
            })
            .collect()
    }

    /// Cards of the mean R² of both kinds, if both are present.
    pub(super) fn cards(&self) -> Markup {
        let means = self.means();
        html! {
            @if !means.is_empty() {
                div.cards {
                    @for (name, mean) in &means {
                        (card(&number(mean.r2.x, 3), &format!("{name}: R² displacement")))
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{EvaluationContext, evaluation_report};
    use super::*;
    use pam_core::{JointModel, SealedMasses, SpringDamper};
    use pam_data::Subject;
    use pam_data::{MassOrigin, ModelInfo, Recording};
    use pam_train::{Evaluation, evaluate};
    use pam_trajectory::SolverSettings;

    fn model() -> JointModel<f64, SpringDamper<f64>> {
        JointModel::datasheet(SpringDamper::published())
    }

    /// Four conditions whose displacements the model misses, each by its own share.
    fn evaluation() -> Evaluation {
        let subject = |k: usize| {
            let t: Vec<f64> = (0..200).map(|i| f64::from(i) * 1e-2).collect();
            let sine = |size: f64| t.iter().map(|t| size * (6.0 * t).sin()).collect::<Vec<f64>>();
            let recording = Recording {
                name: format!("run_{k}"),
                source: "run.csv".into(),
                displacement_mm: sine(0.5 + 0.2 * k as f64),
                velocity_mm_s: sine(1.0),
                pressure_flexor_kpa: sine(300.0 + k as f64),
                pressure_extensor_kpa: sine(400.0),
                force_mn: sine(1e5),
                given_masses: None,
                sealed: None,
                command_psi: Some([10.0 * k as f64, 20.0]),
                rig: None,
                pressure_in_file: None,
                low_passed: Default::default(),
                preprocessing: String::new(),
                notes: Vec::new(),
                time_s: t,
            };
            let masses = SealedMasses::new(0.05 + 0.01 * k as f64, 0.06).unwrap();
            Subject { recording, masses, origin: MassOrigin::Given }
        };
        evaluate(&model(), (0..4).map(subject).collect(), &SolverSettings::default(), &|| ())
    }

    fn report(evaluation: &Evaluation, trained_on: &[&str]) -> String {
        let context = EvaluationContext {
            model: ModelInfo::default(),
            model_line: String::new(),
            solver_line: String::new(),
            trained_on: trained_on.iter().map(|s| (*s).to_owned()).collect(),
            made_by: String::new(),
        };
        evaluation_report(evaluation, &model(), &context)
    }

    /// The maps' part of a report.
    fn maps(report: &str) -> &str {
        let start = report.find("Error over the operating points").unwrap();
        &report[start..report.find("Learned force").unwrap()]
    }

    #[test]
    fn each_trained_point_has_a_ring_in_every_map() {
        let evaluation = evaluation();
        let html = report(&evaluation, &["run_1", "run_3", "elsewhere"]);
        // Two points and the legend in each of four maps.
        assert_eq!(maps(&html).matches("<circle").count(), 4 * 3);
        assert!(maps(&html).contains("the 2 of 4 conditions"));
        let names = ["run_1".to_owned(), "run_3".to_owned()];
        let means = Split::new(&evaluation.recordings, &names).means();
        let r2 = |k: usize| evaluation.recordings[k].scores.r2.x;
        assert_eq!(means[0].1.r2.x, 0.5 * (r2(1) + r2(3)));
        assert_eq!(means[1].1.r2.x, 0.5 * (r2(0) + r2(2)));
        for (name, mean) in means {
            // In a card and in the table.
            assert_eq!(html.matches(&name).count(), 2, "{name}");
            assert!(html.contains(&number(mean.r2.x, 3)) && html.contains(&number(mean.r2.x, 4)));
        }
    }

    #[test]
    fn nothing_is_drawn_where_nothing_is_known_and_one_kind_has_no_means() {
        let evaluation = evaluation();
        let unknown = report(&evaluation, &[]);
        assert!(!maps(&unknown).contains("<circle") && !unknown.contains("trained on"));
        let all = report(&evaluation, &["run_0", "run_1", "run_2", "run_3"]);
        assert_eq!(maps(&all).matches("<circle").count(), 4 * 5);
        assert!(!all.contains("mean, trained on") && !all.contains("held out"));
    }
}
