use crate::experiments::comparison::{ComparisonRow, PUBLISHED};
use crate::experiments::stiffness::Identified;
use maud::{Markup, html};
use pam_report::figure::{LineFigure, Role, Stroke};
use pam_report::page::{figure, number, page};

/// Content of the report.
#[derive(Debug, Clone, Default)]
pub struct IdentificationReport {
    /// Title of the page.
    pub title: String,
    /// One sentence on the experiment.
    pub lead: String,
    /// Program and version.
    pub made_by: String,
    /// Perturbations with their estimates.
    pub pulses: Vec<Identified>,
    /// The same pulses on the model itself, or none.
    pub on_model: Vec<Identified>,
    /// Tables of the comparison with the names of their models.
    pub tables: Vec<(String, Vec<ComparisonRow>)>,
}

/// Identified and commanded stiffness, responses, and the table of the comparison.
#[must_use]
pub fn identification_report(report: &IdentificationReport) -> String {
    let mut sorted: Vec<&Identified> = report.pulses.iter().collect();
    sorted.sort_by(|a, b| a.record.commanded_n_mm.total_cmp(&b.record.commanded_n_mm));
    let along = |direction: f64| {
        sorted
            .iter()
            .filter(move |i| i.record.pulse.direction * direction > 0.0)
            .map(|i| (i.record.commanded_n_mm, i.estimate.stiffness_n_mm))
    };
    let diagonal: Vec<(f64, f64)> =
        sorted.iter().map(|i| (i.record.commanded_n_mm, i.record.commanded_n_mm)).collect();
    let mut scatter = LineFigure::new("", "commanded (N/mm)", "identified (N/mm)", 500, 360)
        .with("mean, push along +x", Role::Category(0), means(along(1.0)))
        .with("mean, push against x", Role::Category(1), means(along(-1.0)))
        .with_stroke("commanded", Role::Neutral, Stroke::Dashed, diagonal);
    for (direction, role) in [(1.0, Role::Category(0)), (-1.0, Role::Category(1))] {
        for point in along(direction) {
            scatter = scatter.with("", role, vec![point]);
        }
    }
    if !report.on_model.is_empty() {
        let mut twins: Vec<(f64, f64)> = report
            .on_model
            .iter()
            .map(|i| (i.record.commanded_n_mm, i.estimate.stiffness_n_mm))
            .collect();
        twins.sort_by(|a, b| a.0.total_cmp(&b.0));
        let twins = means(twins.into_iter());
        scatter = scatter.with("the model itself, mean", Role::Category(2), twins);
    }
    let scatter = scatter.to_svg();
    let caption = if report.on_model.is_empty() {
        "Identified stiffness over the commanded one."
    } else {
        "Identified stiffness over the commanded one. The model's line shows the same pulses on \
         the learned joint: its distance from the dashed line is the pulse's, that of the points from it is the \
         joint's."
    };
    let body = html! {
        @if !report.pulses.is_empty() {
            div.grid {
                (figure(scatter, caption))
                (figure(responses(&sorted), "Responses from their start, sign of the push taken out."))
            }
        }
        @for (k, (name, rows)) in report.tables.iter().enumerate() {
            h2 { (name) }
            (comparison_table(rows, k))
            (explanation(rows, k))
        }
        @if !report.pulses.is_empty() {
            h2 { "Pulses" }
            div.scroll { table {
                tr {
                    th { "time (s)" } th { "place" } th { "push" } th { "commanded (N/mm)" }
                    th { "K (N/mm)" } th { "95 %" } th { "B (kg/s)" } th { "fit (mm)" } th { "peak (mm)" }
                }
                @for i in report.pulses.iter().take(200) {
                    tr {
                        td { (number(i.record.pulse.time_s, 2)) } td { (i.record.pulse.place) }
                        td { (if i.record.pulse.direction > 0.0 { "+" } else { "−" }) }
                        td { (number(i.record.commanded_n_mm, 1)) }
                        td { (number(i.estimate.stiffness_n_mm, 1)) }
                        td { (number(i.estimate.stiffness_interval_n_mm[0], 1)) "–" (number(i.estimate.stiffness_interval_n_mm[1], 1)) }
                        td { (number(i.estimate.damping_kg_s, 0)) }
                        td { (number(i.estimate.rmse_mm, 4)) } td { (number(i.estimate.peak_mm, 3)) }
                    }
                }
            } }
        }
    };
    page(&report.title, &report.lead, &body, &report.made_by)
}

