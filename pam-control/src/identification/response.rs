use crate::execution::{PulseRecord, SAMPLE_S};
use pam_core::Scalar;
use pam_core::units::MN_PER_N;
use pam_numerics::statistics;
use pam_solvers::rk4_step;

/// A measured response to a known force.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Response {
    /// Mass M, kg.
    pub mass_kg: f64,
    /// Time between samples, s.
    pub sample_s: f64,
    /// Displacement at the start x0, mm.
    pub start_mm: f64,
    /// Velocity at the start ẋ0, mm/s.
    pub start_mm_s: f64,
    /// Acceleration at the start ẍ0, mm/s².
    pub start_mm_s2: f64,
    /// Force from the start on, held from sample to sample, N.
    pub force_n: Vec<f64>,
    /// Measured displacement at the same times, mm.
    pub displacement_mm: Vec<f64>,
}

impl Response {
    /// The response of a recorded pulse. Displacement and velocity at its start are those of a straight
    /// line through the samples before it; the acceleration is taken as zero (0.4 mm/s² at most in the
    /// published motion, 0.1 N).
    #[must_use]
    pub fn of_pulse(record: &PulseRecord, mass_kg: f64) -> Self {
        let before = &record.displacement_mm[..=record.start];
        let (start_mm, slope) = line_at_end(before);
        Self {
            mass_kg,
            sample_s: SAMPLE_S,
            start_mm,
            start_mm_s: slope / SAMPLE_S,
            start_mm_s2: 0.0,
            force_n: record.force_n[record.start..].to_vec(),
            displacement_mm: record.displacement_mm[record.start..].to_vec(),
        }
    }
}

impl Response {
    /// Half the difference of the responses to a push and to the opposite one: what the joint does by itself
    /// after its valves have shut (warm air cools, a motion runs out) and the even part of dry friction
    /// are in both and cancel.
    #[must_use]
    pub fn half_difference(push: &Self, opposite: &Self) -> Self {
        let half = |a: f64, b: f64| 0.5 * (a - b);
        let force_n = push.force_n.iter().zip(&opposite.force_n).map(|(a, b)| half(*a, *b));
        let displacement_mm = push
            .displacement_mm
            .iter()
            .zip(&opposite.displacement_mm)
            .map(|(a, b)| half(a - push.start_mm, b - opposite.start_mm));
        Self {
            mass_kg: push.mass_kg,
            sample_s: push.sample_s,
            start_mm: 0.0,
            start_mm_s: half(push.start_mm_s, opposite.start_mm_s),
            start_mm_s2: half(push.start_mm_s2, opposite.start_mm_s2),
            force_n: force_n.collect(),
            displacement_mm: displacement_mm.collect(),
        }
    }
}

/// Value at the last point and slope per point of the straight line through equally spaced values.
fn line_at_end(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = statistics::mean(values);
    let middle = 0.5 * (n - 1.0);
    let (mut product, mut square) = (0.0, 0.0);
    for (k, v) in values.iter().enumerate() {
        let t = k as f64 - middle;
        product += t * (v - mean);
        square += t * t;
    }
    let slope = if square > 0.0 { product / square } else { 0.0 };
    (mean + slope * middle, slope)
}

/// Displacements that a stiffness (N/mm) and a damping (kg/s) give, mm: classical Runge–Kutta steps of
/// one sample.
#[must_use]
pub fn simulate<S: Scalar>(response: &Response, stiffness_n_mm: S, damping_kg_s: S) -> Vec<S> {
    let stiffness = stiffness_n_mm.scaled(MN_PER_N);
    let (h, inverse_mass) = (response.sample_s, 1.0 / response.mass_kg);
    let rate = |[x, v]: [S; 2], force_mn: f64| {
        let springs = -(stiffness * x) - damping_kg_s * (v - S::constant(response.start_mm_s));
        let acceleration = (springs + S::constant(force_mn)).scaled(inverse_mass);
        [v, acceleration + S::constant(response.start_mm_s2)]
    };
    let mut state = [S::zero(), S::constant(response.start_mm_s)];
    let mut out = Vec::with_capacity(response.force_n.len());
    for &force_n in &response.force_n {
        out.push(state[0] + S::constant(response.start_mm));
        let force_mn = force_n * MN_PER_N;
        state = rk4_step(state, rate(state, force_mn), h, |_, state| rate(state, force_mn));
    }
    out
}
