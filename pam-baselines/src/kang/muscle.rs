//! The force of a single muscle.

use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Nominal size of a muscle, held in the fit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MuscleSize {
    /// Diameter D0, mm.
    pub diameter_mm: f64,
    /// Length L0, mm.
    pub length_mm: f64,
}

impl MuscleSize {
    /// The muscles of the joint: 10 mm and 200 mm.
    pub const JOINT: Self = Self { diameter_mm: 10.0, length_mm: 200.0 };
    /// FESTO DMSP-10-250: 10 mm and 250 mm.
    pub const DMSP_10_250: Self = Self { diameter_mm: 10.0, length_mm: 250.0 };

    /// A0 = π D0²/4, mm².
    #[must_use]
    pub fn area_mm2(&self) -> f64 {
        0.25 * PI * self.diameter_mm * self.diameter_mm
    }
}

/// The analytical force of a McKibben muscle with a correction for its ends (Kang, Kothera, Woods and
/// Wereley 2009; in the form of Wang and Realmuto 2026, supplement A):
///
/// ```text
/// F = A0 p [3 (1 − q ε)²/tan²α0 − 1/sin²α0] − c_v ε̇ − c_c sgn ε̇       q = 1 + c_q1 exp(c_q2 p)
/// ```
///
/// p is the gauge pressure, ε the contraction over L0.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct KangMuscle {
    /// Nominal size.
    pub size: MuscleSize,
    /// Initial braid angle α0, degrees.
    pub braid_angle_deg: f64,
    /// c_q1.
    pub correction: f64,
    /// c_q2, 1/kPa.
    pub correction_rate_per_kpa: f64,
    /// c_v, N·s.
    pub viscous_ns: f64,
    /// c_c, N.
    pub dry_n: f64,
}

impl KangMuscle {
    /// The published starting guess of a fit: 2.25, −0.0262 per psi, 200, 40.
    #[must_use]
    pub fn published_guess(size: MuscleSize) -> Self {
        Self {
            size,
            braid_angle_deg: 27.5,
            correction: 2.25,
            correction_rate_per_kpa: -0.0262 / pam_core::units::KPA_PER_PSI,
            viscous_ns: 200.0,
            dry_n: 40.0,
        }
    }

    /// The force without losses, N; negative where the muscle would push.
    #[must_use]
    pub fn elastic_n(&self, gauge_kpa: f64, contraction: f64) -> f64 {
        let angle = self.braid_angle_deg.to_radians();
        let q = 1.0 + self.correction * (self.correction_rate_per_kpa * gauge_kpa).exp();
        let stretch = 1.0 - q * contraction;
        // kPa · mm² = mN.
        let scale = 1e-3 * self.size.area_mm2() * gauge_kpa;
        scale * (3.0 * stretch * stretch / angle.tan().powi(2) - angle.sin().powi(-2))
    }

    /// The tension, N: the force with its losses, or zero where it would push, for a muscle is slack
    /// then. `direction` is the sign of the contraction rate.
    #[must_use]
    pub fn tension_n(
        &self,
        gauge_kpa: f64,
        contraction: f64,
        rate_per_s: f64,
        direction: f64,
    ) -> f64 {
        let losses = self.viscous_ns * rate_per_s + self.dry_n * direction;
        (self.elastic_n(gauge_kpa, contraction) - losses).max(0.0)
    }
}
