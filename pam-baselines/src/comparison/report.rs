//! The comparison as a page.

use super::files::{seconds, summary_text};
use super::qualitative::Qualities;
use super::result::{Comparison, SetScores};
use crate::method::{Needs, Structure};
use maud::{Markup, html};
use pam_report::figure::{LineFigure, Role, Stroke};
use pam_report::page::{card, figure, number, page};

/// Smallest R² that is drawn: below it a model is of no use, and the rest would be squeezed.
const LOWEST_R2: f64 = -1.0;

/// One of the four sets of scores of a model.
type Choice = fn(&super::ModelResult) -> &SetScores;

impl Comparison {
    /// The report as one HTML file.
    #[must_use]
    pub fn report(&self, made_by: &str) -> String {
        let lead = format!(
            "{} models, {} training recordings, {} held out; seed {}. Cold: from the first sample alone. \
             Warm: the first {} samples are known. Both are scored on the samples after them.",
            self.models.len(),
            self.train.len(),
            self.held_out.len(),
            self.seed,
            self.warm_up
        );
        let body = html! {
            (self.best_cards())
            h2 { "R² of the displacement" }
            (self.scores_table())
            (figure(self.bars(), &format!(
                "Mean R² of the displacement with one standard deviation. Values below {LOWEST_R2} are drawn \
                 there. Predictions that stopped are not part of the mean; the table counts them."
            ).replace('-', "−")))
            h2 { "By frequency" }
            (self.frequency_table())
            (figure(self.frequency_figure(), "Held-out recordings (training ones if there are none), cold start."))
            @for measured in &self.measured {
                h2 { "Trajectory " (measured.recording) }
                (figure(self.trajectory(&measured.recording, None), "Cold start."))
                (figure(self.trajectory(&measured.recording, Some(6.0)), "The last six seconds."))
            }
            h2 { "Cost, force and stiffness" }
            (self.mechanics_table())
            h2 { "What each kind of model is good for" }
            (self.qualities_table())
            (self.single_muscles())
            (self.stability())
            details { summary { "What the fits found" }
                @for m in &self.models {
                    h3 { (m.result.name) }
                    pre { code { (format!("{:#}", m.result.details)) } }
                }
            }
        };
        let title = match self.best(&|m| all_finish(&m.cold.held_out)) {
            Some((r2, name)) => {
                format!("{name} predicts held-out recordings best: R² of x = {}", number(r2, 3))
            }
            None => format!("Comparison: {}", self.name),
        };
        page(&title, &format!("{}: {lead}", self.name), &body, made_by)
    }

    /// The largest score with the name of its model.
    fn best(&self, value: &dyn Fn(&super::ModelResult) -> Option<f64>) -> Option<(f64, &str)> {
        self.models
            .iter()
            .filter_map(|m| Some((value(&m.result)?, m.result.name.as_str())))
            .max_by(|a, b| a.0.total_cmp(&b.0))
    }

    fn best_cards(&self) -> Markup {
        let best = |value: &dyn Fn(&super::ModelResult) -> Option<f64>| self.best(value);
        html! {
            div.cards {
                @if let Some((r2, name)) = best(&|m| all_finish(&m.cold.held_out)) {
                    (card(name, &format!("best held out, cold start: R² {}", number(r2, 4))))
                }
                @if let Some((r2, name)) = best(&|m| all_finish(&m.warm.held_out)) {
                    (card(name, &format!("best held out, warm start: R² {}", number(r2, 4))))
                }
            }
        }
    }

    fn scores_table(&self) -> Markup {
        html! {
            div.scroll { table {
                tr {
                    th.empty {} th.group colspan="3" { "cold start" } th.group colspan="3" { "warm start" }
                }
                tr {
                    th { "model" }
                    @for _ in 0..2 { th { "training" } th { "held out" } th { "held-out median" } }
                }
                @for (k, m) in self.models.iter().map(|m| &m.result).enumerate() {
                    tr {
                        td { (k + 1) ". " (m.name) @if m.needs == Needs::Pressures { "*" } }
                        @for both in [&m.cold, &m.warm] {
                            td { (summary_text(&both.train.displacement)) }
                            td { (summary_text(&both.held_out.displacement)) }
                            td { (number(both.held_out.displacement.median.unwrap_or(f64::NAN), 4)) }
                        }
                    }
                }
            } }
            @if self.models.iter().any(|m| m.result.needs == Needs::Pressures) {
                p { "* driven by the measured pressures, which the others predict." }
            }
        }
    }

