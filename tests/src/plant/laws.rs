//! Laws that stand in no list of effects.

use super::{ATMOSPHERE_KPA, Hidden};
use std::f64::consts::{PI, TAU};

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
    /// Dry friction `c |x|`: mN/mm.
    edge_friction: f64,
    /// `−k x⁴`: mN/mm⁴.
    quartic: f64,
    /// `−c (P_e − P_atm) v`: mN s/(mm kPa).
    extensor_damping: f64,
    /// `−a tanh(v/w)`: mN, mm/s.
    saturating_damping: [f64; 2],
    /// `−c (P_f + P_e − 2 P_atm) sin(2π x/p)`: mN/kPa, mm.
    pressure_ripple: [f64; 2],
    /// `c max(−v, 0)²`: mN s²/mm².
    one_sided_drag: f64,
    /// `−c (P_f + P_e − 2 P_atm) z` with the stretch z of a Maxwell-slip element: mN/kPa, slip distance in mm.
    pressure_hysteresis: [f64; 2],
    /// `−c (P_f + P_e − 2 P_atm) z` with `ż = v − z/τ`: mN/(mm kPa), s.
    pressure_relaxation: [f64; 2],
    /// `−c x v`: mN s/mm².
    position_coupling: f64,
    /// Air out of the flexor `c (P_f − P_atm) |v|`: g/(mm kPa).
    moving_leak: f64,
    /// Air from flexor to extensor `c (P_f − P_e) |P_f − P_e|`: g/(s kPa²).
    turbulent_crosstalk: f64,
    /// Dry friction `c z` with `ż = (|v| − z)/τ`: mN s/mm, s.
    running_friction: [f64; 2],
    /// `−c exp(−t/τ) v`: mN s/mm, s.
    fading_damping: [f64; 2],
    /// Dry friction `c (P_e − P_atm)`: mN/kPa.
    extensor_friction: f64,
    /// `−k w [sinh(x/w) − x/w]`: mN/mm, mm.
    stiffening: [f64; 2],
    /// `−c v max(|x| − x₀, 0)`: mN s/mm², mm.
    outer_damping: [f64; 2],
    /// `−c (P_f − P_e) v`: mN s/(mm kPa).
    difference_damping: f64,
    /// `k x |x|` of either sign: mN/mm².
    quadratic_spring: f64,
    /// Air from flexor to extensor `c (P_f − P_e) max(x, 0)`: g/(s mm kPa).
    opening_crosstalk: f64,
    /// The reading of P_f has `a (P_f − P_atm)²`: 1/kPa.
    bent_pressure: f64,
    /// The reading of x has `a x²`: 1/mm.
    bent_position: f64,
    /// `−k x z` with `ż = (v² − z)/τ`: mN s²/mm³, s.
    worked_spring: [f64; 2],
    /// `−c z v` with `ż = (|F| − z)/τ` for the force F of the motor: s/mm, s.
    loaded_damping: [f64; 2],
    /// `−c v / (1 + (x/w)²)`: mN s/mm, mm.
    central_damping: [f64; 2],
    /// `−c (P_f − P_atm) x²`: mN/(mm² kPa).
    pressure_bow: f64,
    /// Air out of the flexor `c (P_f − P_atm)²`: g/(s kPa²).
    square_leak: f64,
    /// Dry friction `c z` with `ż = (|F| − z)/τ` for the force F of the motor: 1, s.
    lasting_friction: [f64; 2],
    /// `−k z` with `ż = (x |x| − z)/τ`: mN/mm², s.
    creeping_spring: [f64; 2],
    /// The reading of P_e has `c x²`: kPa/mm².
    strained_pressure: f64,
    /// `a sin(2π f t + φ)` from the beginning of the excitation on: mN, Hz, rad.
    fan: [f64; 3],
    /// `−k (P_f − P_e) x`: mN/(mm kPa).
    difference_spring: f64,
    /// `−c max(−x, 0) v`: mN s/mm².
    stretched_damping: f64,
    /// `−c x F` for the force F of the motor: 1/mm.
    moment_arm: f64,
    /// `−c z F` with `ż = (F² − z)/τ` for the force F of the motor: 1/N², s.
    motor_heating: [f64; 2],
    /// Dry friction `c (P_f − P_atm) |x|`: mN/(mm kPa).
    braid_friction: f64,
    /// Air out of the extensor `c (P_e − P_atm) max(x, 0)`: g/(s mm kPa).
    stretch_leak: f64,
    /// P_f has `−c z` and P_e has `c z` with `ż = v − z/τ`: kPa/mm, s.
    heated_air: [f64; 2],
    /// The reading of P_f has `−c |F|` for the force F of the motor: kPa/mN.
    supply_sag: f64,
    /// The reading of x has `−a x³`: 1/mm².
    hall_position: f64,
    /// `−k (P_f − P_atm) x`, a hose that stiffens under pressure: mN/(mm kPa).
    hose_spring: f64,
    /// `−a tanh(x/w)`, a cable that yields: mN, mm.
    yielding_cable: [f64; 2],
    /// `a (1 − exp(−t/τ))` from the beginning of the excitation on: mN, s.
    amplifier_drift: [f64; 2],
    /// `−c (P_e − P_atm) max(v, 0)`, while the extensor is stretched: mN s/(mm kPa).
    braid_brake: f64,
    /// `k z x` with `ż = (|x| − z)/τ`, a rubber that softens with its strain: mN/mm², s.
    strain_softening: [f64; 2],
    /// Dry friction `c |F|` for the force F of the motor: 1.
    gear_friction: f64,
    /// Dry friction `c |P_f − P_e|`: mN/kPa.
    tilt_friction: f64,
    /// Air out of the extensor `c max(P_e − P_atm − p₀, 0)`: g/(s kPa), kPa.
    opening_seal: [f64; 2],
    /// The reading of x has `a sin(2π x/p)`: mm, mm.
    encoder_interpolation: [f64; 2],
    /// The reading of x has `c z` with `ż = (F² − z)/τ` for the force F of the motor: mm/N², s.
    warming_encoder: [f64; 2],
    /// `−c (1 − z) v` with `ż = |v| (1 − z)/d − z/τ`, a grease that is broken down by shear and builds up again: mN s/mm, mm, s.
    thixotropy: [f64; 3],
    /// `k max(−x − x₀, 0)^(3/2)`, a round bumper (Hertz): mN/mm^(3/2), mm.
    hertz_stop: [f64; 2],
    /// `−c v / (1 + (v/w)²)`, an eddy-current brake: mN s/mm, mm/s.
    eddy_brake: [f64; 2],
    /// `−c (P_f + P_e − 2 P_atm) x³`, a braid that locks: mN/(mm³ kPa).
    pressure_hardening: f64,
    /// `−c F sin(2π x/p)` for the force F of the motor: 1, mm.
    torque_ripple: [f64; 2],
    /// Dry friction `c exp(−(x/w)²)`, a seal that has settled in the middle: mN, mm.
    seal_ridge: [f64; 2],
    /// Air from flexor to extensor `c max(P_f − P_e, 0)`: g/(s kPa).
    check_valve: f64,
    /// P_f and P_e have `c z` with `ż = (|v| − z)/τ`, air that is warmed by the rubbing braid: kPa s/mm, s.
    friction_heat: [f64; 2],
    /// The reading of P_e has `−a max(P_e − P_atm − p₀, 0)`, near the end of its range: 1, kPa.
    sensor_range: [f64; 2],
    /// The reading of x has `c (P_f − P_e)`, a frame that bends: mm/kPa.
    frame_bending: f64,
    /// `−a (x/w) exp(−(x/w)²)`, a magnet that pulls towards the middle: mN, mm.
    magnet_detent: [f64; 2],
    /// `−c (P_f − P_e) F` for the force F of the motor, whose frame is racked by the pressures: 1/kPa.
    racked_frame: f64,
    /// `−c t v` from the beginning of the excitation on, a grease that creeps into a gap: mN/mm.
    creeping_grease: f64,
    /// `−k z` with `ż = v − b z |z|`, a spring in series with an orifice: mN/mm, 1/(mm s).
    orifice_relaxation: [f64; 2],
    /// Dry friction `c sin²(π x/p)`, a bearing with dents at the pitch of its balls: mN, mm.
    brinelled_bearing: [f64; 2],
    /// Dry friction `c |z|` with `ż = v − z/τ`, a braid that settles where it stays: mN/mm, s.
    settled_braid: [f64; 2],
    /// Air from flexor to extensor `c (P_f − P_e) / √(|P_f − P_e| + 1 kPa)`: g/(s √kPa).
    orifice_crosstalk: f64,
    /// Air out of the extensor `c (P_e − P_atm) max(v, 0)`: g/(mm kPa).
    pumping_seal: f64,
    /// The reading of P_e has `c max(F − F₀, 0)` for the force F of the motor, which pinches the tube: kPa/mN, mN.
    pinched_gauge: [f64; 2],
    /// The reading of x has `a max(x − x₀, 0)`, a scale that is joined of two pieces: 1, mm.
    joined_scale: [f64; 2],
    /// `−c F |v|` for the force F of the motor, whose iron and windings take more at speed: s/mm.
    core_loss: f64,
    /// `−c (P_f − P_atm) x |x|`, end caps that bulge: mN/(mm² kPa).
    bladder_bulge: f64,
    /// `−a tanh(z/w)` with `ż = v − z/τ`, a bonded rubber that softens with its amplitude: mN, mm, s.
    payne_bushing: [f64; 3],
    /// Dry friction `c (P_e − P_atm) exp(x/w)`, a tendon that wraps further around a pin: mN/kPa, mm.
    capstan_friction: [f64; 2],
    /// Dry friction `a sin²(π x/p)`, teeth that mesh: mN, mm.
    mesh_friction: [f64; 2],
    /// Air out of the flexor `c (P_f − P_atm) max(F − F₀, 0)` for the force F of the motor: g/(s kPa N), N.
    tilting_fitting: [f64; 2],
    /// Air out of the extensor `c (P_e − P_atm) t` from the beginning of the excitation on: g/(s² kPa).
    growing_tear: f64,
    /// The readings of P_f and P_e have `a sin(2π f t)` from the beginning of the excitation on: kPa, Hz.
    sampling_beat: [f64; 2],
    /// The reading of P_f has `c v |v|`, behind a narrow fitting: kPa s²/mm².
    tube_drop: f64,
    /// The reading of x has `c z` with `ż = (F − z)/τ` for the force F of the motor: mm/N, s.
    tendon_elongation: [f64; 2],
    /// Air out of the extensor `c (P_e² − P_atm²)`, laminar through a fine crack: g/(s kPa²).
    seam_leak: f64,
    /// Dry friction `c x²`, a guide that is worn in its middle: mN/mm².
    worn_guide: f64,
    /// Dry friction `a exp(−t/τ)` from the beginning of the excitation on, a grease that spreads: mN, s.
    running_in: [f64; 2],
    /// Air from flexor to extensor `c (P_f − P_e)`, laminar over the block of the valves: g/(s kPa).
    cross_leak: f64,
    /// The reading of x has `c F` for the force F of the motor, under which the frame of the sensor gives: mm/mN.
    frame_give: f64,
    /// P_f has `−c z` with `ż = v − z/τ`, air whose heat leaves to the wall: kPa/mm, s.
    flexor_heat: [f64; 2],
    /// `−c v / (1 + |v|/w)`, a grease that thins with its shear: mN s/mm, mm/s.
    grease_thinning: [f64; 2],
    /// `−c (P_f + P_e) v` with the absolute pressures, threads of a braid that are pressed together: mN s/(mm kPa).
    braid_damping: f64,
    /// Dry friction `a exp(−z/w)` with `ż = (|v| − z)/τ`, a seal whose film forms in motion: mN, mm/s, s.
    seal_warmup: [f64; 3],
    /// The reading of P_f has `c F` for the force F of the motor, whose current shifts the amplifier's ground: kPa/mN.
    motor_pickup: f64,
    /// Dry friction `a exp(−((x − x₀)/w)²)`, a bearing that is tight at one place: mN, mm, mm.
    tight_spot: [f64; 3],
    /// The reading of P_e has `c F` for the force F of the motor, whose current runs beside the cable: kPa/mN.
    cable_pickup: f64,
    /// `−c t F` for the force F of the motor, from the beginning of the excitation on, whose magnets lose strength as they warm: 1/s.
    magnet_fade: f64,
    /// Dry friction `a exp(−s/d)` with `ṡ = |v|`, a surface that is polished by the path it has run: mN, mm.
    polished_surface: [f64; 2],
    /// Air into the flexor `−c (P_f − z)` with `ż = (P_f − z)/τ`, a side volume behind a narrow port: g/(s kPa), s.
    side_volume: [f64; 2],
    /// Dry friction `a / (1 + z)` with `ż = (|v|/w − z)/τ`, a grease that motion warms: mN, mm/s, s.
    warm_grease: [f64; 3],
    /// `−a z` with `ż = (v − |v| z)/d`, bristles that bend before they slide (Dahl 1968): mN, mm.
    bristles: [f64; 2],
    /// Dry friction `c max(−x, 0)`, a rail that is bent at one end: mN/mm.
    rail_pinch: f64,
    /// Dry friction `a (1 − z)` with `ż = |v| (1 − z)/d − z/τ`, contacts that strengthen at rest and are renewed by slip: mN, mm, s.
    contact_ageing: [f64; 3],
    /// Air out of the flexor `c (P_f − P_atm) max(x, 0)`, a crack of the bladder that opens as the muscle bulges: g/(s mm kPa).
    bladder_crack: f64,
    /// The reading of P_e has `a (1 − exp(−t/τ))` from the beginning of the excitation on: kPa, s.
    sensor_warmup: [f64; 2],
    /// Air out of the extensor `c (P_e − P_atm)`, laminar through a loose fitting: g/(s kPa).
    gauge_leak: f64,
    /// The reading of P_f has `c t` from the beginning of the excitation on: kPa/s.
    pressure_drift: f64,
}

