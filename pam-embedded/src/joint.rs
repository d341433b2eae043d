//! The joint's own numbers: gas law and geometry.

use core::f64::consts::PI;

/// Mass, gas and geometry of a joint (Wang and Realmuto 2026, section II).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joint {
    /// Reflected mass m, kg.
    pub mass_kg: f64,
    /// Gas coefficient C, kPa·mm³/g.
    pub gas_coefficient: f64,
    /// Deformation coefficient ν.
    pub deformation: f64,
    /// Radius of a muscle at x = 0, mm.
    pub radius_mm: f64,
    /// Length of a muscle at x = 0, mm.
    pub length_mm: f64,
}

impl Joint {
    /// Volumes of flexor and extensor at a displacement, mm³: `π (r0 ± ν r0 x / L0)² (L0 ∓ x)`.
    #[must_use]
    pub fn volumes_mm3(&self, displacement_mm: f64) -> [f64; 2] {
        let spread = self.deformation * self.radius_mm / self.length_mm * displacement_mm;
        let (r_f, r_e) = (self.radius_mm + spread, self.radius_mm - spread);
        [
            PI * r_f * r_f * (self.length_mm - displacement_mm),
            PI * r_e * r_e * (self.length_mm + displacement_mm),
        ]
    }

    /// Pressures of sealed air, `P_i = C m_i / V_i`, kPa absolute.
    #[must_use]
    pub fn pressures_kpa(&self, displacement_mm: f64, masses_g: [f64; 2]) -> [f64; 2] {
        let [v_f, v_e] = self.volumes_mm3(displacement_mm);
        [self.gas_coefficient * masses_g[0] / v_f, self.gas_coefficient * masses_g[1] / v_e]
    }

    /// Air that has these pressures, `m_i = P_i V_i / C`, g.
    #[must_use]
    pub fn masses_g(&self, displacement_mm: f64, pressures_kpa: [f64; 2]) -> [f64; 2] {
        let [v_f, v_e] = self.volumes_mm3(displacement_mm);
        [
            pressures_kpa[0] * v_f / self.gas_coefficient,
            pressures_kpa[1] * v_e / self.gas_coefficient,
        ]
    }
}
