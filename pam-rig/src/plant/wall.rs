//! The wall: rubber and strands that are strained with the muscle's length.

use serde::{Deserialize, Serialize};

/// Elastic tension of the wall over the stretch s = −c (mm):
///
/// ```text
/// T(s) = toe_stiffness · w · ln(1 + exp((s + s₀)/w)) + stiffness · s
/// ```
///
/// The first term is the strands: slack when the muscle is short, taut (with the slope
/// `toe_stiffness`) when it is long, the toe of width w between. s₀ holds the manual preload. The
/// second term is the rubber, which also pushes back when the muscle contracts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WallParameters {
    /// Slope of the taut strands, N/mm.
    pub toe_stiffness_n_mm: f64,
    /// Width w of the toe, mm.
    pub toe_width_mm: f64,
    /// Stretch s₀ of the strands at contraction zero, from the preload, mm.
    pub preload_mm: f64,
    /// Stiffness of the rubber, N/mm.
    pub stiffness_n_mm: f64,
}

/// Calibrated to the published stiffnesses, see `docs/rig.md`.
impl Default for WallParameters {
    fn default() -> Self {
        Self {
            toe_stiffness_n_mm: 39.0,
            toe_width_mm: 0.53,
            preload_mm: 0.85,
            stiffness_n_mm: 30.0,
        }
    }
}

impl WallParameters {
    /// Tension at a contraction, N.
    #[must_use]
    pub fn tension_n(&self, contraction_mm: f64) -> f64 {
        let w = self.toe_width_mm;
        let strands = w * softplus((self.preload_mm - contraction_mm) / w);
        self.toe_stiffness_n_mm * strands - self.stiffness_n_mm * contraction_mm
    }

    /// −dT/dc, N/mm.
    #[must_use]
    pub fn slope_n_mm(&self, contraction_mm: f64) -> f64 {
        let u = (self.preload_mm - contraction_mm) / self.toe_width_mm;
        self.toe_stiffness_n_mm / (1.0 + (-u).exp()) + self.stiffness_n_mm
    }

    /// Elastic energy relative to contraction zero, mJ (N·mm): −∫ T dc by Gauss's rule.
    #[must_use]
    pub fn energy_mj(&self, contraction_mm: f64) -> f64 {
        // Five points on short pieces: exact to rounding for the smooth toe.
        const NODES: [(f64, f64); 3] = [
            (0.0, 0.568_888_888_888_888_9),
            (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
            (0.906_179_845_938_664, 0.236_926_885_056_189_08),
        ];
        let pieces = (8.0 * contraction_mm.abs() / self.toe_width_mm).ceil().max(1.0);
        let half = 0.5 * contraction_mm / pieces;
        let mut sum = 0.0;
        for piece in 0..pieces as usize {
            let middle = (2 * piece + 1) as f64 * half;
            for (node, weight) in NODES {
                let both = self.tension_n(middle + half * node)
                    + if node == 0.0 { 0.0 } else { self.tension_n(middle - half * node) };
                sum += weight * both;
            }
        }
        -half * sum
    }
}

/// ln(1 + eᵘ) without overflow.
fn softplus(u: f64) -> f64 {
    u.max(0.0) + (-u.abs()).exp().ln_1p()
}
