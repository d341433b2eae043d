//! Findings in the columns of pressure and displacement, and in given masses.

use super::blocks::squares;
use super::choice::{ChosenReading, severity};
use super::finding::{Evidence, Finding, FindingKind, Severity};
use super::gas::{expected_slopes, response};
use super::readings::DISPLACEMENT_UNITS;
use super::sample::{Sample, moves};
use super::weigh::{Reading, Weights};
use pam_core::ForceModel;
use pam_numerics::statistics::median;

/// Names of the pressure columns.
pub(super) const PRESSURES: [&str; 2] = ["pressure_flexor_kpa", "pressure_extensor_kpa"];
/// Both of them.
const BOTH: &str = "pressure_flexor_kpa, pressure_extensor_kpa";

/// Response of a pressure to the motion, relative to the gas law, below which the sensor counts as dead. A low-pass of
/// 0.05 Hz, the slowest of the vocabulary, leaves 0.1 at the slowest published motion.
const DEAD_RESPONSE: f64 = 0.05;
/// Change of pressure that the motion must cause before a silent sensor says anything, kPa.
const TELLING_CHANGE_KPA: f64 = 1.0;
/// R² above which both pressures follow the motion without doubt.
const CLEAR_R2: f64 = 0.9;
/// Largest difference of the chambers' log ratios that a wrong geometry, which both share, may show.
const COMMON_RATIO: f64 = 0.25;

/// Findings in pressures and displacement. Directions are left to the force, which tells muscles from displacement.
pub(super) fn findings<F: ForceModel<f64>>(
    weights: &Weights<'_, F>,
    sample: &Sample<'_>,
    chosen: &ChosenReading,
) -> Vec<Finding> {
    let mut out = Vec::new();
    let reading = chosen.reading;
    out.extend(severity(weights, chosen.odds[0]).map(|s| pressure(weights, sample, reading, s)));
    out.extend(
        severity(weights, chosen.odds[1]).map(|s| displacement(weights, sample, reading, s)),
    );
    let silent = silent(weights, sample, reading);
    if silent.is_empty() {
        out.extend(same_sign(weights, sample, reading));
        out.extend(impossible(weights, sample, reading));
    }
    out.extend(silent);
    out
}

/// The log ratios of measured over isothermal change of pressure of flexor and extensor, if both follow the motion.
fn both_ratios<F: ForceModel<f64>>(
    weights: &Weights<'_, F>,
    sample: &Sample<'_>,
    reading: Reading,
) -> Option<[f64; 2]> {
    let (ratios, wrong) = weights.log_ratios(&[sample], reading);
    let [[flexor, _], [extensor, _]] = ratios[..] else { return None };
    (wrong == 0).then_some([flexor, extensor])
}

