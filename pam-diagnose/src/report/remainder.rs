//! The model of the error that no listed cause explains.

use super::causes::parts;
use super::percent;
use crate::law::{Law, Picture, Plane, PlaneCell};
use crate::remainder::{Correction, Remainder};
use maud::{Markup, html};
use pam_core::units::significant;
use pam_report::figure::{PolygonMap, ValuedPolygon};
use pam_report::page::{figure, number};
use pam_report::{LineFigure, Role, ValuePlane};
use pam_vocabulary::plain_name;

/// Laws of the ranking that are shown.
const SHOWN: usize = 8;

pub(super) fn section(r: &Remainder) -> Markup {
    html! {
        p { (r.sentence) }
        @if let Some(law) = &r.law { (of_law(law)) }
        @if let Some(c) = &r.correction { (of_correction(c, r.law.is_some())) }
        @if !r.ranking.is_empty() {
            h3 { "Laws that were fitted through the simulation" }
            div.scroll { table {
                tr { th.text { "law" } th.text { "beside" } th { "description (nats)" } th { "validation χ²" } th { "log odds" } }
                @for l in r.ranking.iter().take(SHOWN) {
                    tr {
                        td.text.wrap { code { (l.expression) } }
                        td.text { (l.beside.join(", ")) }
                        td { (number(l.description_length, 1)) }
                        td { (number(l.validation, 3)) }
                        td { (number(l.log_odds, 1)) }
                    }
                }
            } }
        }
    }
}

fn of_law(law: &Law) -> Markup {
    let n = |v: f64| significant(v, 4);
    let o = law.error_reduction.overall;
    html! {
        p { code { (law.expression) } }
        @if !law.beside.is_empty() { p { "It stands beside " (law.beside.join(" and ")) "." } }
        div.scroll { table {
            tr { th { "parameter" } th { "value" } th { "95 % interval" } }
            @for (name, i) in &law.parameters {
                tr { td { (name) } td { (n(i.value)) } td { (n(i.ci95[0])) " to " (n(i.ci95[1])) } }
            }
        } }
        p {
            "It depends on " (law.variables.join(", "))
            @if law.remembers { ", with memory" }
            ". On the test set it removes " (percent(o.error_reduction)) " of the error that remains after the named causes ["
            (percent(o.ci95[0])) ", " (percent(o.ci95[1])) "], and " (percent(law.share_of_correction))
            " of the squared error that the smooth correction removes. "
            @if law.is_complete() { "Nothing but noise is left in any channel." }
            @else {
                "An error remains in "
                (law.bands.iter().filter(|b| b.outside).map(|b| b.channel.as_str()).collect::<Vec<_>>().join(", ")) "."
            }
            " " code { "law.toml" } " defines it as an effect."
        }
        @for r in &law.replaces {
            p { "Not " (plain_name(&r.effect)) " (id " code { (r.effect) } "): " (r.reason()) "." }
            @if let Some(k) = r.stability.as_ref().filter(|k| k.parts.len() > 2) {
                (figure(parts(k), &format!(
                    "Fitted alone with one value at all times, {} has this value in each part of each recording.",
                    plain_name(&r.effect)
                )))
            }
        }
    }
}

fn of_correction(c: &Correction, with_law: bool) -> Markup {
    let o = c.error_reduction.overall;
    html! {
        h3 { "The smooth correction" }
        p {
            "It acts as " (c.acts.join(" and ")) ", and removes " (percent(c.validation_share))
            " of the squared error of the validation data (p " (probability(c.p_value)) ") and "
            (percent(o.error_reduction)) " of the error of the test set [" (percent(o.ci95[0])) ", " (percent(o.ci95[1])) "]"
            @if !c.confirmed { ", which does not confirm it" } "."
        }
        @if !c.depends_on.is_empty() {
            div.scroll { table {
                tr { th { "depends on" } th { "error without it, over that with it" } th { "95 % interval" } th { "p" } }
                @for d in &c.depends_on {
                    tr {
                        td { (d.on) } td { (number(d.error_ratio, 2)) }
                        td { (number(d.ci95[0], 2)) " to " (number(d.ci95[1], 2)) }
                        td { (probability(d.p_value).trim_start_matches("= ")) }
                    }
                }
            } }
        }
        @for p in &c.pictures {
            (figure(curve(p), &format!(
                "The correction over {}: mean, and the 10th and 90th percentiles{}. Below: the number of rows.",
                p.variable,
                if with_law { ", with the law" } else { "" }
            )))
            (figure(coverage(p), ""))
            @if let Some(plane) = &p.plane {
                div.grid {
                    (figure(map(p, plane, &|c| Some(c.correction)), "The correction, where there are data."))
                    @if with_law { (figure(map(p, plane, &|c| c.law), "The law, where there are data.")) }
                }
            }
        }
    }
}

/// A p-value to three decimals.
fn probability(p: f64) -> String {
    if p < 5e-4 { "< 0.001".into() } else { format!("= {p:.3}") }
}

fn curve(p: &Picture) -> String {
    let line = |f: &dyn Fn(&crate::law::PicturePoint) -> Option<f64>| -> Vec<(f64, f64)> {
        p.points.iter().filter_map(|q| Some((q.at, f(q)?))).collect()
    };
    let mut plot = LineFigure::new("", &p.variable, &p.value, 1040, 300)
        .with("correction", Role::Residual, line(&|q| Some(q.correction)))
        .with("10 %", Role::Neutral, line(&|q| Some(q.range[0])))
        .with("90 %", Role::Neutral, line(&|q| Some(q.range[1])));
    let law = line(&|q| q.law);
    if !law.is_empty() {
        plot = plot.with("law", Role::Category(1), law);
    }
    plot.to_svg()
}

fn coverage(p: &Picture) -> String {
    let rows = p.points.iter().map(|q| (q.at, q.rows as f64)).collect();
    LineFigure::new("", &p.variable, "rows", 1040, 120)
        .with_marks()
        .with("", Role::Neutral, rows)
        .covering([0.0])
        .to_svg()
}

fn map(p: &Picture, plane: &Plane, value: &dyn Fn(&PlaneCell) -> Option<f64>) -> String {
    let largest = plane
        .cells
        .iter()
        .flat_map(|c| [Some(c.correction), c.law])
        .flatten()
        .fold(0.0_f64, |m, v| m.max(v.abs()));
    let window = |k: usize| {
        let ends = |sign: f64| plane.cells.iter().map(move |c| c.at[k] + sign * 0.5 * c.width[k]);
        [ends(-1.0).fold(f64::INFINITY, f64::min), ends(1.0).fold(f64::NEG_INFINITY, f64::max)]
    };
    let polygon = |c: &PlaneCell| {
        let [x, y] = c.at;
        let [dx, dy] = c.width.map(|w| 0.5 * w);
        let corners = vec![[x - dx, y - dy], [x + dx, y - dy], [x + dx, y + dy], [x - dx, y + dy]];
        Some(ValuedPolygon { corners, value: value(c)? })
    };
    PolygonMap {
        plane: ValuePlane {
            title: String::new(),
            x_label: p.variable.clone(),
            y_label: plane.other.clone(),
            value_label: p.value.clone(),
            limits: (-largest, largest),
            size: (510, 330),
        },
        polygons: plane.cells.iter().filter_map(polygon).collect(),
        window: [window(0), window(1)],
    }
    .to_svg()
}
