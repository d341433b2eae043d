//! Guesses from the numbers of columns.

use super::super::schema::Zero;
use crate::preprocess::gradient;
use pam_core::units::ATMOSPHERE_KPA;
use pam_numerics::ScaledCholesky;
use pam_numerics::statistics::{mean, median};

/// Averages of the columns, whose relations tell signs and zeros.
pub(super) struct Numbers {
    x: Vec<f64>,
    pressures: [Vec<f64>; 2],
    force: Vec<f64>,
}

/// Points to which recordings are averaged.
const POINTS: usize = 2000;
/// Least correlation of pressure and displacement that tells the muscles apart.
const LEAST_CORRELATION: f64 = 0.3;
/// Least relative difference of the two pressures at which the gas law tells gauge from absolute.
const LEAST_DIFFERENCE: f64 = 0.1;
/// How much nearer to equal the slopes of both chambers must be under one zero than under the other.
const CLEARLY_NEARER: f64 = 3.0;

impl Numbers {
    pub(super) fn new(x: &[f64], pressures: [&Vec<f64>; 2], force: &[f64]) -> Self {
        let per = x.len().div_ceil(POINTS).max(1);
        let averaged = |v: &[f64]| v.chunks(per).map(mean).collect::<Vec<f64>>();
        Self { x: averaged(x), pressures: pressures.map(|p| averaged(p)), force: averaged(force) }
    }

    /// Whether the first pressure falls as x rises and the second rises; `None` if neither is clear.
    pub(super) fn first_falls(&self) -> Option<bool> {
        let [first, second] = [0, 1].map(|k| correlation(&self.x, &self.pressures[k]));
        let difference = second - first;
        (difference.abs() > LEAST_CORRELATION).then_some(difference > 0.0)
    }

    /// Whether the joint yields to the force: the sign of k in `F = k x + b ẋ + m ẍ`.
    pub(super) fn yields(&self) -> Option<bool> {
        let x = centred(&self.x);
        let v = centred(&gradient(&x, 1.0));
        let a = centred(&gradient(&v, 1.0));
        let force = centred(&self.force);
        let columns = [&x, &v, &a];
        let factor = ScaledCholesky::new(3, |i, j| dot(columns[i], columns[j]), 1e-9)?;
        let right: Vec<f64> = columns.iter().map(|c| dot(c, &force)).collect();
        let fit = factor.solve(&right)?;
        let explained = dot(&fit, &right) / dot(&force, &force).max(f64::MIN_POSITIVE);
        (explained > LEAST_CORRELATION).then_some(fit[0] > 0.0)
    }

    /// Gauge or absolute, by `P V(x) = const` with equal muscles: `d ln P_f/dx = −d ln P_e/dx` at x = 0.
    pub(super) fn reference(&self, place: usize, kpa: f64) -> (Zero, String, bool) {
        let lowest = range(&self.pressures[place]).0 * kpa;
        if lowest < 0.9 * ATMOSPHERE_KPA {
            return (
                Zero::Gauge,
                format!("down to {lowest:.1} kPa, less than the atmosphere"),
                false,
            );
        }
        let levels = [0, 1].map(|k| median(&self.pressures[k]) * kpa);
        if (levels[0] / levels[1]).ln().abs() > LEAST_DIFFERENCE {
            let asymmetry = |offset: f64| {
                let slope = |k: usize| {
                    let logs: Vec<f64> = self.pressures[k]
                        .iter()
                        .map(|p| (p * kpa + offset).max(1e-9).ln())
                        .collect();
                    regression_slope(&self.x, &logs)
                };
                (slope(0) / -slope(1)).ln().abs()
            };
            let (absolute, gauge) = (asymmetry(0.0), asymmetry(ATMOSPHERE_KPA));
            if absolute.is_finite() && gauge.is_finite() {
                let reason = "the gas law in both muscles agrees better so";
                if gauge * CLEARLY_NEARER < absolute {
                    return (Zero::Gauge, reason.into(), true);
                }
                if absolute * CLEARLY_NEARER < gauge {
                    return (Zero::Absolute, reason.into(), true);
                }
            }
        }
        (Zero::Absolute, format!("never below {lowest:.1} kPa; the numbers allow both"), true)
    }
}

/// The likely unit of a pressure by its size: sealed muscles hold 1.1 to 8 bar.
pub(super) fn pressure_unit(values: &[f64]) -> (&'static str, String) {
    let middle = median(values);
    let unit = match middle {
        m if m < 12.0 => "bar",
        m if m < 130.0 => "psi",
        m if m < 1500.0 => "kPa",
        m if m < 12_000.0 => "mbar",
        _ => "Pa",
    };
    (unit, format!("values around {middle:.4}"))
}

/// Lowest and highest value.
pub(super) fn range(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)))
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn centred(values: &[f64]) -> Vec<f64> {
    let middle = mean(values);
    values.iter().map(|v| v - middle).collect()
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (centred(a), centred(b));
    let size = (dot(&a, &a) * dot(&b, &b)).sqrt();
    if size > 0.0 { dot(&a, &b) / size } else { 0.0 }
}

fn regression_slope(x: &[f64], y: &[f64]) -> f64 {
    let (x, y) = (centred(x), centred(y));
    dot(&x, &y) / dot(&x, &x)
}