/// Findings in the geometry of the model. All recordings are of the same muscles, so a deviation in no more than half of them has another
/// cause and is a warning: backlash in the displacement measurement hides most of a small motion.
pub(super) fn geometries<F: ForceModel<f64>>(
    weights: &Weights<'_, F>,
    samples: &[Sample<'_>],
    readings: &[ChosenReading],
) -> Vec<Finding> {
    let both = samples.iter().zip(readings);
    let ratios = both.filter_map(|(s, r)| Some((s, both_ratios(weights, s, r.reading)?)));
    let judged: Vec<Option<Finding>> =
        ratios.map(|(sample, ratios)| geometry(weights, sample, ratios)).collect();
    let count = judged.len();
    let mut off: Vec<Finding> = judged.into_iter().flatten().collect();
    let fitting = count - off.len();
    if fitting >= off.len() {
        for finding in &mut off {
            finding.severity = Severity::Warning;
            finding.message.push_str(&format!(
                ". {fitting} of {count} recordings fit the model, so look for what differs in this one: backlash in the displacement \
                 measurement hides most of a small motion"
            ));
        }
    }
    off
}

fn finding(
    kind: FindingKind,
    severity: Severity,
    channel: &str,
    sample: &Sample<'_>,
    message: String,
    evidence: Vec<Evidence>,
) -> Finding {
    Finding {
        kind,
        severity,
        channel: channel.to_owned(),
        recordings: vec![sample.name()],
        message,
        evidence,
    }
}

/// Measured over isothermal change of pressure, geometric mean over the chambers; NaN if there is none.
fn common_ratio<F: ForceModel<f64>>(
    weights: &Weights<'_, F>,
    sample: &Sample<'_>,
    reading: Reading,
) -> f64 {
    let (ratios, _) = weights.log_ratios(&[sample], reading);
    median(&ratios.iter().map(|r| r[0]).collect::<Vec<_>>()).exp()
}

/// The sentence on the gas law before and after a correction.
fn gas_sentence<F: ForceModel<f64>>(
    weights: &Weights<'_, F>,
    sample: &Sample<'_>,
    reading: Reading,
    evidence: &mut Vec<Evidence>,
) -> String {
    let before =
        common_ratio(weights, sample, Reading { reversed: reading.reversed, ..Reading::STATED });
    let after = common_ratio(weights, sample, reading);
    if before.is_finite() && after.is_finite() {
        let what = "change of pressure with displacement over that of the gas law";
        evidence.push(Evidence::new(format!("{what}, as recorded"), before, 1.0));
        evidence.push(Evidence::new(format!("{what}, corrected"), after, 1.0));
        return format!(
            "; with displacement they change {before:.3} times as much as the gas law says as recorded, {after:.3} times \
             when corrected"
        );
    }
    String::new()
}

fn pressure<F: ForceModel<f64>>(
    weights: &Weights<'_, F>,
    sample: &Sample<'_>,
    reading: Reading,
    severity: Severity,
) -> Finding {
    let unit = &weights.units[reading.pressure];
    let [flexor, extensor] = sample.pressures;
    let mut evidence: Vec<Evidence> = PRESSURES
        .iter()
        .zip(sample.pressures)
        .map(|(name, p)| Evidence::new(format!("median of {name} (kPa)"), p, unit.reading.kpa(p)))
        .collect();
    let gas = gas_sentence(weights, sample, reading, &mut evidence);
    let (kind, message) = if unit.is_gauge_kpa() {
        (
            FindingKind::GaugePressure,
            format!(
                "the pressures look like gauge pressures: {flexor:.1} and {extensor:.1} kPa (flexor, extensor) where \
                 absolute ones are meant{gas}; read them as gauge: --pressure gauge, or reference = \"gauge\" in the rig file"
            ),
        )
    } else {
        let what = format!("{} {}", unit.unit, if unit.gauge { "gauge" } else { "absolute" });
        let place = match unit.in_file {
            Some(file) => format!(
                "the file's pressures look like {what} where {} is meant; they read",
                file.describe()
            ),
            None => format!("the pressures look like {what} where kPa absolute is meant: they are"),
        };
        let offset = unit.reading.offset_kpa;
        let remedy = match (unit.in_file, offset != 0.0) {
            (Some(file), _) if file.raw_log() => "convert pm1 and pm2 to psi gauge".to_owned(),
            (Some(_), _) => "correct unit and reference in the rig file".to_owned(),
            (_, true) => {
                format!("multiply both by {} and add {offset} kPa", unit.reading.scale)
            }
            (_, false) => format!("multiply both by {}", unit.reading.scale),
        };
        (
            FindingKind::PressureUnit,
            format!("{place} {flexor:.4} and {extensor:.4} kPa (flexor, extensor){gas}; {remedy}"),
        )
    };
    finding(kind, severity, BOTH, sample, message, evidence)
}

fn displacement<F: ForceModel<f64>>(
    weights: &Weights<'_, F>,
    sample: &Sample<'_>,
    reading: Reading,
    severity: Severity,
) -> Finding {
    let (unit, mm) = DISPLACEMENT_UNITS[reading.displacement];
    let mut evidence =
        vec![Evidence::new("largest displacement (mm)", sample.largest_x, sample.largest_x * mm)];
    let stated = common_ratio(weights, sample, Reading { displacement: 0, ..reading });
    let after = common_ratio(weights, sample, reading);
    let what = "change of pressure with displacement over that of the gas law";
    evidence.push(Evidence::new(format!("{what}, as recorded"), stated, 1.0));
    evidence.push(Evidence::new(format!("{what}, corrected"), after, 1.0));
    let message = format!(
        "the displacement looks like {unit} where mm are meant: sealed air makes the pressures change {stated:.4} times as \
         much with x as the gas law says, and {after:.3} times if x is in {unit}; multiply displacement_mm by {mm:.6} and \
         the velocity likewise"
    );
    finding(FindingKind::DisplacementUnit, severity, "displacement_mm", sample, message, evidence)
}

/// Pressures that no reading makes possible.
fn impossible<F: ForceModel<f64>>(
    weights: &Weights<'_, F>,
    sample: &Sample<'_>,
    reading: Reading,
) -> Option<Finding> {
    let s = weights.settings;
    let unit = &weights.units[reading.pressure].reading;
    let (low, high) = (0.8 * s.lowest_kpa, 1.25 * s.highest_kpa);
    let (i, p) =
        sample.pressures.iter().enumerate().find(|(_, p)| !(low..high).contains(&unit.kpa(**p)))?;
    let message = format!(
        "{} is {p:.4} kPa in the middle: a muscle works between {} and {} kPa absolute, and no unit of pressure makes both \
         columns fit; check sensor, column and unit",
        PRESSURES[i], s.lowest_kpa, s.highest_kpa
    );
    let evidence =
        vec![Evidence::new(format!("median of {} (kPa)", PRESSURES[i]), *p, s.lowest_kpa)];
    Some(finding(
        FindingKind::PressureUnit,
        Severity::Error,
        PRESSURES[i],
        sample,
        message,
        evidence,
    ))
}

/// Pressures or displacement that never change although something must.
fn silent<F: ForceModel<f64>>(
    weights: &Weights<'_, F>,
    sample: &Sample<'_>,
    reading: Reading,
) -> Vec<Finding> {
    let Some(blocks) = &sample.blocks else { return Vec::new() };
    if !moves(blocks) {
        let mean = blocks.force_n.iter().sum::<f64>() / blocks.force_n.len() as f64;
        let force: Vec<f64> = blocks.force_n.iter().map(|f| f - mean).collect();
        let rms = (squares(&force) / force.len() as f64).sqrt();
        if rms < 1.0 {
            return Vec::new();
        }
        let message = format!(
            "the displacement never changes while the force changes by {rms:.1} N (RMS): the encoder is dead, or the joint is \
             blocked"
        );
        let evidence = vec![Evidence::new("RMS of the force (N)", rms, 0.0)];
        return vec![finding(
            FindingKind::DeadDisplacement,
            Severity::Warning,
            "displacement_mm",
            sample,
            message,
            evidence,
        )];
    }
    let mm = reading.mm();
    let expected = expected_slopes(weights.model, sample.middle_x * mm);
    let moved = super::blocks::without_drift(&blocks.x);
    let moved_mm = mm * (squares(&moved) / moved.len() as f64).sqrt();
    (0..2)
        .filter_map(|i| {
            let kpa = weights.units[reading.pressure].reading.kpa(sample.pressures[i]);
            let change_kpa = (kpa * expected[i] * moved_mm).abs();
            let share = response(blocks, i, expected[i] * mm);
            if change_kpa < TELLING_CHANGE_KPA || share >= DEAD_RESPONSE {
                return None;
            }
            let constant = blocks.pressures[i].windows(2).all(|w| w[0] == w[1]);
            let severity = if constant { Severity::Error } else { Severity::Warning };
            let message = format!(
                "{} {} although the joint moves: sealed air should change it by {change_kpa:.1} kPa (RMS); the sensor is dead, \
                 the chamber is open, or the column is another one",
                PRESSURES[i],
                if constant { "never changes" } else { "hardly changes" }
            );
            let evidence = vec![Evidence::new("change of pressure over that of the gas law", share, 1.0)];
            Some(finding(FindingKind::DeadPressure, severity, PRESSURES[i], sample, message, evidence))
        })
        .collect()
}

/// Both pressures rise with x.
fn same_sign<F: ForceModel<f64>>(
    weights: &Weights<'_, F>,
    sample: &Sample<'_>,
    reading: Reading,
) -> Option<Finding> {
    let [Some(flexor), Some(extensor)] = sample.slopes[reading.pressure] else { return None };
    if flexor.ratio * extensor.ratio < 0.0 || flexor.r2.min(extensor.r2) < weights.settings.least_r2
    {
        return None;
    }
    let clear = flexor.r2.min(extensor.r2) >= CLEAR_R2;
    let severity = if clear { Severity::Error } else { Severity::Warning };
    let message = "both pressures rise and fall together with the displacement, while one muscle shortens as the other \
                   lengthens: the same column may stand twice, or one sensor is on the wrong muscle"
        .to_owned();
    let evidence = vec![
        Evidence::new("d ln P_f/dx (1/mm)", flexor.ratio, -extensor.ratio),
        Evidence::new("d ln P_e/dx (1/mm)", extensor.ratio, -flexor.ratio),
    ];
    Some(finding(FindingKind::SameSignPressures, severity, BOTH, sample, message, evidence))
}

/// Volumes of the model that do not fit the pressures.
fn geometry<F: ForceModel<f64>>(
    weights: &Weights<'_, F>,
    sample: &Sample<'_>,
    [flexor, extensor]: [f64; 2],
) -> Option<Finding> {
    let common = 0.5 * (flexor + extensor);
    let [low, high] = weights.settings.geometry_factors;
    if (low.ln()..=high.ln()).contains(&common) {
        return None;
    }
    let agree = (flexor - extensor).abs() < COMMON_RATIO;
    let severity = if agree { Severity::Error } else { Severity::Warning };
    let p = weights.model.physical();
    let g = &weights.model.geometry;
    // Near x = 0 both slopes are (2ν − 1)/L0.
    let slope = (2.0 * p.deformation - 1.0) / g.length_mm * common.exp();
    let message = format!(
        "the pressures change {:.3} (flexor) and {:.3} times (extensor) as much with the displacement as the model's muscles \
         of {} mm length and deformation coefficient {:.2} allow; the data ask for (2ν − 1)/L0 = {slope:.4}/mm. Check length \
         and coefficient of the model, and the scale of displacement_mm",
        flexor.exp(),
        extensor.exp(),
        g.length_mm,
        p.deformation
    );
    let evidence = vec![
        Evidence::new("change of P_f over that of the gas law", flexor.exp(), 1.0),
        Evidence::new("change of P_e over that of the gas law", extensor.exp(), 1.0),
    ];
    Some(finding(FindingKind::Geometry, severity, "displacement_mm", sample, message, evidence))
}

/// Given masses far from those of the gas law.
pub(super) fn masses<F: ForceModel<f64>>(
    weights: &Weights<'_, F>,
    sample: &Sample<'_>,
    reading: Reading,
) -> Option<Finding> {
    let ratios = weights.mass_ratios(sample, reading)?;
    let threshold = weights.settings.mass_factor.ln();
    if ratios.iter().all(|r| r.ln().abs() < threshold) {
        return None;
    }
    let [flexor, extensor] = ratios;
    let alike = (flexor / extensor).ln().abs() < COMMON_RATIO;
    let severity = if alike || ratios.iter().any(|r| r.ln().abs() > 2.0 * threshold) {
        Severity::Error
    } else {
        Severity::Warning
    };
    let message = format!(
        "the masses that the file gives are {flexor:.4} (flexor) and {extensor:.4} times (extensor) those of P V/C at the \
         recorded pressures; check their unit (g), the radius of the model's muscles ({} mm), and which muscle is which, or \
         leave them out of the file",
        weights.model.geometry.radius_mm
    );
    let evidence = vec![
        Evidence::new("given over gas-law mass, flexor", flexor, 1.0),
        Evidence::new("given over gas-law mass, extensor", extensor, 1.0),
    ];
    Some(finding(
        FindingKind::Masses,
        severity,
        "mass_flexor_g, mass_extensor_g",
        sample,
        message,
        evidence,
    ))
}