    fn bars(&self) -> String {
        let mut figure =
            LineFigure::new("", "model, by its number in the table", "R² of x", 1040, 360);
        let sets: [(&str, f64, Role, Choice); 4] = [
            ("training, cold", -0.24, Role::Category(0), |m| &m.cold.train),
            ("held out, cold", -0.08, Role::Category(1), |m| &m.cold.held_out),
            ("training, warm", 0.08, Role::Category(2), |m| &m.warm.train),
            ("held out, warm", 0.24, Role::Category(3), |m| &m.warm.held_out),
        ];
        for (label, shift, role, set) in sets {
            let mut label = label;
            for (k, m) in self.models.iter().enumerate() {
                let d = &set(&m.result).displacement;
                let Some(mean) = d.mean else { continue };
                let at = k as f64 + 1.0 + shift;
                let drawn = |v: f64| v.clamp(LOWEST_R2, 1.0);
                figure = figure.with(label, role, vec![(at, drawn(mean))]);
                label = "";
                if let Some(sd) = d.deviation {
                    let ends = vec![(at, drawn(mean - sd)), (at, drawn(mean + sd))];
                    figure = figure.with("", role, ends);
                }
            }
        }
        figure.to_svg()
    }

    fn set_for_frequencies<'a>(&self, m: &'a super::ModelResult) -> &'a SetScores {
        if self.held_out.is_empty() { &m.cold.train } else { &m.cold.held_out }
    }

    fn frequency_table(&self) -> Markup {
        let frequencies = self.frequencies_hz();
        html! {
            div.scroll { table {
                tr { th { "model" } @for f in &frequencies { th { (f) " Hz" } } }
                @for m in self.models.iter().map(|m| &m.result) {
                    @let set = self.set_for_frequencies(m);
                    tr {
                        td { (m.name) }
                        @for f in &frequencies {
                            td { (set.by_frequency.iter().find(|(g, _)| g == f).map_or("–".into(), |(_, s)| summary_text(s))) }
                        }
                    }
                }
            } }
        }
    }

    fn frequency_figure(&self) -> String {
        let mut figure =
            LineFigure::new("", "excitation frequency (Hz)", "mean R² of x", 1040, 360)
                .with_marks();
        for (k, m) in self.models.iter().enumerate() {
            let set = self.set_for_frequencies(&m.result);
            let points: Vec<(f64, f64)> = set
                .by_frequency
                .iter()
                .filter_map(|(f, s)| Some((*f, s.mean?.max(LOWEST_R2))))
                .collect();
            figure = figure.with_stroke(&m.result.name, Role::Category(k), stroke(k), points);
        }
        figure.to_svg()
    }

    fn trajectory(&self, recording: &str, last_s: Option<f64>) -> String {
        let mut figure = LineFigure::new("", "time (s)", "displacement x (mm)", 1040, 380);
        let Some(measured) = self.measured.iter().find(|d| d.recording == recording) else {
            return figure.to_svg();
        };
        let end = measured.time_s.last().copied().unwrap_or(0.0);
        let from = last_s.map_or(f64::NEG_INFINITY, |s| end - s);
        // A prediction far off would flatten all others.
        let reach = measured.displacement_mm.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let points = |d: &super::result::Drawn| {
            d.time_s
                .iter()
                .zip(&d.displacement_mm)
                .filter(|(t, _)| **t >= from)
                .map(|(t, x)| (*t, x.clamp(-2.0 * reach, 2.0 * reach)))
                .collect::<Vec<_>>()
        };
        figure = figure.with("measured", Role::Measured, points(measured));
        for (k, m) in self.models.iter().enumerate() {
            if let Some(d) = m.drawn.iter().find(|d| d.recording == recording) {
                figure =
                    figure.with_stroke(&m.result.name, Role::Category(k), stroke(k), points(d));
            }
        }
        figure.to_svg()
    }

    fn mechanics_table(&self) -> Markup {
        let percent = |v: Option<f64>| v.map_or("–".into(), |v| format!("{v:.1}"));
        html! {
            div.scroll { table {
                tr {
                    th { "model" } th { "parameters" } th { "fit (s)" } th { "predict (s)" }
                    th { "R² of the joint's force" } th { "error of ∂f/∂x (%)" }
                    th { "error of the shown K (%)" } th { "K at rest (N/mm)" } th { "R², single muscle" }
                }
                @for m in &self.models {
                    @let x = &m.result.mechanics;
                    tr {
                        td { (m.result.name) } td { (m.result.parameters) }
                        td { (seconds(m.times.fit_s)) } td { (seconds(m.times.predict_s)) }
                        td { (number(x.force_r2.unwrap_or(f64::NAN), 3).replace('-', "−")) }
                        td { (percent(x.stiffness_error_percent)) }
                        td { (percent(x.shown_stiffness_error_percent)) }
                        td { @if let Some([a, b]) = x.stiffness_range_n_mm { (format!("{a:.0} to {b:.0}").replace('-', "−")) } @else { "–" } }
                        td { (number(x.single_muscle_r2.unwrap_or(f64::NAN), 3)) }
                    }
                }
            } }
            p {
                "Stiffness is compared with what the measured motion of each held-out recording shows (least \
                 squares of M ẍ + B ẋ + K (x − x0) = F). ∂f/∂x is the derivative of a model's own force at rest; \
                 the shown K is what its predicted motion shows by the same least squares."
            }
        }
    }

    fn qualities_table(&self) -> Markup {
        html! {
            div.scroll { table {
                tr {
                    th { "model" } th.text { "prediction" } th.text { "force" } th.text { "stiffness" }
                    th.text { "interpretability" }
                }
                @for m in &self.models {
                    @let q = Qualities::of(&m.result);
                    tr {
                        td { (q.name) }
                        td.text { (q.prediction.label()) } td.text { (q.force.label()) }
                        td.text { (q.stiffness.label()) } td.text { (q.interpretability) }
                    }
                }
            } }
            p {
                "Prediction: median held-out R² of x, cold start (strong from 0.9, moderate from 0.5). Force: R² \
                 of the joint's force along measured motions, same limits. Stiffness: error of ∂f/∂x (strong \
                 below 10 %, moderate below 25 %); indirect where a model without a force shows it in its \
                 motion within 25 %. Interpretability is a property of the model's form, not a measurement."
            }
        }
    }

    /// How well models of single muscles fit those, and what is left of it on the joint.
    fn single_muscles(&self) -> Markup {
        let rows: Vec<_> = self
            .models
            .iter()
            .filter_map(|m| Some((&m.result, m.result.mechanics.single_muscle_r2?)))
            .collect();
        html! {
            @if !rows.is_empty() {
                h2 { "From single muscles to the joint" }
                div.scroll { table {
                    tr {
                        th { "model" } th { "fitted to" } th { "braid angle (°)" }
                        th { "R² of the muscle's force" } th { "R² of x on the joint, held out" }
                    }
                    @for (m, r2) in rows {
                        @let angle = m.details.pointer("/single_muscle/muscle/braid_angle_deg");
                        tr {
                            td { (m.name) }
                            td { (m.details["fitted_to"].as_str().unwrap_or("–")) }
                            td { (angle.and_then(serde_json::Value::as_f64).map_or("–".into(), |a| format!("{a:.1}"))) }
                            td { (number(r2, 3).replace('-', "−")) }
                            td { (summary_text(&self.set_for_frequencies(m).displacement)) }
                        }
                    }
                } }
                p {
                    "The force of the joint is a small difference of two large tensions: what is a good fit of \
                     a muscle can be a poor one of the joint, although these models are given the measured \
                     pressures. The published braid angle is 27.5°; another one is an effective angle."
                }
            }
        }
    }

    fn stability(&self) -> Markup {
        let rows: Vec<_> = self
            .models
            .iter()
            .filter(|m| m.result.structure == Structure::Dictionary)
            .filter_map(|m| Some((&m.result, m.result.details.get("stability")?)))
            .collect();
        let text = |v: Option<&serde_json::Value>| {
            v.and_then(serde_json::Value::as_f64).map_or("–".into(), |v| format!("{v:.6}"))
        };
        html! {
            @if !rows.is_empty() {
                h2 { "Stability of the linear models" }
                div.scroll { table {
                    tr {
                        th { "model" } th { "radius, re-lifted: smallest" } th { "largest" }
                        th { "radius, lifted" } th { "growing modes" } th { "stopped, held out" }
                    }
                    @for (m, s) in rows {
                        tr {
                            td { (m.name) }
                            td { (text(s["relifted_radius"].get(0))) } td { (text(s["relifted_radius"].get(1))) }
                            td { (text(s.get("lifted_radius"))) }
                            td { (s["lifted_growing"].as_u64().map_or("–".into(), |n| n.to_string())) }
                            td { (m.cold.held_out.displacement.stopped) " of " (m.cold.held_out.displacement.count) }
                        }
                    }
                } }
                p {
                    "Spectral radii of the map from sample to sample without input: of the re-lifted map \
                     linearised at the starts of the training recordings, and of the lifted map. A radius above \
                     one grows."
                }
            }
        }
    }
}

/// Strokes distinguish lines of one colour.
fn stroke(k: usize) -> Stroke {
    if k.is_multiple_of(2) { Stroke::Solid } else { Stroke::Dashed }
}

/// Mean R² of the displacement if every prediction reached the end of its recording.
fn all_finish(scores: &SetScores) -> Option<f64> {
    scores.displacement.mean.filter(|_| scores.displacement.stopped == 0)
}
