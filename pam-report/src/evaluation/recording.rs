//! The figures of one recording.

use crate::figure::{LineFigure, Role, envelope, thin};
use crate::page::{figure, number};
use maud::{Markup, html};
use pam_core::units::MN_PER_N;
use pam_data::Channel;
use pam_train::RecordingEvaluation;
use pam_train::evaluation::SegmentScores;

const BUCKETS: usize = 700;
const LOOP_POINTS: usize = 2500;

pub(super) fn section(r: &RecordingEvaluation, index: usize) -> Markup {
    let rec = &r.recording;
    html! {
        p { "From " code { (rec.source.display()) } ": " (r.samples) " samples over "
            (number(rec.span_s().1 - rec.span_s().0, 2)) " s; " (rec.preprocessing) ". Masses "
            (number(r.masses.flexor_g, 5)) " g and " (number(r.masses.extensor_g, 5)) " g ("
            (r.origin.label()) ")." }
        @for note in &rec.notes { div.note { (note) } }
        @if r.samples > rec.len() {
            p.sub { "The figures show one of " (r.samples.div_ceil(rec.len())) " samples." }
        }
        (segment_table(&r.segments))
        details open[index < 4] {
            summary { "Time series" }
            @for c in Channel::ALL { (time_series(r, c)) }
            (residual_series(r))
        }
        details open[index < 4] {
            summary { "Loops by frequency" }
            @for s in &r.segments { (loops(r, s)) }
        }
        details open[index < 4] {
            summary { "The force that the model lacks" }
            (missing_force(r))
        }
    }
}

fn segment_table(segments: &[SegmentScores]) -> Markup {
    html! {
        div.scroll { table {
            tr {
                th { "excitation" }
                @for c in Channel::ALL { th { "R² " (c.key()) } }
                @for c in Channel::ALL { th { "RMSE " (c.key()) " (" (c.unit()) ")" } }
                th { "work a cycle (mJ)" } th { "predicted (mJ)" }
            }
            @for s in segments {
                tr {
                    td { (s.segment.label()) }
                    @for c in Channel::ALL { td { (number(s.scores.r2.get(c), 4)) } }
                    @for c in Channel::ALL { td { (number(s.scores.rmse.get(c), 4)) } }
                    td { (number(s.loop_work_measured_mj.unwrap_or(f64::NAN), 1)) }
                    td { (number(s.loop_work_predicted_mj.unwrap_or(f64::NAN), 1)) }
                }
            }
        } }
    }
}

fn time_series(r: &RecordingEvaluation, c: Channel) -> Markup {
    let t = &r.recording.time_s;
    let plot = LineFigure::new("", "time (s)", c.label(), 1040, 230)
        .with("measured", Role::Measured, envelope(t, r.recording.channel(c), BUCKETS))
        .with("predicted", Role::Predicted, envelope(t, r.prediction.channels.channel(c), BUCKETS));
    figure(plot.to_svg(), "")
}

fn residual_series(r: &RecordingEvaluation) -> Markup {
    let difference: Vec<f64> = r
        .recording
        .displacement_mm
        .iter()
        .zip(&r.prediction.channels.x)
        .map(|(m, p)| m - p)
        .collect();
    let points = envelope(&r.recording.time_s, &difference, BUCKETS);
    let plot = LineFigure::new("", "time (s)", "error of x (mm)", 1040, 190).with(
        "",
        Role::Residual,
        points,
    );
    figure(plot.to_svg(), "Measured minus predicted displacement.")
}

fn loops(r: &RecordingEvaluation, s: &SegmentScores) -> Markup {
    let range = s.segment.range.clone();
    let force: Vec<f64> =
        r.recording.force_mn[range.clone()].iter().map(|f| f / MN_PER_N).collect();
    let label = s.segment.label();
    let of = |values: &[f64]| values[range.clone()].to_vec();
    // Force is the cause: it stands on the vertical axis of the mechanical loop, where the slope is
    // the stiffness, and on the horizontal axis of the pressure loops.
    let x_loop = {
        let points = |x: &[f64]| thin(&of(x), &force, LOOP_POINTS);
        LineFigure::new("", Channel::X.label(), "external force (N)", 370, 310)
            .with("measured", Role::Measured, points(&r.recording.displacement_mm))
            .with("predicted", Role::Predicted, points(&r.prediction.channels.x))
    };
    let pressure_loop = |c: Channel| {
        let points = |p: &[f64]| thin(&force, &of(p), LOOP_POINTS);
        LineFigure::new("", "external force (N)", c.label(), 370, 310)
            .with("measured", Role::Measured, points(r.recording.channel(c)))
            .with("predicted", Role::Predicted, points(r.prediction.channels.channel(c)))
    };
    let area = "x–F: the area of the loop is the work that the joint dissipates.";
    html! {
        h3 { "Excitation at " (label) }
        div class="grid three" {
            (figure(x_loop.to_svg(), area))
            (figure(pressure_loop(Channel::Pf).to_svg(), "P–F, flexor"))
            (figure(pressure_loop(Channel::Pe).to_svg(), "P–F, extensor"))
        }
    }
}

fn missing_force(r: &RecordingEvaluation) -> Markup {
    let rec = &r.recording;
    let over_time = LineFigure::new("", "time (s)", "missing force (N)", 1040, 230).with(
        "",
        Role::Residual,
        envelope(&rec.time_s, &r.balance.missing_n, BUCKETS),
    );
    let over_velocity = LineFigure::new(
        "Missing force over velocity",
        "velocity v (mm/s)",
        "missing force (N)",
        500,
        380,
    )
    .with("", Role::Residual, thin(&rec.velocity_mm_s, &r.balance.missing_n, LOOP_POINTS));
    let over_position = LineFigure::new(
        "Missing force over position",
        "displacement x (mm)",
        "missing force (N)",
        500,
        380,
    )
    .with("", Role::Residual, thin(&rec.displacement_mm, &r.balance.missing_n, LOOP_POINTS));
    html! {
        p { "The measured motion, put into the model's equation of motion, leaves "
            "F_e − f(x, v) − B v − m a. It opposes the motion where it has the velocity's sign." }
        (figure(over_time.to_svg(), ""))
        div.grid {
            (figure(over_velocity.to_svg(), ""))
            (figure(over_position.to_svg(), ""))
        }
    }
}
