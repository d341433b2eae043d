//! Sign and unit of the force, and which of muscles, displacement and force is reversed.

use super::balance::Balance;
use super::choice::{ChosenReading, direction};
use super::finding::{Evidence, Finding, FindingKind, Severity};
use super::sample::Sample;
use super::weigh::Weights;
use crate::rig_file::units::{self, Quantity};
use pam_core::ForceModel;
use pam_core::units::MN_PER_N;

/// Correlation of recorded and modelled force from which its sign counts.
const CLEAR_CORRELATION: f64 = 0.6;
/// Share of inertia in the modelled force above which a wrong mass could turn its sign.
const MOSTLY_INERTIA: f64 = 0.6;
/// Largest log distance to a unit of force.
const NEAR: f64 = 0.5;

/// Largest log distance between units that the ratio of forces cannot distinguish: N·m at a pulley and amperes of a geared
/// motor.
const ALIKE: f64 = 0.15;

/// Findings from the balance of forces of one recording.
pub(super) struct ForceFindings {
    /// Wrong signs and swapped columns.
    pub(super) directions: Vec<Finding>,
    /// Present if recorded and modelled force differ by a large factor; true if a saturated actuator explains it.
    pub(super) off: Option<(Finding, bool)>,
}

/// Wrong units of the force. There are none if the actuator saturates in most of the recordings whose force is off by a large factor:
/// recordings share an actuator.
pub(super) fn units(off: Vec<(Finding, bool)>) -> impl Iterator<Item = Finding> {
    let saturated = off.iter().filter(|(_, saturates)| *saturates).count();
    let most = 2 * saturated > off.len();
    off.into_iter().filter(move |(_, saturates)| !most && !saturates).map(|(finding, _)| finding)
}

/// Findings in the force and in the directions.
pub(super) fn findings<F: ForceModel<f64>>(
    weights: &Weights<'_, F>,
    sample: &Sample<'_>,
    chosen: &ChosenReading,
) -> ForceFindings {
    let balance = Balance::new(weights, sample, chosen.reading);
    let clear = balance.as_ref().filter(|b| {
        b.inertia_share() < MOSTLY_INERTIA && b.correlation().abs() >= CLEAR_CORRELATION
    });
    let sign = clear.map(|b| b.correlation().signum());
    let mut evidence = Vec::new();
    if let Some(b) = clear {
        evidence.push(Evidence::new(
            "correlation of recorded and modelled force",
            b.correlation(),
            1.0,
        ));
    }
    let make = |kind, severity, channel: &str, message: String| Finding {
        kind,
        severity,
        channel: channel.to_owned(),
        recordings: vec![sample.name()],
        message,
        evidence: evidence.clone(),
    };
    let mut out = Vec::new();
    match (direction(weights, chosen).filter(|_| chosen.reading.reversed), sign) {
        (Some(severity), Some(-1.0)) => out.push(make(
            FindingKind::DisplacementSign,
            severity,
            "displacement_mm, velocity_mm_s",
            "the sign of the displacement is wrong: P_f falls and P_e rises where x falls, and a force along +x moves the \
             joint towards −x. x is positive where the flexor is shorter and its air has expanded; change the sign of \
             displacement_mm and velocity_mm_s"
                .into(),
        )),
        (Some(severity), known) => out.push(make(
            FindingKind::SwappedMuscles,
            severity,
            "pressure_flexor_kpa, pressure_extensor_kpa",
            format!(
                "flexor and extensor look swapped: P_f rises and P_e falls as x rises, while the flexor's volume grows with \
                 x in the model; swap the two pressures (and the two masses, if the file gives them){}",
                if known.is_some() {
                    ", or change the signs of displacement, velocity and force together"
                } else {
                    ", or change the signs of displacement and velocity"
                }
            ),
        )),
        (None, Some(-1.0)) => out.push(make(
            FindingKind::ForceSign,
            Severity::Error,
            "force_n",
            "the sign of the force is wrong: it pulls the joint against its motion at rest and in motion, while a joint \
             yields to a force; positive is along +x. Change the sign of force_n"
                .into(),
        )),
        _ => {}
    }
    ForceFindings { directions: out, off: clear.and_then(|b| unit(weights, sample, b)) }
}

/// A finding if recorded and modelled force differ by a large factor; true if a saturated actuator explains it.
fn unit<F: ForceModel<f64>>(
    weights: &Weights<'_, F>,
    sample: &Sample<'_>,
    balance: &Balance,
) -> Option<(Finding, bool)> {
    let ratio = balance.ratio();
    let least = weights.settings.force_factor.ln();
    if !ratio.is_finite() || ratio.ln().abs() < least {
        return None;
    }
    let distance = |newtons: f64| (ratio * newtons).ln().abs();
    let units: Vec<(&str, f64)> = units::mistaken(Quantity::Force)
        .into_iter()
        .map(|(unit, mn)| (unit, mn / MN_PER_N))
        .collect();
    let nearest = units.iter().min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)))?;
    let fits = distance(nearest.1) < NEAR;
    let alike = || units.iter().filter(|u| (u.1 / nearest.1).ln().abs() < ALIKE);
    let names = alike().map(|u| u.0).collect::<Vec<_>>().join(" or ");
    let factors = alike().map(|u| format!("{:.5}", u.1)).collect::<Vec<_>>().join(" or ");
    let what = format!(
        "the force is {ratio:.4} times what mass, acceleration and the model's restoring force ask for"
    );
    let message = if fits {
        format!("{what}: it looks like {names} where N are meant; multiply force_n by {factors}")
    } else {
        format!(
            "{what}; check its unit (N at the tendon), the unit of the displacement, and that the model is of this joint"
        )
    };
    let finding = Finding {
        kind: FindingKind::ForceUnit,
        severity: if fits { Severity::Error } else { Severity::Warning },
        channel: "force_n".into(),
        recordings: vec![sample.name()],
        message,
        evidence: vec![
            Evidence::new("recorded over modelled force", ratio, 1.0),
            Evidence::new("correlation of recorded and modelled force", balance.correlation(), 1.0),
        ],
    };
    Some((finding, ratio > 1.0 && balance.saturates()))
}