/// The mean of each run of equal commands.
fn means(points: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    let mut groups: Vec<(f64, f64, f64)> = Vec::new();
    for (x, y) in points {
        match groups.last_mut() {
            Some((level, sum, count)) if *level == x => (*sum, *count) = (*sum + y, *count + 1.0),
            _ => groups.push((x, y, 1.0)),
        }
    }
    groups.into_iter().map(|(x, sum, count)| (x, sum / count)).collect()
}

fn responses(sorted: &[&Identified]) -> String {
    let mut plot = LineFigure::new("", "time (ms)", "|x − x0| (mm)", 500, 360);
    let mut last = f64::NAN;
    let mut colour = 0;
    for i in sorted {
        if i.record.commanded_n_mm == last {
            continue;
        }
        last = i.record.commanded_n_mm;
        let from = i.record.displacement_mm[i.record.start];
        let points = i.record.displacement_mm[i.record.start..]
            .iter()
            .enumerate()
            .map(|(k, x)| (k as f64, i.record.pulse.direction * (x - from)))
            .collect();
        plot = plot.with(&format!("{last:.0}"), Role::Category(colour), points);
        colour += 1;
        if colour > 7 {
            break;
        }
    }
    plot.to_svg()
}

fn comparison_table(rows: &[ComparisonRow], model: usize) -> Markup {
    html! {
        div.scroll { table {
            tr {
                th { "nominal" } th { "K at rest" } th { "K at speed" } th { "Δ (%)" } th { "p" } th { "pairs" }
                th { "published: at rest" } th { "at speed" } th { "Δ (%)" } th { "p" }
            }
            @for (row, published) in rows.iter().zip(PUBLISHED[model.min(1)]) {
                tr {
                    td { (row.nominal_n_mm) }
                    td { (number(row.at_rest_n_mm[0], 2)) " ± " (number(row.at_rest_n_mm[1], 2)) }
                    td { (number(row.at_speed_n_mm[0], 2)) " ± " (number(row.at_speed_n_mm[1], 2)) }
                    td { (number(row.delta_percent, 2)) }
                    td { (row.test.map_or("–".into(), |t| format!("{:.2e}", t.p))) }
                    td { (row.pairs.len()) }
                    td { (published[1]) } td { (published[2]) } td { (published[3]) }
                    td { (format!("{:.2e}", published[4])) }
                }
            }
        } }
    }
}

/// Why the stiffness at speed differs from that at rest: the same cycle on the learned joint itself, and the stiffness
/// of the learned force split into place and velocity.
fn explanation(rows: &[ComparisonRow], model: usize) -> Markup {
    let all = || rows.iter().filter_map(|r| Some((r, r.expected?)));
    html! {
        @if all().next().is_some() {
            h3 { "Where the difference comes from (N/mm)" }
            div.scroll { table {
                tr {
                    th { "nominal" } th { "speed − rest" } th { "on the model" }
                    th { "ends → centre" }
                    th { "standing → moving" } th { "published" }
                }
                @for ((row, e), published) in all().zip(PUBLISHED[model.min(1)]) {
                    tr {
                        td { (row.nominal_n_mm) } td { (signed(row.change_n_mm())) }
                        td { (row.on_model_n_mm.map_or("–".into(), |[r, s]| signed(s - r))) }
                        td { (signed(e.centre_n_mm - e.ends_n_mm)) }
                        td { (signed(e.centre_moving_n_mm - e.centre_n_mm)) }
                        td { (signed(published[2] - published[1])) }
                    }
                }
            } }
            p {
                "The joint rests at the ends of the motion and moves at its centre, so rest and speed are also two \
                 places. The third column carries the same cycle out on the learned joint itself, which has no \
                 friction, noise or servo: what is there already lies in the commands and in what a pulse measures \
                 (the slope over its own travel and at its own speed, not that over the ±2h of the planned K̂); what the second column has \
                 beyond it is the joint's difference from the model. The next two split the stiffness of the learned force under \
                 these commands, as slopes over ±0.5 mm, into place and velocity. The published weights, learned from \
                 the published joint, have +0.3 N/mm from the ends to the centre and −4.4 N/mm from standing to \
                 moving: there the motion decides the sign. Where the place weighs more, as here if its column is the \
                 larger one, the sign is the opposite."
            }
        }
    }
}

fn signed(value: f64) -> String {
    format!("{}{}", if value < 0.0 { "−" } else { "+" }, number(value.abs(), 1))
}
