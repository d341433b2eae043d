//! Time and velocity.

use super::blocks::{Regression, without_drift};
use super::finding::{Evidence, Finding, FindingKind, Severity};
use super::sample::{Sample, moves};
use super::settings::PlausibilitySettings;
use super::weigh::Reading;
use crate::recording::median_step_s;
use crate::rig_file::units::{self, Quantity};

/// Possible units of a velocity column, with the factor to mm/s: units, and seconds beside a time in ms.
fn candidates() -> impl Iterator<Item = (&'static str, f64)> {
    units::mistaken(Quantity::Velocity).into_iter().chain([("mm/s, with time_s in ms", 1e-3)])
}

/// Largest log distance to one of the [`candidates`].
const NEAR: f64 = 0.3;

/// Findings in time and velocity.
pub(super) fn findings(
    sample: &Sample<'_>,
    reading: Reading,
    s: &PlausibilitySettings,
) -> Vec<Finding> {
    time(sample, s).into_iter().chain(velocity(sample, reading, s)).collect()
}

fn time(sample: &Sample<'_>, s: &PlausibilitySettings) -> Option<Finding> {
    let step = median_step_s(&sample.recording.time_s);
    if step < s.shortest_step_s {
        let message = format!(
            "time_s advances by {step:e} s per sample, which is {:.0} Hz: its unit is larger than it was read as",
            1.0 / step
        );
        return Some(Finding {
            kind: FindingKind::TimeUnit,
            severity: Severity::Error,
            channel: "time_s".into(),
            recordings: vec![sample.name()],
            message,
            evidence: vec![Evidence::new("sampling step (s)", step, s.shortest_step_s)],
        });
    }
    if sample.time_scale == 1.0 && step <= s.longest_step_s {
        return None;
    }
    let unit = match sample.time_scale {
        1e-3 => "ms",
        1e-6 => "µs",
        1e-9 => "ns",
        _ => "a longer unit",
    };
    let message = format!(
        "time_s advances by {step} per sample, which would be {:.4} Hz: the time looks like {unit} where seconds are meant; \
         multiply time_s by {:e}",
        1.0 / step,
        sample.time_scale
    );
    Some(Finding {
        kind: FindingKind::TimeUnit,
        severity: Severity::Error,
        channel: "time_s".into(),
        recordings: vec![sample.name()],
        message,
        evidence: vec![Evidence::new("sampling step (s)", step, step * sample.time_scale)],
    })
}

/// `x(t) − x(0) = ∫ ẋ dt`, up to a slow drift.
fn velocity(sample: &Sample<'_>, reading: Reading, s: &PlausibilitySettings) -> Option<Finding> {
    let blocks = sample.blocks.as_ref().filter(|b| moves(b))?;
    let make = |kind, severity, message: String, evidence| Finding {
        kind,
        severity,
        channel: "velocity_mm_s".into(),
        recordings: vec![sample.name()],
        message,
        evidence,
    };
    const REMEDY: &str = "correct the column, or use --preprocess, which takes the velocity anew from the displacement";
    if sample.recording.velocity_mm_s.iter().all(|v| *v == 0.0) {
        let message =
            format!("the velocity is zero throughout while the displacement changes; {REMEDY}");
        let evidence = vec![Evidence::new(
            "change of x over the integral of the velocity",
            f64::INFINITY,
            1.0,
        )];
        return Some(make(FindingKind::VelocityMissing, Severity::Error, message, evidence));
    }
    let x: Vec<f64> = without_drift(&blocks.x).iter().map(|x| x * reading.mm()).collect();
    let travel: Vec<f64> =
        without_drift(&blocks.travel).iter().map(|t| t * sample.time_scale).collect();
    let fit = Regression::new(&x, &[&travel])?;
    // Noise in either shrinks the slope by its share of R.
    let factor = fit.coefficients[0] / fit.r2.sqrt().max(1e-6);
    let mut evidence = vec![
        Evidence::new("change of x over the integral of the velocity", factor, 1.0),
        Evidence::new("R² of x and the integral of the velocity", fit.r2, 1.0),
    ];
    if fit.r2 < 0.5 * s.least_r2 {
        let message = format!(
            "the velocity is not the derivative of the displacement: its integral explains {:.0} % of x; {REMEDY}",
            100.0 * fit.r2
        );
        return Some(make(FindingKind::Velocity, Severity::Warning, message, evidence));
    }
    // A velocity in the displacement's unit per second is reported with the displacement.
    let sound = |factor: f64| factor > 0.0 && factor.ln().abs() < s.velocity_factor.ln();
    if sound(factor) || sound(factor / reading.mm()) {
        return None;
    }
    let severity = if fit.r2 >= s.least_r2 { Severity::Error } else { Severity::Warning };
    let near = |u: &(&str, f64)| (factor.abs() / u.1).ln().abs() < NEAR;
    let cause = match candidates().find(near) {
        Some((unit, _)) if factor > 0.0 => format!("it looks like {unit}"),
        Some((unit, _)) => format!("it looks like {unit} with the wrong sign"),
        None if factor.abs().ln().abs() < NEAR => "its sign is wrong".to_owned(),
        None => "its unit or its filter is another one".to_owned(),
    };
    evidence.push(Evidence::new("sampling step (s)", blocks.step, blocks.step));
    let message = format!(
        "the displacement changes {factor:.4} times as much as the integral of the velocity: {cause}; {REMEDY}"
    );
    Some(make(FindingKind::Velocity, severity, message, evidence))
}
