//! The frame of a report: one HTML file that needs nothing else.

use maud::{DOCTYPE, Markup, PreEscaped, html};

const STYLE: &str = "
:root { color-scheme: light; }
body { font: 16px/1.55 system-ui, sans-serif; color: #222; background: #fff; margin: 0 auto;
  max-width: 1080px; padding: 1.5rem 1.2rem 4rem; }
h1 { font-size: 1.7rem; margin: 0 0 .3rem; overflow-wrap: anywhere; } h2 { font-size: 1.25rem; margin: 2.2rem 0 .6rem;
  border-bottom: 1px solid #ddd; padding-bottom: .2rem; } h3 { font-size: 1.05rem; margin: 1.6rem 0 .4rem; }
.sub { color: #555; margin: 0 0 1.2rem; } .note { background: #f5f6f8; border-left: 4px solid #0072b2;
  padding: .6rem .9rem; margin: .8rem 0; } .warn { border-left-color: #d55e00; }
.scroll { overflow-x: auto; } table { border-collapse: collapse; font-size: .87rem; margin: .6rem 0; }
th, td { padding: .28rem .5rem; text-align: right; border-bottom: 1px solid #e6e6e6; white-space: nowrap; }
th { border-bottom: 2px solid #bbb; font-weight: 600; } th:first-child, td:first-child { text-align: left; }
td.text, th.text { text-align: left; } td.wrap { white-space: normal; min-width: 8rem; }
th.empty { border: 0; } th.group { text-align: center; border-bottom: 1px solid #bbb; }
tr.mean td { font-weight: 600; background: #f5f6f8; }
.cards { display: flex; flex-wrap: wrap; gap: .8rem; margin: 1rem 0; } .card { border: 1px solid #ddd;
  border-radius: 8px; padding: .6rem 1rem; min-width: 7.5rem; } .card b { display: block; font-size: 1.45rem; }
.card span { color: #555; font-size: .85rem; }
.grid { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 430px), 1fr)); gap: .8rem; }
.three { grid-template-columns: repeat(auto-fit, minmax(min(100%, 320px), 1fr)); }
figure { margin: .6rem 0; } figure svg { width: 100%; height: auto; display: block; }
figure.wide { overflow-x: auto; } figure.wide svg { min-width: 640px; }
figcaption { color: #555; font-size: .88rem; } code { background: #f2f2f2; padding: .05rem .3rem; }
pre { white-space: pre-wrap; overflow-wrap: anywhere; font-size: .85rem; }
/* A shadow at an edge says that there is more behind it. */
.scroll { background: linear-gradient(to right, #fff 40%, transparent) left / 2rem 100% no-repeat local,
  linear-gradient(to left, #fff 40%, transparent) right / 2rem 100% no-repeat local,
  linear-gradient(to right, #0003, transparent) left / .7rem 100% no-repeat,
  linear-gradient(to left, #0003, transparent) right / .7rem 100% no-repeat; }
details > summary { cursor: pointer; font-weight: 600; margin: .6rem 0; } footer { color: #777;
  font-size: .85rem; margin-top: 3rem; border-top: 1px solid #ddd; padding-top: .6rem; }
/* On a phone figures keep readable labels and scroll sideways, tables keep their first column in sight; cards
   stand two abreast. */
@media (max-width: 600px) { body { padding: 1rem .8rem 3rem; } h1 { font-size: 1.4rem; }
  .cards { display: grid; grid-template-columns: 1fr 1fr; gap: .5rem; } .card { min-width: 0; padding: .4rem .7rem;
  overflow-wrap: anywhere; } .card b { font-size: 1.2rem; }
  .scroll td:first-child, .scroll th:first-child { position: sticky; left: 0; background: #fff;
  white-space: normal; min-width: 6rem; max-width: 9.5rem; overflow-wrap: break-word; }
  figure { overflow-x: auto; } figure svg { width: auto; min-width: 440px; max-width: none; }
  .three figure svg { width: 100%; min-width: 0; } }
";

/// A whole report.
#[must_use]
pub fn page(title: &str, subtitle: &str, body: &Markup, footer: &str) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { (title) }
                p.sub { (subtitle) }
                (body)
                footer { (footer) }
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

/// A wide figure: on a narrow screen it keeps a readable size and scrolls sideways.
#[must_use]
pub fn wide_figure(svg: String, caption: &str) -> Markup {
    html! {
        figure.wide {
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

/// A number to `digits` decimals, or a dash if it is undefined.
#[must_use]
pub fn number(value: f64, digits: usize) -> String {
    if value.is_finite() { format!("{value:.digits$}") } else { "–".into() }
}
