//! Tracking: how well a joint follows plans.

use super::{MakeJoint, SETTLE_S};
use crate::error::ControlError;
use crate::execution::{Commands, Followed, follow};
use crate::motion::{MotionSpec, StiffnessProfile};
use crate::synthesis::{Plan, PlanSummary, SynthesisSettings, plan};
use pam_core::parallel;
use pam_core::{AnyForce, JointModel};
use serde::Serialize;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Shapes of the motion of the tests.
pub const SHAPES: [&str; 2] = ["sine", "triangle"];

/// Series of tests, by the quantity that they vary.
pub const SERIES: [&str; 3] = ["amplitude", "frequency", "stiffness"];

/// One test.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrackingCase {
    /// One of [`SHAPES`].
    pub shape: &'static str,
    /// One of [`SERIES`].
    pub series: &'static str,
    /// Amplitude, mm.
    pub amplitude_mm: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Stiffness, N/mm.
    pub stiffness_n_mm: f64,
    /// Published root mean square error, mm.
    pub published_mm: f64,
}

/// The published tests with their errors (Wang and Realmuto 2026, section V-B). The amplitude series is at
/// 0.1 Hz and 150 N/mm, the frequency series at 1 mm and 150 N/mm, the stiffness series at 1 mm and 0.1 Hz.
#[must_use]
pub fn published_cases() -> Vec<TrackingCase> {
    let amplitudes = [0.5, 1.0, 1.5, 2.0];
    let frequencies = [0.1, 0.25, 0.5, 0.75, 1.0];
    let stiffnesses = [140.0, 150.0, 160.0];
    let errors = [
        (
            SHAPES[0],
            [0.151, 0.139, 0.113, 0.108],
            [0.127, 0.094, 0.067, 0.190, 0.375],
            [0.180, 0.151, 0.142],
        ),
        (
            SHAPES[1],
            [0.109, 0.113, 0.115, 0.138],
            [0.128, 0.078, 0.120, 0.249, 0.300],
            [0.132, 0.131, 0.134],
        ),
    ];
    let mut cases = Vec::new();
    for (shape, by_amplitude, by_frequency, by_stiffness) in errors {
        let case = |series, amplitude_mm, frequency_hz, stiffness_n_mm, published_mm| {
            TrackingCase { shape, series, amplitude_mm, frequency_hz, stiffness_n_mm, published_mm }
        };
        for (a, e) in amplitudes.into_iter().zip(by_amplitude) {
            cases.push(case(SERIES[0], a, 0.1, 150.0, e));
        }
        for (f, e) in frequencies.into_iter().zip(by_frequency) {
            cases.push(case(SERIES[1], 1.0, f, 150.0, e));
        }
        for (k, e) in stiffnesses.into_iter().zip(by_stiffness) {
            cases.push(case(SERIES[2], 1.0, 0.1, k, e));
        }
    }
    cases
}

/// Result of a test.
#[derive(Debug, Clone)]
pub struct TrackingResult {
    /// The test.
    pub case: TrackingCase,
    /// The plan.
    pub plan: PlanSummary,
    /// Root mean square error from the second period on, mm.
    pub rmse_mm: f64,
    /// Root mean square error of the pressures (measured less commanded), kPa.
    pub pressure_rmse_kpa: f64,
    /// Motion of the joint.
    pub followed: Followed,
}

/// Samples of a plan per second.
const RATE_HZ: f64 = 1000.0;
/// Most periods after which a motion may come back to a sample: 0.75 Hz does after three.
const MOST_PERIODS: u32 = 10;

/// Samples after which a motion of this frequency comes back to a sample; none within [`MOST_PERIODS`] periods.
fn period_samples(frequency_hz: f64) -> Option<usize> {
    (1..=MOST_PERIODS).map(|periods| f64::from(periods) / frequency_hz * RATE_HZ).find_map(
        |samples| {
            let whole = samples.round();
            ((samples - whole).abs() < 1e-6).then_some(whole as usize)
        },
    )
}

/// Plans, carries out and scores tests; the first period (at least two seconds) is left out of the
/// score, then two periods and at least ten seconds count. A test that occurs in several series is done once.
///
/// # Errors
/// [`ControlError`] if a test cannot be planned.
pub fn track(
    model: &JointModel<f64, AnyForce<f64>>,
    settings: SynthesisSettings,
    cases: &[TrackingCase],
    seed: u64,
    make: MakeJoint<'_>,
    done: &(dyn Fn() + Sync),
) -> Result<Vec<TrackingResult>, ControlError> {
    let same = |a: &TrackingCase, b: &TrackingCase| {
        (a.shape, a.amplitude_mm, a.frequency_hz, a.stiffness_n_mm)
            == (b.shape, b.amplitude_mm, b.frequency_hz, b.stiffness_n_mm)
    };
    let mut distinct: Vec<&TrackingCase> = Vec::new();
    let places: Vec<usize> = cases
        .iter()
        .map(|case| {
            distinct.iter().position(|other| same(case, other)).unwrap_or_else(|| {
                distinct.push(case);
                distinct.len() - 1
            })
        })
        .collect();
    // A test that fails ends those after it, so that the error is that of the first one on any number of threads.
    let first_failed = AtomicUsize::new(usize::MAX);
    let results = parallel::map(distinct.len(), |k| {
        if k > first_failed.load(Ordering::Relaxed) {
            return None;
        }
        let result = track_case(model, settings, distinct[k], seed, make);
        match &result {
            Ok(_) => cases.iter().filter(|case| same(case, distinct[k])).for_each(|_| done()),
            Err(_) => {
                first_failed.fetch_min(k, Ordering::Relaxed);
            }
        }
        Some(result)
    });
    let results = results.into_iter().flatten().collect::<Result<Vec<_>, _>>()?;
    let result = |(case, place): (&TrackingCase, usize)| TrackingResult {
        case: case.clone(),
        ..results[place].clone()
    };
    Ok(cases.iter().zip(places).map(result).collect())
}

/// Plans, carries out and scores one test.
fn track_case(
    model: &JointModel<f64, AnyForce<f64>>,
    settings: SynthesisSettings,
    case: &TrackingCase,
    seed: u64,
    make: MakeJoint<'_>,
) -> Result<TrackingResult, ControlError> {
    let period = 1.0 / case.frequency_hz;
    let lead = period * (2.0 / period).ceil().max(1.0);
    let length = lead + period * (10.0 / period).ceil().max(2.0);
    let text =
        format!("{}:A={},f={},duration={length}", case.shape, case.amplitude_mm, case.frequency_hz);
    let motion = MotionSpec::parse(&text)?;
    let stiffness = StiffnessProfile::Constant(case.stiffness_n_mm);
    let targets = plan::targets(&motion, Some(&stiffness), 0.0, RATE_HZ)?;
    let repeats = period_samples(case.frequency_hz).unwrap_or(0);
    let plan = Plan::periodic(model, targets, repeats, settings)?;
    let commands = Commands::from(&plan);
    let mut joint = make(seed, commands.pressures_kpa(0.0));
    let followed = follow(&mut joint, &commands, SETTLE_S, |_| 0.0);
    let errors = followed
        .commanded_kpa
        .iter()
        .zip(&followed.pressures_kpa)
        .flat_map(|(c, p)| [c[0] - p[0], c[1] - p[1]]);
    let squares: f64 = errors.map(|e| e * e).sum();
    Ok(TrackingResult {
        case: case.clone(),
        plan: plan.summary(),
        rmse_mm: followed.rmse_mm(lead),
        pressure_rmse_kpa: (squares / (2 * followed.time_s.len()) as f64).sqrt(),
        followed,
    })
}
