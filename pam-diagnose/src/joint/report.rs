//! The joint's own part of a report.

use super::diagnose::DiagnosedJoint;
use crate::report::ReportModel;
use maud::{Markup, html};
use pam_report::page::number;

/// Lead of the force (samples) from which it is nearer to a smooth one (½) than to a held one (0).
const SMOOTH: f64 = 0.25;

/// Share of an effect of the baseline recordings below which it is mentioned.
const WHOLE: f64 = 0.995;

impl ReportModel for DiagnosedJoint {
    fn notes(&self) -> Markup {
        html! {
            @if !self.plausibility.is_empty() {
                div.note {
                    "These recordings contradict the physics of the joint; the rest of this page may mean nothing."
                    ul { @for finding in &self.plausibility { li { (finding.to_string()) } } }
                }
            }
            p {
                "The force acts " (number(self.force_lead_samples, 2)) " samples earlier than if each value held until \
                 the next (0 held, ½ smooth)."
                @if self.force_lead_samples > SMOOTH {
                    " It is better read with " code { "--input linear" } " in commands that predict."
                }
            }
            @if let Some(b) = &self.baseline {
                p {
                    "Baseline discrepancy of this model, from " (b.recordings.join(", ")) ": RMS "
                    (number(b.rms[0], 4)) " mm, " (number(b.rms[1], 3)) " and " (number(b.rms[2], 3)) " kPa"
                    @if !b.effects.is_empty() {
                        " with " (b.effects.iter().map(|e| e.effect.info().id).collect::<Vec<_>>().join(", "))
                    }
                    ". That much counts as no fault."
                    @for (effect, share) in b.effects.iter().zip(&b.shares).filter(|(_, share)| **share < WHOLE) {
                        " Of " (effect.effect.info().id) ", these recordings have " (number(100.0 * share, 0)) " %."
                    }
                }
            }
        }
    }

    fn extension(&self) -> Markup {
        html! {
            "The model is extended by these terms; the network stays as it is. "
            code { "model.safetensors" } " holds the result and works in every command that predicts."
        }
    }
}
