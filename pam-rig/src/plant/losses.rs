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

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn drive(slip: &mut MaxwellSlip, limit: f64, turns: &[f64], steps: usize) -> f64 {
        let mut at = 0.0;
        for &to in turns {
            for _ in 0..steps {
                slip.advance((to - at) / steps as f64, limit);
            }
            at = to;
        }
        slip.force_n()
    }

    /// Madelung's rules: the force depends on the turning points alone, and a closed minor loop is
    /// forgotten.
    #[test]
    fn memory_is_of_turning_points_and_wiped_out_by_larger_loops() {
        let p = LossParameters::default();
        let limit = p.dry_limit_n(REFERENCE_GAUGE_KPA);
        let fresh = MaxwellSlip::new(&p);
        let fast = drive(&mut fresh.clone(), limit, &[1.0, 0.6, 0.8], 1);
        let slow = drive(&mut fresh.clone(), limit, &[1.0, 0.6, 0.8], 1000);
        assert_relative_eq!(fast, slow, max_relative = 1e-9);
        let with_loop = drive(&mut fresh.clone(), limit, &[1.0, 0.6, 0.8, 0.6, 0.3], 7);
        let without = drive(&mut fresh.clone(), limit, &[1.0, 0.3], 7);
        assert_relative_eq!(with_loop, without, max_relative = 1e-9);
    }

    #[test]
    fn the_force_saturates_at_the_limit_after_the_longest_slip() {
        let p = LossParameters::default();
        let limit = p.dry_limit_n(REFERENCE_GAUGE_KPA);
        let mut slip = MaxwellSlip::new(&p);
        slip.advance(0.9 * p.slip_mm[1], limit);
        assert!(slip.force_n() < limit);
        slip.advance(0.11 * p.slip_mm[1], limit);
        assert_relative_eq!(slip.force_n(), limit, max_relative = 1e-12);
    }
}
