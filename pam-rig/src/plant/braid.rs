//! The braid: inextensible strands wound around the bladder.

use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Geometry of the muscle at its nominal length.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BraidParameters {
    /// Length at contraction zero, mm.
    pub length_mm: f64,
    /// Diameter of the braid at that length, mm; it lies in the wall, outside the bore.
    pub diameter_mm: f64,
    /// Angle between strand and axis at that length, deg.
    pub angle_deg: f64,
    /// Diameter of the bore at that length, mm. The wall between bore and braid keeps its volume.
    pub bore_mm: f64,
    /// Volume of fittings, tube and sensor, mm³.
    pub dead_volume_mm3: f64,
}

/// Festo DMSP-10-200N: 10 mm bore, 200 mm, braid angle 25° (Wang and Realmuto 2026, table I). The
/// diameter of the braid and the dead volume are calibrated, see `docs/rig.md`.
impl Default for BraidParameters {
    fn default() -> Self {
        Self {
            length_mm: 200.0,
            diameter_mm: 11.2,
            angle_deg: 25.0,
            bore_mm: 10.0,
            dead_volume_mm3: 12e3,
        }
    }
}

/// The braid's kinematics (Chou and Hannaford 1996): a strand of length b that makes n turns lies on
/// a cylinder of length L and diameter D with `b² = L² + (n π D)²`, so that
///
/// ```text
/// V_braid(L) = (b² − L²) L / (4 π n²)
/// −dV/dc = dV/dL = (b² − 3 L²) / (4 π n²),    c = L₀ − L
/// ```
///
/// and a gauge pressure p pulls with the axial force `p dV/dc` by virtual work.
#[derive(Debug, Clone, Copy)]
pub struct Braid {
    length_mm: f64,
    strand_squared: f64,
    per_turns: f64,
    offset_mm3: f64,
}

impl Braid {
    /// The braid of a muscle.
    #[must_use]
    pub fn new(p: &BraidParameters) -> Self {
        let (sine, cosine) = p.angle_deg.to_radians().sin_cos();
        let strand = p.length_mm / cosine;
        let turns = strand * sine / (PI * p.diameter_mm);
        let mut braid = Self {
            length_mm: p.length_mm,
            strand_squared: strand * strand,
            per_turns: 1.0 / (4.0 * PI * turns * turns),
            offset_mm3: 0.0,
        };
        let bore_mm3 = 0.25 * PI * p.bore_mm * p.bore_mm * p.length_mm;
        braid.offset_mm3 = bore_mm3 + p.dead_volume_mm3 - braid.volume_mm3(0.0);
        braid
    }

    /// Volume of the gas at a contraction, dead volume included, mm³.
    #[must_use]
    pub fn volume_mm3(&self, contraction_mm: f64) -> f64 {
        let length = self.length_mm - contraction_mm;
        (self.strand_squared - length * length) * length * self.per_turns + self.offset_mm3
    }

    /// dV/dc, mm²: the area with which the gauge pressure pulls.
    #[must_use]
    pub fn area_mm2(&self, contraction_mm: f64) -> f64 {
        let length = self.length_mm - contraction_mm;
        (3.0 * length * length - self.strand_squared) * self.per_turns
    }

    /// d²V/dc², mm; negative: a muscle pulls less the shorter it is.
    #[must_use]
    pub fn area_slope_mm(&self, contraction_mm: f64) -> f64 {
        -6.0 * (self.length_mm - contraction_mm) * self.per_turns
    }
}
