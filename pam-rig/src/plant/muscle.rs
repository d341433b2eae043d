//! One McKibben muscle at the end of a tendon.

use super::braid::{Braid, BraidParameters};
use super::gas::{Chamber, HeatExchange};
use super::losses::{LossParameters, MaxwellSlip};
use super::wall::WallParameters;
use pam_core::units::ATMOSPHERE_KPA;
use serde::{Deserialize, Serialize};

/// Parameters of a muscle.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MuscleParameters {
    /// The braid and the volumes.
    pub braid: BraidParameters,
    /// The elastic wall.
    pub wall: WallParameters,
    /// Dry and viscous losses.
    pub losses: LossParameters,
}

/// Volume of the gas as a function of the contraction c: `V_gas = V(0) (V(c)/V(0))^exponent`, with c limited
/// by the largest contraction.
///
/// The plain muscle has exponent 1 and no limits. An exponent n makes isothermal air obey
/// `P Vⁿ = const`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VolumeLaw {
    /// Exponent of the volume ratio.
    pub exponent: f64,
    /// Largest contraction that the chamber follows, mm.
    pub largest_contraction_mm: f64,
}

impl Default for VolumeLaw {
    fn default() -> Self {
        Self { exponent: 1.0, largest_contraction_mm: f64::INFINITY }
    }
}

/// A muscle in motion. It can only pull: where its tension would become negative the tendon goes
/// slack, and the muscle creeps along its own force-free length until the tendon is taut again.
#[derive(Debug, Clone, Copy)]
pub struct Muscle {
    braid: Braid,
    wall: WallParameters,
    losses: LossParameters,
    law: VolumeLaw,
    volume_at_rest_mm3: f64,
    contraction_mm: f64,
    slip: MaxwellSlip,
    slack: bool,
    /// The air inside.
    pub air: Chamber,
}

impl Muscle {
    /// A muscle at its nominal length with air at room temperature.
    #[must_use]
    pub fn new(p: &MuscleParameters, law: VolumeLaw, exchange: HeatExchange, kpa: f64) -> Self {
        let braid = Braid::new(&p.braid);
        let volume = braid.volume_mm3(0.0);
        Self {
            braid,
            wall: p.wall,
            losses: p.losses,
            law,
            volume_at_rest_mm3: volume,
            contraction_mm: 0.0,
            slip: MaxwellSlip::new(&p.losses),
            slack: false,
            air: Chamber::at_rest(kpa, volume, 0.5 * p.braid.bore_mm, exchange),
        }
    }

    /// Contraction, mm: that of the tendon when taut, less when slack.
    #[must_use]
    pub fn contraction_mm(&self) -> f64 {
        self.contraction_mm
    }

    /// `true` if the tendon is slack.
    #[must_use]
    pub fn is_slack(&self) -> bool {
        self.slack
    }

    /// Gauge pressure, kPa.
    #[must_use]
    pub fn gauge_kpa(&self) -> f64 {
        self.air.pressure_kpa() - ATMOSPHERE_KPA
    }

    /// Gives the gas another law of its volume.
    pub(super) fn set_law(&mut self, law: VolumeLaw) {
        if law != self.law {
            self.law = law;
            self.air.compress(self.gas_volume_mm3(self.contraction_mm));
        }
    }

    /// Volume of the gas at a contraction, mm³.
    #[must_use]
    pub fn gas_volume_mm3(&self, contraction_mm: f64) -> f64 {
        self.following_volume_mm3(contraction_mm.min(self.law.largest_contraction_mm))
    }

    /// Volume of the gas at a contraction without a largest one, mm³.
    #[must_use]
    pub fn following_volume_mm3(&self, contraction_mm: f64) -> f64 {
        let volume = self.braid.volume_mm3(contraction_mm);
        if self.law.exponent == 1.0 {
            return volume;
        }
        self.volume_at_rest_mm3 * (volume / self.volume_at_rest_mm3).powf(self.law.exponent)
    }

    /// Tension without motion at a contraction and a gauge pressure, without the losses, N. Negative
    /// where the muscle would push.
    #[must_use]
    pub fn elastic_tension_n(&self, contraction_mm: f64, gauge_kpa: f64) -> f64 {
        1e-3 * gauge_kpa * self.braid.area_mm2(contraction_mm) + self.wall.tension_n(contraction_mm)
    }

    /// Tension without motion as the muscle is now, with its dry losses, and its viscous coefficient
    /// (N, N·s/mm). Both are zero when slack.
    #[must_use]
    pub fn pull(&self) -> (f64, f64) {
        if self.slack {
            return (0.0, 0.0);
        }
        let gauge = self.gauge_kpa();
        let tension = self.elastic_tension_n(self.contraction_mm, gauge) - self.slip.force_n();
        (tension, self.losses.viscous_ns_mm(gauge))
    }

    /// Moves on for a time with the tendon's end at `tendon_mm` (the contraction of a taut muscle)
    /// moving at `rate_mm_s`.
    pub fn follow(&mut self, tendon_mm: f64, rate_mm_s: f64, time_s: f64) {
        if !self.slack && tendon_mm == self.contraction_mm {
            // Nothing moved, but the pressure may have changed the limits and the sign.
            let gauge = self.gauge_kpa();
            self.slip.advance(0.0, self.losses.dry_limit_n(gauge));
            self.slack = self.elastic_tension_n(tendon_mm, gauge) < self.slip.force_n();
            return;
        }
        let gauge = self.gauge_kpa();
        let limit = self.losses.dry_limit_n(gauge);
        let viscous = self.losses.viscous_ns_mm(gauge);
        let mut to = tendon_mm;
        if !self.slack {
            let mut slip = self.slip;
            slip.advance(tendon_mm - self.contraction_mm, limit);
            let tension =
                self.elastic_tension_n(tendon_mm, gauge) - slip.force_n() - viscous * rate_mm_s;
            self.slack = tension < 0.0;
        }
        if self.slack {
            // Massless end: viscous force balances the rest; one linearly implicit step.
            let c = self.contraction_mm;
            let force = self.elastic_tension_n(c, gauge) - self.slip.force_n();
            let stiffness = self.wall.slope_n_mm(c) - 1e-3 * gauge * self.braid.area_slope_mm(c)
                + self.slip.stiffness_n_mm()
                + 1e-3 * self.air.pressure_kpa() * self.braid.area_mm2(c).powi(2)
                    / self.air.volume_mm3();
            let resistance = viscous + time_s * stiffness;
            let free = if resistance > 0.0 { c + time_s * force / resistance } else { c };
            if free >= tendon_mm {
                self.slack = false;
            } else {
                to = free;
            }
        }
        self.slip.advance(to - self.contraction_mm, limit);
        self.contraction_mm = to;
        self.air.compress(self.gas_volume_mm3(to));
    }

    /// Tension of the tendon while its end moves at a rate, N; never negative.
    #[must_use]
    pub fn tension_n(&self, rate_mm_s: f64) -> f64 {
        let (tension, viscous) = self.pull();
        (tension - viscous * rate_mm_s).max(0.0)
    }

    /// Elastic energy of wall and strands and availability of the air, mJ.
    #[must_use]
    pub fn energy_mj(&self) -> f64 {
        self.wall.energy_mj(self.contraction_mm)
            + self.slip.energy_mj()
            + 1e-3 * self.air.availability_uj()
    }
}
