//! Where the named causes act on the joint.

use super::headline::capitalised;
use crate::verdict::Cause;
use maud::{Markup, html};
use pam_vocabulary::{Group, by_id, plain_name};

/// A part of the joint on which causes act.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Drive,
    Joint,
    Muscles,
    PressureSensors,
    PositionSensor,
}

impl Part {
    /// The part on which an effect of the vocabulary acts.
    fn of(id: &str) -> Option<Self> {
        let info = by_id(id).ok()?;
        Some(match info.group {
            Group::Mechanics => Self::Joint,
            Group::Gas => Self::Muscles,
            Group::Sensing if id.starts_with("pressure") => Self::PressureSensors,
            Group::Sensing if id.starts_with("position") => Self::PositionSensor,
            Group::Sensing => Self::Drive,
        })
    }

    fn name(self) -> &'static str {
        match self {
            Self::Drive => "drive and force signal",
            Self::Joint => "pulley, tendons and load",
            Self::Muscles => "air in the muscles",
            Self::PressureSensors => "pressure sensors",
            Self::PositionSensor => "position sensor",
        }
    }

    /// Middle of its badges, px.
    fn badge(self) -> (usize, usize) {
        match self {
            Self::Drive => (424, 52),
            Self::Joint => (290, 110),
            Self::Muscles => (80, 68),
            Self::PressureSensors => (164, 24),
            Self::PositionSensor => (340, 196),
        }
    }
}

const LINE: &str = "var(--muted, #555555)";
const INK: &str = "var(--text, #222222)";
const PLAIN: &str = "var(--panel, #f5f6f8)";
const BADGE: &str = "var(--warning, #c04f00)";

/// A drawing of the joint with numbers where the causes act, and what the numbers stand for; nothing for causes outside the
/// vocabulary.
pub(super) fn figure(causes: &[Cause]) -> Markup {
    let acts: Vec<(Part, String)> =
        causes.iter().filter_map(|c| Some((Part::of(&c.effect)?, plain_name(&c.effect)))).collect();
    if acts.is_empty() {
        return html! {};
    }
    html! {
        figure.location {
            (drawing(&acts))
            figcaption {
                "Where the causes act: "
                @for (k, (part, name)) in acts.iter().enumerate() {
                    @if k > 0 { "; " }
                    b { (k + 1) " " (capitalised(name)) } " (" (part.name()) ")"
                }
                "."
            }
        }
    }
}

fn drawing(acts: &[(Part, String)]) -> Markup {
    let marked = |part: Part| acts.iter().any(|(p, _)| *p == part);
    let fill = |part: Part| if marked(part) { "var(--mark, #ffe3d1)" } else { PLAIN };
    let stroke = |part: Part| if marked(part) { BADGE } else { LINE };
    let width = |part: Part| if marked(part) { "3" } else { "1.5" };
    let names: Vec<String> =
        acts.iter().map(|(part, name)| format!("{name} at the {}", part.name())).collect();
    html! {
        svg xmlns="http://www.w3.org/2000/svg" class="schematic" viewBox="0 0 480 220" width="480" role="img"
            aria-label=(format!("The joint, with the places where causes act: {}", names.join("; ")))
            font-family="system-ui, sans-serif" font-size="14" fill="none" {
            // The wall that holds the muscles.
            path d="M14 30V190M14 40l-10 10M14 70l-10 10M14 100l-10 10M14 130l-10 10M14 160l-10 10" stroke=(LINE) {}
            // Flexor and extensor with their tendons around the pulley.
            @for (y, name) in [(68, "flexor"), (152, "extensor")] {
                path d=(format!("M14 {y}h24M202 {y}h88")) stroke=(stroke(Part::Joint)) stroke-width=(width(Part::Joint)) {}
                path d=(format!("M38 {y}c14-24 150-24 164 0c-14 24-150 24-164 0z")) fill=(fill(Part::Muscles)) stroke=(stroke(Part::Muscles))
                    stroke-width=(width(Part::Muscles)) {}
                text x="132" y=(y + 5) text-anchor="middle" fill=(INK) { (name) }
            }
            circle cx="290" cy="110" r="42" fill=(fill(Part::Joint)) stroke=(stroke(Part::Joint)) stroke-width=(width(Part::Joint)) {}
            @if !marked(Part::Joint) { text x="290" y="115" text-anchor="middle" fill=(INK) { "joint" } }
            // The gauges of both muscles.
            @for (y, from, to) in [(24, 37, 49), (196, 183, 171)] {
                path d=(format!("M112 {from}V{to}")) stroke=(LINE) {}
                circle cx="112" cy=(y) r="13" fill=(fill(Part::PressureSensors)) stroke=(stroke(Part::PressureSensors))
                    stroke-width=(width(Part::PressureSensors)) {}
                text x="112" y=(y + 5) text-anchor="middle" fill=(INK) { "P" }
            }
            path d="M290 152v30" stroke=(LINE) stroke-dasharray="3 3" {}
            rect x="277" y="183" width="26" height="26" rx="4" fill=(fill(Part::PositionSensor)) stroke=(stroke(Part::PositionSensor))
                stroke-width=(width(Part::PositionSensor)) {}
            text x="290" y="201" text-anchor="middle" fill=(INK) { "x" }
            // The drive turns the pulley with the external force.
            path d="M378 110h-40l9-6m-9 6l9 6" stroke=(stroke(Part::Drive)) stroke-width=(width(Part::Drive)) {}
            text x="360" y="100" text-anchor="middle" fill=(INK) { "force" }
            rect x="380" y="78" width="88" height="64" rx="8" fill=(fill(Part::Drive)) stroke=(stroke(Part::Drive)) stroke-width=(width(Part::Drive)) {}
            text x="424" y="115" text-anchor="middle" fill=(INK) { "drive" }
            @for (k, (part, _)) in acts.iter().enumerate() {
                // Several badges of a part stand side by side about its middle.
                @let before = acts[..k].iter().filter(|(p, _)| p == part).count();
                @let all = acts.iter().filter(|(p, _)| p == part).count();
                @let (x, y) = part.badge();
                @let x = x + 26 * before - 13 * (all - 1);
                circle cx=(x) cy=(y) r="12" fill=(BADGE) {}
                text x=(x) y=(y + 5) text-anchor="middle" font-weight="bold" fill="var(--paper, #ffffff)" { (k + 1) }
            }
        }
    }
}
