//! The frame of a report: one HTML file that needs nothing else.
//!
//! A page follows the reader's light or dark setting, fits phones and paper, and has figures that a reader can magnify. Its
//! style and its script are part of the file, and its content security policy forbids to load anything from elsewhere.

use crate::figure::PALETTE;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use std::fmt::Write as _;

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("zoom.js");
const POLICY: &str =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

/// The colours of figures as variables, on light and on dark ground.
fn figure_colours() -> String {
    let (mut light, mut dark, mut rules) = (String::new(), String::new(), String::new());
    for c in PALETTE {
        let name = c.name;
        write!(light, "--{name}:{};", c.light).expect("writing to a string cannot fail");
        write!(dark, "--{name}:{};", c.dark).expect("writing to a string cannot fail");
        writeln!(rules, "svg .{name} {{ color: var(--{name}); }}")
            .expect("writing to a string cannot fail");
    }
    format!(
        ":root {{ {light} }}\n@media screen and (prefers-color-scheme: dark) {{ :root {{ {dark} }} }}\n{rules}"
    )
}

/// A whole report.
///
/// ```
/// use maud::html;
/// use pam_report::page::{card, page};
///
/// let body = html! { div.cards { (card("0.07 mm", "RMSE of the displacement")) } };
/// let html = page("The error fell by 71 %", "Model default.", &body, "my program 1.0");
/// assert!(html.starts_with("<!DOCTYPE html>") && html.contains("0.07 mm"));
/// ```
#[must_use]
pub fn page(title: &str, subtitle: &str, body: &Markup, footer: &str) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                title { (title) }
                style { (PreEscaped(STYLE)) (PreEscaped(figure_colours())) }
            }
            body {
                h1 { (title) }
                p.sub { (subtitle) }
                p.hint hidden {
                    "Figures can be magnified: select one, then scroll, pinch or press + and −; drag to move; double-click or "
                    "press Esc to reset. Shift keeps the vertical axis, Alt the horizontal one."
                }
                (body)
                footer { (footer) }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
    .into_string()
}

/// A figure with its caption; `svg` is trusted text of this crate's figures.
#[must_use]
pub fn figure(svg: String, caption: &str) -> Markup {
    html! {
        figure {
            (PreEscaped(svg))
            @if !caption.is_empty() { figcaption { (caption) } }
        }
    }
}

/// A number with its name.
#[must_use]
pub fn card(value: &str, name: &str) -> Markup {
    html! { div.card { b { (value) } span { (name) } } }
}

/// A paragraph of text.
#[must_use]
pub fn paragraph(text: &str) -> Markup {
    html! { p { (text) } }
}

/// A number to `digits` decimals, or a dash if it is undefined. What rounds to zero has no sign.
///
/// ```
/// use pam_report::page::number;
/// assert_eq!((number(-0.36, 1), number(-0.04, 1)), ("−0.4".into(), "0.0".into()));
/// ```
#[must_use]
pub fn number(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    let text = format!("{value:.digits$}");
    let is_zero = !text.contains(|c: char| matches!(c, '1'..='9'));
    text.replace('-', if is_zero { "" } else { "−" })
}

/// A count with its noun: "1 recording", "2 recordings".
#[must_use]
pub fn count(n: usize, noun: &str) -> String {
    if n == 1 { format!("1 {noun}") } else { format!("{n} {noun}s") }
}
