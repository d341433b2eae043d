//! The effects that act at a moment, as plain numbers.

use super::Hidden;
use super::laws::Laws;
use std::f64::consts::TAU;

/// Every effect of a moment; absent ones have the value that changes nothing. Forces in mN.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Acting {
    pub coulomb_mn: f64,
    /// Coulomb and static level (mN), velocity (mm/s).
    pub stribeck: Option<[f64; 3]>,
    /// mN per kPa of mean gauge pressure.
    pub load_friction: f64,
    /// kg/s, that is mN per mm/s.
    pub damping: f64,
    /// Force (mN), slip (mm), exponent.
    pub hysteresis: Option<[f64; 3]>,
    /// Stiffness (mN/mm), time constant (s).
    pub creep: Option<[f64; 2]>,
    pub load_mn: f64,
    pub added_kg: f64,
    pub half_gap_mm: f64,
    /// Force (mN), wave number (rad/mm).
    pub cogging: [f64; 2],
    /// Displacement (mm), loss.
    pub slack: Option<[f64; 2]>,
    pub drift_per_s: f64,
    pub scale: f64,
    pub leak_per_s: [f64; 2],
    pub exponent: f64,
    pub geometry: f64,
    pub force_gain: f64,
    pub limit_mn: f64,
    pub actuation_delay_s: f64,
    /// Rates of first-order lags, rad/s; infinite without.
    pub actuator_rate: f64,
    pub pressure_rate: f64,
    pub position_rate: f64,
    pub pressure_delay_s: f64,
    pub position_delay_s: f64,
    pub pressure_bias_kpa: [f64; 2],
    pub pressure_gain: [f64; 2],
    pub offset_mm: f64,
    pub position_gain: f64,
    /// Force (mN), angular frequency (rad/s).
    pub periodic: [f64; 2],
    pub crosstalk_per_s: f64,
    /// Period and duration, s.
    pub freeze: Option<[f64; 2]>,
    /// Laws that no list has.
    pub laws: Laws,
}

impl Acting {
    fn nothing() -> Self {
        Self {
            coulomb_mn: 0.0,
            stribeck: None,
            load_friction: 0.0,
            damping: 0.0,
            hysteresis: None,
            creep: None,
            load_mn: 0.0,
            added_kg: 0.0,
            half_gap_mm: 0.0,
            cogging: [0.0, 1.0],
            slack: None,
            drift_per_s: 0.0,
            scale: 0.0,
            leak_per_s: [0.0; 2],
            exponent: 1.0,
            geometry: 0.0,
            force_gain: 0.0,
            limit_mn: f64::INFINITY,
            actuation_delay_s: 0.0,
            actuator_rate: f64::INFINITY,
            pressure_rate: f64::INFINITY,
            position_rate: f64::INFINITY,
            pressure_delay_s: 0.0,
            position_delay_s: 0.0,
            pressure_bias_kpa: [0.0; 2],
            pressure_gain: [0.0; 2],
            offset_mm: 0.0,
            position_gain: 0.0,
            periodic: [0.0; 2],
            crosstalk_per_s: 0.0,
            freeze: None,
            laws: Laws::default(),
        }
    }

    /// What acts at time `t` (s).
    ///
    /// # Panics
    /// If the plant does not know an effect.
    pub(super) fn at(effects: &[Hidden], t: f64) -> Self {
        let mut all = Self::nothing();
        effects.iter().filter(|h| t >= h.begins_s() - 1e-9).for_each(|h| all.add(h));
        all
    }

    fn add(&mut self, h: &Hidden) {
        let v = |name: &str| h.get(name);
        let sides = |a: &str, b: &str| [h.get(a), h.get(b)];
        match h.id.as_str() {
            "coulomb_friction" => self.coulomb_mn += 1e3 * v("force_n"),
            "stribeck_friction" => {
                let levels = [v("coulomb_n"), v("static_n")].map(|n| 1e3 * n);
                self.stribeck = Some([levels[0], levels[1], v("velocity_mm_s")]);
            }
            "load_friction" => self.load_friction += 1e3 * v("force_n_per_kpa"),
            "viscous_damping" => self.damping += v("coefficient_ns_m"),
            "hysteresis" => {
                self.hysteresis = Some([1e3 * v("force_n"), v("slip_mm"), v("bouc_wen_exponent")]);
            }
            "creep" => self.creep = Some([1e3 * v("stiffness_n_mm"), v("time_constant_s")]),
            "constant_load" => self.load_mn += 1e3 * v("force_n"),
            "added_inertia" => self.added_kg += v("mass_kg"),
            "backlash" => self.half_gap_mm = 0.5 * v("gap_mm"),
            "cogging" => self.cogging = [1e3 * v("force_n"), TAU / v("pitch_mm")],
            "tendon_slack" => self.slack = Some([v("displacement_mm"), v("stiffness_loss")]),
            "stiffness_drift" => self.drift_per_s += v("relative_per_min") / 60.0,
            "stiffness_scale" => self.scale += v("relative"),
            "leak" => self.leak_per_s = sides("flexor_rate_per_s", "extensor_rate_per_s"),
            "polytropic_gas" => self.exponent = v("exponent"),
            "geometry_coefficient" => self.geometry += v("relative"),
            "force_gain" => self.force_gain += v("relative"),
            "force_saturation" => self.limit_mn = 1e3 * v("force_n"),
            "actuation_delay" => self.actuation_delay_s = 1e-3 * v("delay_ms"),
            "actuator_lag" => self.actuator_rate = TAU * v("cutoff_hz"),
            "pressure_sensor_lag" => self.pressure_rate = TAU * v("cutoff_hz"),
            "position_sensor_lag" => self.position_rate = TAU * v("cutoff_hz"),
            "pressure_delay" => self.pressure_delay_s = 1e-3 * v("delay_ms"),
            "position_delay" => self.position_delay_s = 1e-3 * v("delay_ms"),
            "pressure_bias" => self.pressure_bias_kpa = sides("flexor_kpa", "extensor_kpa"),
            "pressure_gain" => {
                self.pressure_gain = sides("flexor_relative", "extensor_relative");
            }
            "position_offset" | "tendon_slip" => self.offset_mm += v("offset_mm") + v("slip_mm"),
            "position_gain" => self.position_gain += v("relative"),
            "sensor_gain_jump" => self.pressure_gain[0] += v("relative"),
            "periodic_disturbance" => {
                self.periodic = [1e3 * v("force_n"), TAU * v("frequency_hz")];
            }
            "chamber_crosstalk" => self.crosstalk_per_s += v("rate_per_s"),
            "encoder_freeze" => self.freeze = Some([v("period_s"), v("duration_s")]),
            // An event, no state: see `injected_g`.
            "valve_glitch" => {}
            other => {
                let known = self.laws.add(h);
                assert!(known, "the plant knows no effect `{other}`");
            }
        }
    }
}

/// Air that enters the flexor at a time of [`changes`], g.
pub(super) fn injected_g(effects: &[Hidden], time_s: f64) -> f64 {
    let now = effects.iter().filter(|h| h.id == "valve_glitch" && h.begins_s() == time_s);
    now.map(|h| 1e-3 * h.get("mass_mg")).sum()
}

/// Times at which something begins, s, in order.
pub(super) fn changes(effects: &[Hidden]) -> Vec<f64> {
    let mut times: Vec<f64> = effects.iter().map(Hidden::begins_s).filter(|&t| t > 0.0).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    times
}
