//! Where the named causes act on the joint.

use super::headline::capitalised;
use crate::verdict::Cause;
use maud::{Markup, html};
use pam_vocabulary::{Group, by_id, plain_name};

/// The parts of the figure, from the command to the recording.
const PARTS: [&str; 4] = ["actuation", "joint", "air", "sensors"];
/// Size of a box and of the gap between two, px.
const BOX: (usize, usize, usize) = (220, 64, 40);

/// The part on which an effect of the vocabulary acts.
fn part(id: &str) -> Option<usize> {
    let info = by_id(id).ok()?;
    Some(match info.group {
        Group::Mechanics => 1,
        Group::Gas => 2,
        Group::Sensing if id.starts_with("pressure") || id.starts_with("position") => 3,
        Group::Sensing => 0,
    })
}

/// A row of boxes with the causes in the parts where they act; nothing for causes outside the vocabulary.
pub(super) fn figure(causes: &[Cause]) -> Markup {
    let acts: Vec<(usize, String)> =
        causes.iter().filter_map(|c| Some((part(&c.effect)?, plain_name(&c.effect)))).collect();
    if acts.is_empty() {
        return html! {};
    }
    let (width, height, gap) = BOX;
    let total = PARTS.len() * width + (PARTS.len() - 1) * gap;
    html! {
        figure {
            svg xmlns="http://www.w3.org/2000/svg" viewBox=(format!("0 0 {total} {height}")) width=(total) role="img"
                style="max-width: 100%; height: auto; font: 14px sans-serif" {
                title { "Where the causes act" }
                @for (k, name) in PARTS.iter().enumerate() {
                    @let x = k * (width + gap);
                    @let here: Vec<&str> = acts.iter().filter(|(p, _)| *p == k).map(|(_, n)| n.as_str()).collect();
                    rect x=(x + 1) y="1" width=(width - 2) height=(height - 2) rx="6" stroke="#888888"
                        fill=(if here.is_empty() { "#f1f4f8" } else { "#ffd9c2" }) {}
                    text x=(x + width / 2) y="24" text-anchor="middle" fill="#222222" { (capitalised(name)) }
                    text x=(x + width / 2) y="48" text-anchor="middle" fill="#a03c00" font-weight="bold" { (here.join(", ")) }
                    @if k + 1 < PARTS.len() {
                        path d=(format!("M{} {}h{}l-8 -5m8 5l-8 5", x + width + 4, height / 2, gap - 8)) fill="none" stroke="#888888" {}
                    }
                }
            }
            figcaption { "Where the named causes act, from the command to the recording." }
        }
    }
}
