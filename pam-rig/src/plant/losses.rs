//! Losses inside a muscle: strand on strand (with memory) and viscous.

use serde::{Deserialize, Serialize};

/// Number of Maxwell-slip elements per muscle.
pub const SLIP_ELEMENTS: usize = 6;

/// Parameters of the losses of one muscle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LossParameters {
    /// Dry friction of all strands without pressure, N.
    pub dry_n: f64,
    /// Its growth with the gauge pressure that presses strands on each other, N/kPa.
    pub dry_n_per_kpa: f64,
    /// Shortest and longest slip distance of the elements, mm; the others lie between in equal ratios.
    pub slip_mm: [f64; 2],
    /// Viscous coefficient without pressure, N·s/m (kg/s).
    pub viscous_ns_m: f64,
    /// Its growth with the gauge pressure, N·s/m per kPa.
    pub viscous_ns_m_per_kpa: f64,
}

/// Calibrated to the published damping, see `docs/rig.md`.
impl Default for LossParameters {
    fn default() -> Self {
        Self {
            dry_n: 2.0,
            dry_n_per_kpa: 0.0045,
            slip_mm: [0.03, 0.5],
            viscous_ns_m: 620.0,
            viscous_ns_m_per_kpa: 0.7,
        }
    }
}

impl LossParameters {
    /// Dry friction at a gauge pressure, N.
    #[must_use]
    pub fn dry_limit_n(&self, gauge_kpa: f64) -> f64 {
        (self.dry_n + self.dry_n_per_kpa * gauge_kpa).max(0.0)
    }

    /// Viscous coefficient at a gauge pressure, N·s/mm.
    #[must_use]
    pub fn viscous_ns_mm(&self, gauge_kpa: f64) -> f64 {
        1e-3 * (self.viscous_ns_m + self.viscous_ns_m_per_kpa * gauge_kpa).max(0.0)
    }
}

/// Gauge pressure at which the slip distances are meant, kPa.
const REFERENCE_GAUGE_KPA: f64 = 310.0;

/// Maxwell-slip elements in parallel: springs whose far ends slip as soon as the force reaches a
/// limit. Together they give a rate-independent loop with non-local memory (Lampaert, Swevers,
/// Al-Bender 2002). The limits follow the pressure; the stiffnesses stay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaxwellSlip {
    stiffness_n_mm: [f64; SLIP_ELEMENTS],
    force_n: [f64; SLIP_ELEMENTS],
}

impl MaxwellSlip {
    /// Relaxed elements.
    #[must_use]
    pub fn new(p: &LossParameters) -> Self {
        let limit = p.dry_limit_n(REFERENCE_GAUGE_KPA) / SLIP_ELEMENTS as f64;
        let ratio = p.slip_mm[1] / p.slip_mm[0];
        let stiffness_n_mm = std::array::from_fn(|j| {
            let place = j as f64 / (SLIP_ELEMENTS - 1) as f64;
            limit / (p.slip_mm[0] * ratio.powf(place))
        });
        Self { stiffness_n_mm, force_n: [0.0; SLIP_ELEMENTS] }
    }

    /// Moves the muscle by `travel_mm` (contraction) at a total limit; exact for a monotone travel.
    pub fn advance(&mut self, travel_mm: f64, limit_n: f64) {
        let each = limit_n / SLIP_ELEMENTS as f64;
        for (z, k) in self.force_n.iter_mut().zip(self.stiffness_n_mm) {
            *z = (*z + k * travel_mm).clamp(-each, each);
        }
    }

    /// Force against contraction, N.
    #[must_use]
    pub fn force_n(&self) -> f64 {
        self.force_n.iter().sum()
    }

    /// Stiffness of the elements that have not reached their limit, N/mm.
    #[must_use]
    pub fn stiffness_n_mm(&self) -> f64 {
        self.stiffness_n_mm.iter().sum()
    }

    /// Elastic energy in the elements, mJ.
    #[must_use]
    pub fn energy_mj(&self) -> f64 {
        let each = self.force_n.iter().zip(self.stiffness_n_mm);
        each.map(|(z, k)| if k > 0.0 { 0.5 * z * z / k } else { 0.0 }).sum()
    }
}
