use crate::error::ModelError;
use crate::scalar::Scalar;
use crate::units::{NOMINAL_LENGTH_MM, NOMINAL_RADIUS_MM};

/// Nominal size of the two equal muscles. Each is a cylinder whose radius follows its length
/// through the braid:
///
/// ```text
/// r_f = r0 + ν (r0/L0) x      V_f = π r_f² (L0 − x)
/// r_e = r0 − ν (r0/L0) x      V_e = π r_e² (L0 + x)
/// ```
///
/// Source: Wang and Realmuto 2026, section II-C. `x` in mm, volumes in mm³.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MuscleGeometry {
    /// Radius at x = 0, mm.
    pub radius_mm: f64,
    /// Length at x = 0, mm.
    pub length_mm: f64,
}

impl Default for MuscleGeometry {
    fn default() -> Self {
        Self { radius_mm: NOMINAL_RADIUS_MM, length_mm: NOMINAL_LENGTH_MM }
    }
}

/// The chamber volumes and their slopes at one displacement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MuscleVolumes<S> {
    /// Flexor volume V_f, mm³.
    pub flexor_mm3: S,
    /// Extensor volume V_e, mm³.
    pub extensor_mm3: S,
    /// dV_f/dx, mm².
    pub flexor_slope_mm2: S,
    /// dV_e/dx, mm².
    pub extensor_slope_mm2: S,
}

impl MuscleGeometry {
    /// Checks radius and length.
    ///
    /// # Errors
    /// [`ModelError::NotPositive`] if either is not positive and finite, [`ModelError::OutOfRange`] if it is far
    /// beyond any muscle.
    pub fn validate(&self) -> Result<(), ModelError> {
        ModelError::require_positive("muscle radius (mm)", self.radius_mm)?;
        ModelError::require_positive("muscle length (mm)", self.length_mm)?;
        ModelError::require_within("muscle radius (mm)", self.radius_mm, [1e-3, 1e5])?;
        ModelError::require_within("muscle length (mm)", self.length_mm, [1e-3, 1e6])
    }

    /// Volumes and slopes at displacement `x` for deformation coefficient `nu`.
    ///
    /// With ρ = r0/L0 and dr_f/dx = νρ = −dr_e/dx the slopes are
    /// `dV_f/dx = π [2 r_f (L0 − x) νρ − r_f²]` and `dV_e/dx = −π [2 r_e (L0 + x) νρ − r_e²]`.
    #[inline]
    pub fn volumes<S: Scalar>(&self, x: S, nu: S) -> MuscleVolumes<S> {
        let (r0, l0) = (self.radius_mm, self.length_mm);
        let pi = std::f64::consts::PI;
        let radius_slope = nu.scaled(r0 / l0);
        let spread = radius_slope * x;
        let (rf, re) = (spread + S::constant(r0), -spread + S::constant(r0));
        let (lf, le) = (-x + S::constant(l0), x + S::constant(l0));
        let (rf2, re2) = (rf * rf, re * re);
        MuscleVolumes {
            flexor_mm3: (rf2 * lf).scaled(pi),
            extensor_mm3: (re2 * le).scaled(pi),
            flexor_slope_mm2: ((rf * lf * radius_slope).scaled(2.0) - rf2).scaled(pi),
            extensor_slope_mm2: (re2 - (re * le * radius_slope).scaled(2.0)).scaled(pi),
        }
    }

    /// `[∂V_f/∂ν, ∂V_e/∂ν]` (mm³): `±2π r ρ x (L0 ∓ x)` with the upper signs for the flexor.
    #[inline]
    #[must_use]
    pub fn volume_slopes_by_deformation(&self, x: f64, nu: f64) -> [f64; 2] {
        let (r0, l0) = (self.radius_mm, self.length_mm);
        let ratio = r0 / l0;
        let spread = nu * ratio * x;
        let scale = std::f64::consts::TAU * ratio * x;
        [scale * (r0 + spread) * (l0 - x), -scale * (r0 - spread) * (l0 + x)]
    }

    /// The displacements between which both chambers keep a positive volume, mm: the open interval
    /// where |x| < L0 and both radii are positive.
    #[must_use]
    pub fn displacement_limit_mm(&self, nu: f64) -> f64 {
        self.length_mm.min(self.length_mm / nu.abs())
    }
}