/// What the laws remember.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Kept {
    /// Low-passed force of the motor, mN.
    path_mn: f64,
    /// Low-passed square of the velocity, mm²/s².
    heat: f64,
    /// Stretch of a Maxwell-slip element, −1 to 1.
    stretch: f64,
    /// Elongation of a spring in series with a damper, mm.
    series_mm: f64,
    /// Low-passed speed, mm/s.
    speed: f64,
    /// Low-passed square of the velocity that softens the spring, mm²/s².
    work: f64,
    /// Low-passed size of the force of the motor, mN.
    load_mn: f64,
    /// The same for dry friction, mN.
    lasting_mn: f64,
    /// Low-passed signed square of the displacement, mm².
    crept_mm2: f64,
    /// Low-passed square of the force of the motor, N².
    motor_heat_n2: f64,
    /// High-passed displacement, by which air is compressed faster than its heat leaves, mm.
    compressed_mm: f64,
    /// Low-passed size of the displacement, mm.
    strain_mm: f64,
    /// Low-passed square of the force of the motor that warms the encoder, N².
    encoder_heat_n2: f64,
    /// Share of the structure of a grease that shear has broken down.
    broken: f64,
    /// Low-passed speed that warms the air, mm/s.
    rubbed_mm_s: f64,
    /// Stretch of a spring in series with an orifice, mm.
    orifice_mm: f64,
    /// Displacement of a braid from where it has settled, mm.
    unsettled_mm: f64,
    /// High-passed displacement that shears a bonded rubber, mm.
    sheared_mm: f64,
    /// Low-passed force of the motor that has stretched the tendon, N.
    pulled_n: f64,
    /// High-passed displacement, by which the flexor's air is expanded faster than heat enters, mm.
    expanded_mm: f64,
    /// Low-passed speed by which the film of a seal has formed, mm/s.
    filmed_mm_s: f64,
    /// Path that has polished a surface, mm.
    polished_mm: f64,
    /// Pressure in the side volume of the flexor, kPa absolute.
    side_kpa: f64,
    /// Heat of a grease, the low-passed speed over that which halves its friction.
    grease_heat: f64,
    /// Bend of the bristles, −1 to 1.
    bent: f64,
    /// Share of the contacts that slip has renewed.
    renewed: f64,
}

