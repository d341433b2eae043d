//! Quantities that the motion of a recording identifies.

use super::settings::QualitySettings;
use super::{QualityFinding, QualityKind};
use crate::plausibility::{Regression, Severity};
use crate::recording::{Recording, median_step_s};
use pam_numerics::statistics::{mean, quantile, root_mean_square};
use serde::Serialize;

/// Averaging time before derivatives, s: motion up to 8 Hz keeps its size within 5 %.
const BLOCK_S: f64 = 0.02;
/// Turns smaller than this share of the range are noise.
const SMALLEST_TURN: f64 = 0.05;

/// The motion, and what it determines.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Excitation {
    /// Smallest to largest displacement, mm.
    pub travel_mm: f64,
    /// Speed that is exceeded for a tenth of the time, mm/s.
    pub fast_mm_s: f64,
    /// Speed that is exceeded for nine tenths of the time, mm/s.
    pub slow_mm_s: f64,
    /// RMS of the acceleration, mm/s².
    pub acceleration_mm_s2: f64,
    /// Reversals of the motion.
    pub reversals: usize,
    /// Share of the variance of the acceleration that does not follow linearly from position and velocity: what tells
    /// the mass from the stiffness. 0 for one sine.
    pub open_acceleration: f64,
    /// Reflected mass whose inertia is 5 % of the force (RMS), kg: a smaller one is hardly seen. `null` without
    /// acceleration.
    pub smallest_mass_kg: f64,
    /// Mean frequency of the motion: RMS of ẋ over that of x over 2π, Hz.
    pub frequency_hz: f64,
}

impl Excitation {
    pub(super) fn of(r: &Recording) -> Self {
        let step = median_step_s(&r.time_s);
        let per = (BLOCK_S / step).round().max(1.0) as usize;
        let x: Vec<f64> = r.displacement_mm.chunks_exact(per).map(mean).collect();
        let dt = step * per as f64;
        let slope = |v: &[f64]| v.windows(3).map(|w| 0.5 * (w[2] - w[0]) / dt).collect::<Vec<_>>();
        let v = slope(&x);
        let a = slope(&v);
        let (low, high) =
            x.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
        let speeds: Vec<f64> = v.iter().map(|v| v.abs()).collect();
        let rms = |v: &[f64]| if v.is_empty() { 0.0 } else { root_mean_square(v) };
        let centred = |v: &[f64]| {
            let m = mean(v);
            v.iter().map(|v| v - m).collect::<Vec<f64>>()
        };
        let inner = |v: &[f64], margin: usize| {
            centred(v.get(margin..v.len().saturating_sub(margin)).unwrap_or(&[]))
        };
        let (x2, v2, a2) = (inner(&x, 2), inner(&v, 1), centred(&a));
        let open = if a2.len() < 10 {
            0.0
        } else {
            Regression::new(&a2, &[&x2, &v2]).map_or(0.0, |fit| 1.0 - fit.r2)
        };
        Self {
            travel_mm: if x.is_empty() { 0.0 } else { high - low },
            fast_mm_s: if speeds.is_empty() { 0.0 } else { quantile(&speeds, 0.9) },
            slow_mm_s: if speeds.is_empty() { 0.0 } else { quantile(&speeds, 0.1) },
            acceleration_mm_s2: rms(&a),
            reversals: reversals(&x, SMALLEST_TURN * (high - low)),
            open_acceleration: open,
            smallest_mass_kg: SEEN_SHARE * rms(&centred(&r.force_mn)) / rms(&a),
            frequency_hz: if rms(&x2) > 0.0 {
                rms(&v2) / rms(&x2) / std::f64::consts::TAU
            } else {
                0.0
            },
        }
    }

    /// The quantities that can be identified from it, one sentence each.
    #[must_use]
    pub fn sentences(&self, s: &QualitySettings) -> Vec<String> {
        let yes = |known: bool, what: &str, why: String| {
            format!(
                "{what} {} from this recording: {why}",
                if known { "can be identified" } else { "cannot be identified" }
            )
        };
        let moves = self.travel_mm > 0.0;
        vec![
            yes(moves, "stiffness", format!("the joint travels {:.2} mm", self.travel_mm)),
            yes(
                self.mass_is_open(s),
                "the mass, separately from the stiffness,",
                format!(
                    "{:.0} % of the acceleration is independent of position and velocity; the force shows masses above {:.1} kg",
                    100.0 * self.open_acceleration,
                    self.smallest_mass_kg
                ),
            ),
            yes(
                moves && self.reversals >= s.fewest_reversals,
                "friction and hysteresis",
                format!("the motion reverses {} times", self.reversals),
            ),
            yes(
                self.fast_mm_s > 3.0 * self.slow_mm_s && moves,
                "dry friction, separately from viscous friction,",
                format!("speeds from {:.2} to {:.2} mm/s", self.slow_mm_s, self.fast_mm_s),
            ),
        ]
    }

    fn mass_is_open(&self, s: &QualitySettings) -> bool {
        self.open_acceleration >= s.open_acceleration
    }

    pub(super) fn findings(&self, s: &QualitySettings) -> Vec<QualityFinding> {
        let make = |message: &str| {
            QualityFinding::new(
                QualityKind::Excitation,
                Severity::Warning,
                "displacement_mm",
                message.into(),
            )
        };
        let mut out = Vec::new();
        if self.travel_mm == 0.0 {
            return vec![make("nothing moves: neither stiffness nor damping can be identified")];
        }
        if !self.mass_is_open(s) {
            out.push(make(
                "position and velocity determine the acceleration: mass and stiffness cannot be separated; excite at two \
                 frequencies or more",
            ));
        }
        if self.reversals < s.fewest_reversals {
            out.push(make(
                "the motion hardly reverses: friction and hysteresis cannot be identified; excite both directions of motion",
            ));
        }
        out
    }
}

/// Share of the force that inertia must have before the mass is seen.
const SEEN_SHARE: f64 = 0.05;
/// Turns of the motion that are larger than `smallest`.
fn reversals(x: &[f64], smallest: f64) -> usize {
    let Some(&first) = x.first() else { return 0 };
    let (mut count, mut direction, mut extreme) = (0, 0.0, first);
    for &v in x {
        if direction == 0.0 {
            if (v - first).abs() > smallest {
                (direction, extreme) = ((v - first).signum(), v);
            }
        } else if (v - extreme) * direction > 0.0 {
            extreme = v;
        } else if (extreme - v) * direction > smallest {
            count += 1;
            (direction, extreme) = (-direction, v);
        }
    }
    count
}
