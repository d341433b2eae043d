//! Do recordings fit the physics of a joint with two sealed muscles?
//!
//! A wrong unit, a swapped column or a flipped sign makes every later number meaningless, and a diagnosis can fit much of
//! it away with effects that are not there. [`check`] compares recordings of any format with what must hold whatever the
//! joint's condition, before anything is fitted:
//!
//! | law | columns | what it shows |
//! |---|---|---|
//! | `P_f V_f(x) = const`, `P_e V_e(x) = const` | pressures, x | gauge for absolute, units, degrees for mm, swapped muscles, geometry |
//! | `105 kPa < P < 1000 kPa`, radii and lengths positive | pressures, x | units |
//! | `x(t) − x(0) = ∫ ẋ dt` | x, ẋ, time | velocity missing, in m/s, of the wrong sign; time in ms |
//! | `F = m ẍ + f(x, ẋ, m_f, m_e)` | force, x, masses | sign and unit of the force, displacement against muscles |
//! | `m = P V / C` | given masses, pressures, x | masses in mg, radius |
//!
//! Each way to read the columns (units, reference, order, sign) is weighed by its log odds against the stated one. The
//! odds allow what a diagnosis is there to find: polytropic air, gains of tens of per cent, biases, lags, leaks.
//! A [`Finding`] is an [`Error`](Severity::Error) from odds of 100 to 1, a [`Warning`](Severity::Warning) from 10 to 1. All recordings are
//! of the same muscles: a [geometry](FindingKind::Geometry) that only a minority of them contradicts is a warning.
//!
//! ```no_run
//! use pam_data::{LoadOptions, MassOptions, Subject, load_model, plausibility, read_recordings};
//! let saved = load_model("model.safetensors")?;
//! let recordings = read_recordings(["logs"], &LoadOptions::default())?;
//! let subjects = Subject::resolve(recordings, &saved, &MassOptions::default())?;
//! for finding in plausibility::check(&saved.model, &subjects) {
//!     println!("{finding}");
//! }
//! # Ok::<(), pam_data::DataError>(())
//! ```

mod balance;
pub(crate) mod blocks;
mod choice;
mod columns;
mod finding;
mod force;
mod gas;
mod motion;
mod readings;
mod sample;
mod settings;
mod weigh;

pub(crate) use blocks::Regression;
pub use finding::{Evidence, Finding, FindingKind, Severity, errors};
pub(crate) use gas::implied_deformation;
pub use settings::PlausibilitySettings;

use crate::subject::Subject;
use pam_core::{ForceModel, JointModel, parallel};
use readings::{pressure_units, unit_in_file};
use sample::Sample;
use weigh::Weights;

/// Checks recordings against the physics of the model's joint, with the default thresholds. Sound recordings have no
/// finding, in whatever condition the joint is.
///
/// Cost: some milliseconds per 70 s at 1 kHz.
#[must_use]
pub fn check<'s, F: ForceModel<f64> + Sync>(
    model: &JointModel<f64, F>,
    subjects: impl IntoIterator<Item = &'s Subject>,
) -> Vec<Finding> {
    check_with(model, subjects, &PlausibilitySettings::default())
}

/// [`check`] with given thresholds.
#[must_use]
pub fn check_with<'s, F: ForceModel<f64> + Sync>(
    model: &JointModel<f64, F>,
    subjects: impl IntoIterator<Item = &'s Subject>,
    settings: &PlausibilitySettings,
) -> Vec<Finding> {
    let subjects: Vec<&Subject> = subjects.into_iter().filter(|s| s.recording.len() > 1).collect();
    // One list of units for all keeps indices alike.
    let units = pressure_units(unit_in_file(subjects.iter().map(|s| &s.recording)), settings);
    let samples: Vec<Sample<'_>> =
        parallel::map(subjects.len(), |i| Sample::new(subjects[i], &units, settings));
    let weights = Weights { model, units: &units, settings };
    let readings = choice::readings(&weights, &samples);
    let each = parallel::map(samples.len(), |i| {
        let (sample, reading) = (&samples[i], &readings[i]);
        let of_columns = columns::findings(&weights, sample, reading);
        let of_motion = motion::findings(sample, reading.reading, settings);
        let of_force = force::findings(&weights, sample, reading);
        (of_columns, of_motion, of_force, columns::masses(&weights, sample, reading.reading))
    });
    let (mut findings, mut others) = (Vec::new(), Vec::new());
    let mut forces_off = Vec::new();
    for (of_columns, of_motion, of_force, masses) in each {
        findings.extend(of_columns);
        others.extend(of_motion);
        others.extend(of_force.directions);
        forces_off.extend(of_force.off);
        others.extend(masses);
    }
    findings.extend(columns::geometries(&weights, &samples, &readings));
    findings.extend(others);
    findings.extend(force::units(forces_off));
    merged(findings)
}

/// Findings of the same kind in the same columns as one, which keeps the message of the first.
fn merged(findings: Vec<Finding>) -> Vec<Finding> {
    let mut out: Vec<Finding> = Vec::new();
    for finding in findings {
        let same = |o: &&mut Finding| {
            (o.kind, o.severity, &o.channel) == (finding.kind, finding.severity, &finding.channel)
        };
        match out.iter_mut().find(same) {
            Some(known) => known.recordings.extend(finding.recordings),
            None => out.push(finding),
        }
    }
    out.sort_by_key(|f| std::cmp::Reverse(f.severity));
    out
}
