//! The joint's own part of a report.

use super::diagnose::DiagnosedJoint;
use crate::report::ReportModel;
use maud::{Markup, html};
use pam_report::page::number;

/// Lead of the force (samples) from which it is nearer to a smooth one (½) than to a held one (0).
const SMOOTH: f64 = 0.25;

/// Lead of the force (samples) below which it counts as held.
const HELD: f64 = 0.05;

/// Noise of the force (N) that is not 0.00 when it is printed.
const LEAST_SHOWN_N: f64 = 0.005;

/// Share of an effect of the baseline recordings below which it is mentioned.
const WHOLE: f64 = 0.995;

impl ReportModel for DiagnosedJoint {
    fn notes(&self) -> Markup {
        html! {
            @if !self.plausibility.is_empty() {
                div.note {
                    "These recordings contradict the physics of the joint; the results on this page may be meaningless."
                    ul { @for finding in &self.plausibility { li { (finding.to_string()) } } }
                }
            }
            @if !self.cut_recordings.is_empty() {
                div.note { ul { @for cut in &self.cut_recordings { li { (cut.to_string()) "." } } } }
            }
            p {
                @if self.force_lead_samples.abs() < HELD {
                    "The force between two samples is that of the first: it is held."
                } @else {
                    "The force acts " (number(self.force_lead_samples.abs(), 2)) " samples "
                    @if self.force_lead_samples < 0.0 { "later" } @else { "earlier" }
                    " than a force that each sample holds until the next. (A force that is smooth between samples acts ½ sample earlier.)"
                }
                @if self.force_lead_samples > SMOOTH {
                    " Read it with " code { "--input linear" } " in commands that predict."
                }
                @if let Some(noise_n) = self.force_noise_n.filter(|n| *n >= LEAST_SHOWN_N) {
                    " " (number(noise_n, 2)) " N of the measured force are noise, at frequencies that the excitation does not have: the joint did "
                    "not respond to them."
                }
            }
            @if let Some(b) = &self.baseline {
                p {
                    "Baseline discrepancy of this model, from " (b.recordings.join(", ")) ": RMS "
                    (number(b.rms[0], 4)) " mm, " (number(b.rms[1], 3)) " and " (number(b.rms[2], 3)) " kPa"
                    @if !b.effects.is_empty() {
                        " with " (b.effects.iter().map(|e| e.effect.info().plain_name()).collect::<Vec<_>>().join(", "))
                    }
                    ". An error of this size is not a fault."
                    @for (effect, share) in b.effects.iter().zip(&b.shares).filter(|(_, share)| **share < WHOLE) {
                        " These recordings show " (number(100.0 * share, 0)) " % of its " (effect.effect.info().plain_name()) "."
                    }
                }
            } @else {
                p {
                    "No baseline recordings were given. An error of the model itself, such as a force that is off by a few percent, may therefore "
                    "be named as a fault, and the intervals include such errors only as far as the residual shows them. Recordings without a "
                    "fault, given as " code { "--healthy" } ", distinguish the two."
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
