//! Laws that stand in no list of effects.

use super::{ATMOSPHERE_KPA, Hidden};

/// Strengths of all laws; those that are not hidden are zero. Forces in mN.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Laws {
    /// `−k x³`: mN/mm³.
    cubic: f64,
    /// `−c v |v|`: mN s²/mm².
    drag: f64,
    /// `−c (P_f + P_e − 2 P_atm) v`: mN s/(mm kPa).
    pressure_damping: f64,
    /// `−c x² v`: mN s/mm³.
    displacement_damping: f64,
    /// `−c max(v, 0)`: mN s/mm.
    one_way_damping: f64,
    /// `−k max(x − x₀, 0)`: mN/mm, mm.
    stop: [f64; 2],
    /// Dry friction `c (P_f − P_atm)`: mN/kPa.
    flexor_friction: f64,
    /// Dry friction `c (P_f + P_e − 2 P_atm)`: mN/kPa.
    pressure_friction: f64,
    /// `−a z` with `ż = (F − z)/τ` for the force F of the motor: a, s.
    second_path: [f64; 2],
    /// `−c z v` with `ż = (v² − z)/τ`: mN s³/mm³, s.
    warming: [f64; 2],
    /// The reading of P_e has this share of P_f − P_e.
    reading_crosstalk: f64,
}

/// What the laws remember.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Kept {
    /// Low-passed force of the motor, mN.
    path_mn: f64,
    /// Low-passed square of the velocity, mm²/s².
    heat: f64,
}

impl Laws {
    /// Adds a hidden law; `false` if there is none of this id.
    pub(super) fn add(&mut self, h: &Hidden) -> bool {
        let v = |name: &str| h.get(name);
        match h.id.as_str() {
            "cubic_spring" => self.cubic += 1e3 * v("n_mm3"),
            "quadratic_drag" => self.drag += 1e3 * v("n_s2_mm2"),
            "pressure_damping" => self.pressure_damping += 1e3 * v("n_s_mm_kpa"),
            "displacement_damping" => self.displacement_damping += 1e3 * v("n_s_mm3"),
            "one_way_damping" => self.one_way_damping += 1e3 * v("n_s_mm"),
            "soft_stop" => self.stop = [1e3 * v("n_mm"), v("from_mm")],
            "flexor_friction" => self.flexor_friction += 1e3 * v("n_kpa"),
            "pressure_friction" => self.pressure_friction += 1e3 * v("n_kpa"),
            "second_path" => self.second_path = [v("share"), v("time_s")],
            "warming_damping" => self.warming = [1e3 * v("n_s3_mm3"), v("time_s")],
            "reading_crosstalk" => self.reading_crosstalk += v("share"),
            _ => return false,
        }
        true
    }

    /// Force on the joint, mN, `ahead_s` after what is kept.
    pub(super) fn force_mn(
        &self,
        x: f64,
        v: f64,
        kpa: [f64; 2],
        motor_mn: f64,
        kept: Kept,
        ahead_s: f64,
    ) -> f64 {
        let gauge = kpa[0] + kpa[1] - 2.0 * ATMOSPHERE_KPA;
        let kept = self.moved(kept, v, motor_mn, ahead_s);
        -self.cubic * x * x * x
            - self.drag * v * v.abs()
            - self.pressure_damping * gauge * v
            - self.displacement_damping * x * x * v
            - self.one_way_damping * v.max(0.0)
            - self.stop[0] * (x - self.stop[1]).max(0.0)
            - self.second_path[0] * kept.path_mn
            - self.warming[0] * kept.heat * v
    }

    /// Largest dry friction, mN.
    pub(super) fn dry_mn(&self, kpa: [f64; 2]) -> f64 {
        let gauge = kpa.map(|p| p - ATMOSPHERE_KPA);
        self.flexor_friction * gauge[0] + self.pressure_friction * (gauge[0] + gauge[1])
    }

    /// What is kept `dt` s later, for a velocity and a force that stay.
    pub(super) fn moved(&self, kept: Kept, v: f64, motor_mn: f64, dt: f64) -> Kept {
        let low_passed = |old: f64, to: f64, time_s: f64| {
            if time_s > 0.0 { old + (to - old) * (1.0 - (-dt / time_s).exp()) } else { old }
        };
        Kept {
            path_mn: low_passed(kept.path_mn, motor_mn, self.second_path[1]),
            heat: low_passed(kept.heat, v * v, self.warming[1]),
        }
    }

    /// Readings of the pressures for true ones, kPa.
    pub(super) fn readings(&self, kpa: [f64; 2]) -> [f64; 2] {
        [kpa[0], kpa[1] + self.reading_crosstalk * (kpa[0] - kpa[1])]
    }
}