impl Kept {
    /// What is remembered at rest under absolute pressures, kPa.
    pub(super) fn at_rest(kpa: [f64; 2]) -> Self {
        Self { side_kpa: kpa[0], ..Self::default() }
    }
}

/// Where and how the joint is when its laws are evaluated.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moment {
    /// Displacement, mm.
    pub x: f64,
    /// Velocity, mm/s.
    pub v: f64,
    /// Time since the excitation began, s.
    pub t: f64,
    /// Pressures, kPa absolute.
    pub kpa: [f64; 2],
    /// Force of the motor, mN.
    pub motor_mn: f64,
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
            "edge_friction" => self.edge_friction += 1e3 * v("n_mm"),
            "quartic_spring" => self.quartic += 1e3 * v("n_mm4"),
            "extensor_damping" => self.extensor_damping += 1e3 * v("n_s_mm_kpa"),
            "saturating_damping" => self.saturating_damping = [1e3 * v("n"), v("mm_s")],
            "pressure_ripple" => self.pressure_ripple = [1e3 * v("n_kpa"), v("pitch_mm")],
            "one_sided_drag" => self.one_sided_drag += 1e3 * v("n_s2_mm2"),
            "pressure_hysteresis" => self.pressure_hysteresis = [1e3 * v("n_kpa"), v("slip_mm")],
            "pressure_relaxation" => {
                self.pressure_relaxation = [1e3 * v("n_mm_kpa"), v("time_s")];
            }
            "position_coupling" => self.position_coupling += 1e3 * v("n_s_mm2"),
            "moving_leak" => self.moving_leak += v("g_mm_kpa"),
            "turbulent_crosstalk" => self.turbulent_crosstalk += v("g_s_kpa2"),
            "running_friction" => self.running_friction = [1e3 * v("n_s_mm"), v("time_s")],
            "fading_damping" => self.fading_damping = [1e3 * v("n_s_mm"), v("time_s")],
            "extensor_friction" => self.extensor_friction += 1e3 * v("n_kpa"),
            "stiffening_spring" => self.stiffening = [1e3 * v("n_mm"), v("scale_mm")],
            "outer_damping" => self.outer_damping = [1e3 * v("n_s_mm2"), v("from_mm")],
            "difference_damping" => self.difference_damping += 1e3 * v("n_s_mm_kpa"),
            "quadratic_spring" => self.quadratic_spring += 1e3 * v("n_mm2"),
            "opening_crosstalk" => self.opening_crosstalk += v("g_s_mm_kpa"),
            "bent_pressure" => self.bent_pressure += v("per_kpa"),
            "bent_position" => self.bent_position += v("per_mm"),
            "worked_spring" => self.worked_spring = [1e3 * v("n_s2_mm3"), v("time_s")],
            "loaded_damping" => self.loaded_damping = [v("s_mm"), v("time_s")],
            "central_damping" => self.central_damping = [1e3 * v("n_s_mm"), v("width_mm")],
            "pressure_bow" => self.pressure_bow += 1e3 * v("n_mm2_kpa"),
            "square_leak" => self.square_leak += v("g_s_kpa2"),
            "lasting_friction" => self.lasting_friction = [v("share"), v("time_s")],
            "creeping_spring" => self.creeping_spring = [1e3 * v("n_mm2"), v("time_s")],
            "strained_pressure" => self.strained_pressure += v("kpa_mm2"),
            "fan_disturbance" => {
                self.fan = [1e3 * v("force_n"), v("frequency_hz"), v("phase_rad")];
            }
            "difference_spring" => self.difference_spring += 1e3 * v("n_mm_kpa"),
            "stretched_damping" => self.stretched_damping += 1e3 * v("n_s_mm2"),
            "moment_arm" => self.moment_arm += v("per_mm"),
            // `time_s` would be taken for the time from which the law acts.
            "motor_heating" => self.motor_heating = [v("per_n2"), v("tau_s")],
            "braid_friction" => self.braid_friction += 1e3 * v("n_mm_kpa"),
            "stretch_leak" => self.stretch_leak += v("g_s_mm_kpa"),
            "heated_air" => self.heated_air = [v("kpa_mm"), v("tau_s")],
            "supply_sag" => self.supply_sag += 1e-3 * v("kpa_n"),
            "hall_position" => self.hall_position += v("per_mm2"),
            "hose_spring" => self.hose_spring += 1e3 * v("n_mm_kpa"),
            "yielding_cable" => self.yielding_cable = [1e3 * v("n"), v("width_mm")],
            "amplifier_drift" => self.amplifier_drift = [1e3 * v("n"), v("tau_s")],
            "braid_brake" => self.braid_brake += 1e3 * v("n_s_mm_kpa"),
            "strain_softening" => self.strain_softening = [1e3 * v("n_mm2"), v("tau_s")],
            "gear_friction" => self.gear_friction += v("share"),
            "tilt_friction" => self.tilt_friction += 1e3 * v("n_kpa"),
            "opening_seal" => self.opening_seal = [v("g_s_kpa"), v("from_kpa")],
            "encoder_interpolation" => {
                self.encoder_interpolation = [v("amplitude_mm"), v("pitch_mm")];
            }
            "warming_encoder" => self.warming_encoder = [v("mm_n2"), v("tau_s")],
            "thixotropic_damping" => {
                self.thixotropy = [1e3 * v("n_s_mm"), v("shear_mm"), v("tau_s")];
            }
            "hertz_stop" => self.hertz_stop = [1e3 * v("n_mm1p5"), v("from_mm")],
            "eddy_brake" => self.eddy_brake = [1e3 * v("n_s_mm"), v("mm_s")],
            "pressure_hardening" => self.pressure_hardening += 1e3 * v("n_mm3_kpa"),
            "torque_ripple" => self.torque_ripple = [v("share"), v("pitch_mm")],
            "seal_ridge" => self.seal_ridge = [1e3 * v("n"), v("width_mm")],
            "check_valve" => self.check_valve += v("g_s_kpa"),
            "friction_heat" => self.friction_heat = [v("kpa_s_mm"), v("tau_s")],
            "sensor_range" => self.sensor_range = [v("share"), v("from_kpa")],
            "frame_bending" => self.frame_bending += v("mm_kpa"),
            "magnet_detent" => self.magnet_detent = [1e3 * v("n"), v("width_mm")],
            "racked_frame" => self.racked_frame += v("per_kpa"),
            "creeping_grease" => self.creeping_grease += 1e3 * v("n_mm"),
            "orifice_relaxation" => self.orifice_relaxation = [1e3 * v("n_mm"), v("per_mm_s")],
            "brinelled_bearing" => self.brinelled_bearing = [1e3 * v("n"), v("pitch_mm")],
            "settled_braid" => self.settled_braid = [1e3 * v("n_mm"), v("tau_s")],
            "orifice_crosstalk" => self.orifice_crosstalk += v("g_s_kpa0p5"),
            "pumping_seal" => self.pumping_seal += v("g_mm_kpa"),
            "pinched_gauge" => self.pinched_gauge = [1e-3 * v("kpa_n"), 1e3 * v("from_n")],
            "joined_scale" => self.joined_scale = [v("share"), v("from_mm")],
            "core_loss" => self.core_loss += v("s_mm"),
            "bladder_bulge" => self.bladder_bulge += 1e3 * v("n_mm2_kpa"),
            "payne_bushing" => {
                self.payne_bushing = [1e3 * v("n"), v("width_mm"), v("tau_s")];
            }
            "capstan_friction" => self.capstan_friction = [1e3 * v("n_kpa"), v("width_mm")],
            "mesh_friction" => self.mesh_friction = [1e3 * v("n"), v("pitch_mm")],
            "tilting_fitting" => self.tilting_fitting = [v("g_s_kpa_n"), v("from_n")],
            "growing_tear" => self.growing_tear += v("g_s2_kpa"),
            "sampling_beat" => self.sampling_beat = [v("kpa"), v("frequency_hz")],
            "tube_drop" => self.tube_drop += v("kpa_s2_mm2"),
            "tendon_elongation" => self.tendon_elongation = [v("mm_n"), v("tau_s")],
            "seam_leak" => self.seam_leak += v("g_s_kpa2"),
            "worn_guide" => self.worn_guide += 1e3 * v("n_mm2"),
            "running_in" => self.running_in = [1e3 * v("n"), v("tau_s")],
            "cross_leak" => self.cross_leak += v("g_s_kpa"),
            "frame_give" => self.frame_give += 1e-3 * v("mm_n"),
            "flexor_heat" => self.flexor_heat = [v("kpa_mm"), v("tau_s")],
            "grease_thinning" => self.grease_thinning = [1e3 * v("n_s_mm"), v("mm_s")],
            "braid_damping" => self.braid_damping += 1e3 * v("n_s_mm_kpa"),
            "seal_warmup" => self.seal_warmup = [1e3 * v("n"), v("mm_s"), v("tau_s")],
            "frame_flex" => self.frame_give += 1e-3 * v("mm_n"),
            "motor_pickup" => self.motor_pickup += 1e-3 * v("kpa_n"),
            "tight_spot" => self.tight_spot = [1e3 * v("n"), v("at_mm"), v("width_mm")],
            "hose_volume" => self.side_volume = [v("g_s_kpa"), v("tau_s")],
            "cable_pickup" => self.cable_pickup += 1e-3 * v("kpa_n"),
            "magnet_fade" => self.magnet_fade += v("per_s"),
            "polished_surface" => self.polished_surface = [1e3 * v("n"), v("path_mm")],
            "side_volume" => self.side_volume = [v("g_s_kpa"), v("tau_s")],
            "warm_grease" => self.warm_grease = [1e3 * v("n"), v("mm_s"), v("tau_s")],
            "bristle_friction" => self.bristles = [1e3 * v("n"), v("bend_mm")],
            "rail_pinch" => self.rail_pinch += 1e3 * v("n_mm"),
            "contact_ageing" => {
                self.contact_ageing = [1e3 * v("n"), v("slip_mm"), v("tau_s")];
            }
            "bladder_crack" => self.bladder_crack += v("g_s_mm_kpa"),
            "sensor_warmup" => self.sensor_warmup = [v("kpa"), v("tau_s")],
            "gauge_leak" => self.gauge_leak += v("g_s_kpa"),
            "pressure_drift" | "sensor_drift" => self.pressure_drift += v("kpa_s"),
            _ => return false,
        }
        true
    }

    /// Force on the joint, mN, `ahead_s` after what is kept.
    pub(super) fn force_mn(&self, now: Moment, kept: Kept, ahead_s: f64) -> f64 {
        let Moment { x, v, t, kpa, motor_mn } = now;
        let gauge = kpa.map(|p| p - ATMOSPHERE_KPA);
        let both = gauge[0] + gauge[1];
        let kept = self.moved(kept, now, ahead_s);
        let mut total = -self.cubic * x * x * x
            - self.drag * v * v.abs()
            - self.pressure_damping * both * v
            - self.displacement_damping * x * x * v
            - self.one_way_damping * v.max(0.0)
            - self.stop[0] * (x - self.stop[1]).max(0.0)
            - self.second_path[0] * kept.path_mn
            - self.warming[0] * kept.heat * v
            - self.quartic * x.powi(4)
            - self.extensor_damping * gauge[1] * v
            + self.one_sided_drag * v.min(0.0).powi(2)
            - self.pressure_hysteresis[0] * both * kept.stretch
            - self.pressure_relaxation[0] * both * kept.series_mm
            - self.position_coupling * x * v
            - self.outer_damping[0] * v * (x.abs() - self.outer_damping[1]).max(0.0)
            - self.difference_damping * (gauge[0] - gauge[1]) * v
            - self.quadratic_spring * x * x.abs()
            - self.worked_spring[0] * kept.work * x
            - self.loaded_damping[0] * kept.load_mn * v
            - self.pressure_bow * gauge[0] * x * x
            - self.creeping_spring[0] * kept.crept_mm2
            - self.difference_spring * (gauge[0] - gauge[1]) * x
            - self.stretched_damping * (-x).max(0.0) * v
            - self.moment_arm * x * motor_mn
            - self.motor_heating[0] * kept.motor_heat_n2 * motor_mn
            - self.hose_spring * gauge[0] * x
            - self.braid_brake * gauge[1] * v.max(0.0)
            + self.strain_softening[0] * kept.strain_mm * x
            - self.thixotropy[0] * (1.0 - kept.broken) * v
            + self.hertz_stop[0] * (-x - self.hertz_stop[1]).max(0.0).powf(1.5)
            - self.pressure_hardening * both * x * x * x
            - self.racked_frame * (gauge[0] - gauge[1]) * motor_mn
            - self.creeping_grease * t.max(0.0) * v
            - self.orifice_relaxation[0] * kept.orifice_mm
            - self.core_loss * motor_mn * v.abs()
            - self.bladder_bulge * gauge[0] * x * x.abs()
            - self.braid_damping * (kpa[0] + kpa[1]) * v
            - self.magnet_fade * t.max(0.0) * motor_mn
            - self.bristles[0] * kept.bent;
        if t >= 0.0 {
            let [force, frequency, phase] = self.fan;
            total += force * (TAU * frequency * t + phase).sin();
        }
        if let [damping, width] = self.central_damping
            && damping != 0.0
        {
            total -= damping * v / (1.0 + (x / width).powi(2));
        }
        if let [stiffness, scale] = self.stiffening
            && stiffness != 0.0
        {
            total -= stiffness * scale * ((x / scale).sinh() - x / scale);
        }
        if let [force, width] = self.saturating_damping
            && force != 0.0
        {
            total -= force * (v / width).tanh();
        }
        if let [per_kpa, pitch] = self.pressure_ripple
            && per_kpa != 0.0
        {
            total -= per_kpa * both * (TAU * x / pitch).sin();
        }
        if let [damping, time] = self.fading_damping
            && damping != 0.0
        {
            total -= damping * (-t.max(0.0) / time).exp() * v;
        }
        if let [force, width] = self.yielding_cable
            && force != 0.0
        {
            total -= force * (x / width).tanh();
        }
        if let [force, time] = self.amplifier_drift
            && force != 0.0
        {
            total += force * (1.0 - (-t.max(0.0) / time).exp());
        }
        if let [damping, width] = self.eddy_brake
            && damping != 0.0
        {
            total -= damping * v / (1.0 + (v / width).powi(2));
        }
        if let [share, pitch] = self.torque_ripple
            && share != 0.0
        {
            total -= share * motor_mn * (TAU * x / pitch).sin();
        }
        if let [force, width] = self.magnet_detent
            && force != 0.0
        {
            total -= force * (x / width) * (-(x / width).powi(2)).exp();
        }
        if let [force, width, _] = self.payne_bushing
            && force != 0.0
        {
            total -= force * (kept.sheared_mm / width).tanh();
        }
        if let [damping, width] = self.grease_thinning
            && damping != 0.0
        {
            total -= damping * v / (1.0 + v.abs() / width);
        }
        total
    }

    /// Largest dry friction, mN.
    pub(super) fn dry_mn(&self, now: Moment, kept: Kept) -> f64 {
        let gauge = now.kpa.map(|p| p - ATMOSPHERE_KPA);
        let mut dry = self.flexor_friction * gauge[0]
            + self.pressure_friction * (gauge[0] + gauge[1])
            + self.edge_friction * now.x.abs()
            + self.extensor_friction * gauge[1]
            + self.running_friction[0] * kept.speed
            + self.lasting_friction[0] * kept.lasting_mn
            + self.braid_friction * gauge[0] * now.x.abs()
            + self.gear_friction * now.motor_mn.abs()
            + self.tilt_friction * (gauge[0] - gauge[1]).abs()
            + self.settled_braid[0] * kept.unsettled_mm.abs()
            + self.worn_guide * now.x * now.x
            + self.warm_grease[0] / (1.0 + kept.grease_heat)
            + self.rail_pinch * (-now.x).max(0.0)
            + self.contact_ageing[0] * (1.0 - kept.renewed);
        if let [force, width] = self.seal_ridge
            && force != 0.0
        {
            dry += force * (-(now.x / width).powi(2)).exp();
        }
        if let [force, pitch] = self.brinelled_bearing
            && force != 0.0
        {
            dry += force * (PI * now.x / pitch).sin().powi(2);
        }
        if let [per_kpa, width] = self.capstan_friction
            && per_kpa != 0.0
        {
            dry += per_kpa * gauge[1].max(0.0) * (now.x / width).exp();
        }
        if let [force, pitch] = self.mesh_friction
            && force != 0.0
        {
            dry += force * (PI * now.x / pitch).sin().powi(2);
        }
        if let [force, time] = self.running_in
            && force != 0.0
        {
            dry += force * (-now.t.max(0.0) / time).exp();
        }
        if let [force, width, _] = self.seal_warmup
            && force != 0.0
        {
            dry += force * (-kept.filmed_mm_s / width).exp();
        }
        if let [force, at, width] = self.tight_spot
            && force != 0.0
        {
            dry += force * (-((now.x - at) / width).powi(2)).exp();
        }
        if let [force, path] = self.polished_surface
            && force != 0.0
        {
            dry += force * (-kept.polished_mm / path).exp();
        }
        dry
    }

    /// The memory states after `dt` s at constant displacement, velocity, pressures and force.
    pub(super) fn moved(&self, kept: Kept, now: Moment, dt: f64) -> Kept {
        let Moment { x, v, kpa, motor_mn, .. } = now;
        let low_passed = |old: f64, to: f64, time_s: f64| {
            if time_s > 0.0 { old + (to - old) * (1.0 - (-dt / time_s).exp()) } else { old }
        };
        let [_, slip] = self.pressure_hysteresis;
        let [_, series_s] = self.pressure_relaxation;
        let [_, heat_s] = self.heated_air;
        let [_, settling_s] = self.settled_braid;
        let [_, wall_s] = self.flexor_heat;
        // By the midpoint rule.
        let [_, loss] = self.orifice_relaxation;
        let stretching = |z: f64| v - loss * z * z.abs();
        let orifice_mm = if loss > 0.0 {
            let middle = kept.orifice_mm + 0.5 * dt * stretching(kept.orifice_mm);
            kept.orifice_mm + dt * stretching(middle)
        } else {
            kept.orifice_mm
        };
        let [_, _, bond_s] = self.payne_bushing;
        let [_, _, film_s] = self.seal_warmup;
        let [_, warm_mm_s, warm_s] = self.warm_grease;
        let grease_heat = if warm_mm_s > 0.0 {
            low_passed(kept.grease_heat, v.abs() / warm_mm_s, warm_s)
        } else {
            kept.grease_heat
        };
        let [_, bend_mm] = self.bristles;
        let bent = if bend_mm > 0.0 {
            kept.bent + (v.signum() - kept.bent) * (1.0 - (-v.abs() * dt / bend_mm).exp())
        } else {
            kept.bent
        };
        // A share that slip breaks down and rest builds up again.
        let broken = |old: f64, [_, path_mm, rest_s]: [f64; 3]| {
            if path_mm > 0.0 && rest_s > 0.0 {
                let breaking = v.abs() / path_mm;
                let rate = breaking + 1.0 / rest_s;
                old + (breaking / rate - old) * (1.0 - (-rate * dt).exp())
            } else {
                old
            }
        };
        Kept {
            path_mn: low_passed(kept.path_mn, motor_mn, self.second_path[1]),
            heat: low_passed(kept.heat, v * v, self.warming[1]),
            stretch: if slip > 0.0 { (kept.stretch + v * dt / slip).clamp(-1.0, 1.0) } else { 0.0 },
            series_mm: low_passed(kept.series_mm, series_s * v, series_s),
            speed: low_passed(kept.speed, v.abs(), self.running_friction[1]),
            work: low_passed(kept.work, v * v, self.worked_spring[1]),
            load_mn: low_passed(kept.load_mn, motor_mn.abs(), self.loaded_damping[1]),
            lasting_mn: low_passed(kept.lasting_mn, motor_mn.abs(), self.lasting_friction[1]),
            crept_mm2: low_passed(kept.crept_mm2, x * x.abs(), self.creeping_spring[1]),
            motor_heat_n2: low_passed(
                kept.motor_heat_n2,
                (1e-3 * motor_mn).powi(2),
                self.motor_heating[1],
            ),
            compressed_mm: low_passed(kept.compressed_mm, heat_s * v, heat_s),
            strain_mm: low_passed(kept.strain_mm, x.abs(), self.strain_softening[1]),
            encoder_heat_n2: low_passed(
                kept.encoder_heat_n2,
                (1e-3 * motor_mn).powi(2),
                self.warming_encoder[1],
            ),
            broken: broken(kept.broken, self.thixotropy),
            rubbed_mm_s: low_passed(kept.rubbed_mm_s, v.abs(), self.friction_heat[1]),
            orifice_mm,
            unsettled_mm: low_passed(kept.unsettled_mm, settling_s * v, settling_s),
            sheared_mm: low_passed(kept.sheared_mm, bond_s * v, bond_s),
            pulled_n: low_passed(kept.pulled_n, 1e-3 * motor_mn, self.tendon_elongation[1]),
            expanded_mm: low_passed(kept.expanded_mm, wall_s * v, wall_s),
            filmed_mm_s: low_passed(kept.filmed_mm_s, v.abs(), film_s),
            polished_mm: kept.polished_mm + v.abs() * dt,
            side_kpa: low_passed(kept.side_kpa, kpa[0], self.side_volume[1]),
            grease_heat,
            bent,
            renewed: broken(kept.renewed, self.contact_ageing),
        }
    }

    /// Air that enters the chambers, g/s.
    pub(super) fn inflow_g_s(&self, now: Moment, kept: Kept) -> [f64; 2] {
        let Moment { x, v, t, kpa, motor_mn } = now;
        let over_air = kpa[0] - ATMOSPHERE_KPA;
        let lost = self.moving_leak * over_air * v.abs()
            + self.square_leak * over_air.powi(2)
            + self.bladder_crack * over_air * x.max(0.0);
        let over = kpa[0] - kpa[1];
        let passed = self.turbulent_crosstalk * over * over.abs()
            + self.opening_crosstalk * over * x.max(0.0)
            + self.check_valve * over.max(0.0)
            + self.orifice_crosstalk * over / (over.abs() + 1.0).sqrt()
            + self.cross_leak * over;
        let lost_by_extensor = self.stretch_leak * (kpa[1] - ATMOSPHERE_KPA) * x.max(0.0)
            + self.pumping_seal * (kpa[1] - ATMOSPHERE_KPA) * v.max(0.0);
        let [per_kpa, from_kpa] = self.opening_seal;
        let blown_off = per_kpa * (kpa[1] - ATMOSPHERE_KPA - from_kpa).max(0.0);
        let [per_n, from_n] = self.tilting_fitting;
        let tilted = per_n * over_air * (1e-3 * motor_mn - from_n).max(0.0);
        let torn = self.growing_tear * (kpa[1] - ATMOSPHERE_KPA) * t.max(0.0);
        let seeped = self.seam_leak * (kpa[1].powi(2) - ATMOSPHERE_KPA.powi(2));
        let aside = self.side_volume[0] * (kpa[0] - kept.side_kpa);
        let let_out = self.gauge_leak * (kpa[1] - ATMOSPHERE_KPA);
        [
            -lost - passed - tilted - aside,
            passed - lost_by_extensor - blown_off - torn - seeped - let_out,
        ]
    }

    /// Deviations of the pressures from the gas law, kPa.
    pub(super) fn heated_kpa(&self, kept: Kept) -> [f64; 2] {
        let more = self.heated_air[0] * kept.compressed_mm;
        let rubbed = self.friction_heat[0] * kept.rubbed_mm_s;
        let cooled = self.flexor_heat[0] * kept.expanded_mm;
        [-more + rubbed - cooled, more + rubbed]
    }

    /// Readings of the pressures for true ones, kPa.
    pub(super) fn readings(&self, now: Moment) -> [f64; 2] {
        let Moment { x, v, t, kpa, motor_mn } = now;
        let [compressed, from_kpa] = self.sensor_range;
        let [pinched, from_mn] = self.pinched_gauge;
        let [amplitude, frequency] = self.sampling_beat;
        let beat = if t >= 0.0 { amplitude * (TAU * frequency * t).sin() } else { 0.0 };
        let [risen, warmup_s] = self.sensor_warmup;
        let warmed =
            if risen == 0.0 { 0.0 } else { risen * (1.0 - (-t.max(0.0) / warmup_s).exp()) };
        [
            kpa[0] + self.bent_pressure * (kpa[0] - ATMOSPHERE_KPA).powi(2)
                - self.supply_sag * motor_mn.abs()
                + self.tube_drop * v * v.abs()
                + beat
                + self.motor_pickup * motor_mn
                + self.pressure_drift * t.max(0.0),
            kpa[1] + self.reading_crosstalk * (kpa[0] - kpa[1]) + self.strained_pressure * x * x
                - compressed * (kpa[1] - ATMOSPHERE_KPA - from_kpa).max(0.0)
                + pinched * (motor_mn - from_mn).max(0.0)
                + beat
                + self.cable_pickup * motor_mn
                + warmed,
        ]
    }

    /// Reading of the displacement for the true one, mm, at pressures, kPa, and a force of the motor, mN.
    pub(super) fn reading_mm(&self, x: f64, kpa: [f64; 2], motor_mn: f64, kept: Kept) -> f64 {
        let mut reading = x + self.bent_position * x * x - self.hall_position * x.powi(3)
            + self.warming_encoder[0] * kept.encoder_heat_n2
            + self.frame_bending * (kpa[0] - kpa[1])
            + self.joined_scale[0] * (x - self.joined_scale[1]).max(0.0)
            + self.tendon_elongation[0] * kept.pulled_n
            + self.frame_give * motor_mn;
        if let [amplitude, pitch] = self.encoder_interpolation
            && amplitude != 0.0
        {
            reading += amplitude * (TAU * x / pitch).sin();
        }
        reading
    }
}
