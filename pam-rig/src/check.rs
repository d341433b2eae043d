//! Checks of the parameters of a rig.

use crate::effects::SetUp;
use crate::error::RigError;
use crate::plant::{DryFriction, HeatExchange, MuscleParameters};
use crate::rig::RigParameters;

/// Most steps of the plant per sample.
const MOST_STEPS_PER_SAMPLE: usize = 10_000;

/// Checks the parameters of a rig, and those of its plant with the effects.
pub(crate) fn rig(p: &RigParameters, setup: &SetUp) -> Result<(), RigError> {
    if p.steps_per_sample == 0 {
        return Err(error("steps_per_sample", 0.0, "there must be at least one"));
    }
    let clock = &p.sensors.clock;
    positive("sensors.clock.rate_hz", clock.rate_hz)?;
    if p.steps_per_sample > MOST_STEPS_PER_SAMPLE {
        return Err(error(
            "steps_per_sample",
            p.steps_per_sample as f64,
            &format!("there are at most {MOST_STEPS_PER_SAMPLE}"),
        ));
    }
    positive("sensors.clock.skew_ppm (+1e6)", clock.skew_ppm + 1e6)?;
    let pneumatics = &p.pneumatics;
    positive("pneumatics.supply.volume_mm3", pneumatics.supply.volume_mm3)?;
    positive("pneumatics.supply.recovery_s", pneumatics.supply.recovery_s)?;
    let ratio = pneumatics.valve.critical_ratio;
    if !(0.0..1.0).contains(&ratio) {
        return Err(error("pneumatics.valve.critical_ratio", ratio, "must lie in 0 … 1"));
    }
    positive("sensors.encoder.pulley_radius_mm", p.sensors.encoder.pulley_radius_mm)?;
    let plant = &setup.plant;
    positive("plant.mass_kg", plant.mass_kg)?;
    muscle("plant.flexor", &plant.flexor)?;
    muscle("plant.extensor", &plant.extensor)?;
    if let HeatExchange::Conduction { scale } = plant.heat {
        positive("plant.heat.conduction.scale", scale)?;
    }
    positive("plant.friction.velocity_mm_s", plant.friction.velocity_mm_s)?;
    friction("plant.friction", &plant.friction)?;
    setup.frictions.iter().try_for_each(|f| friction("effect", f))?;
    let s = &p.sensors;
    let not_negative = [
        ("plant.viscous_ns_m", plant.viscous_ns_m),
        ("plant.friction.coulomb_n", plant.friction.coulomb_n),
        ("plant.friction.static_n", plant.friction.static_n),
        ("plant.leak_per_s[0]", plant.leak_per_s[0]),
        ("plant.leak_per_s[1]", plant.leak_per_s[1]),
        ("pneumatics.valve.inflate_conductance", pneumatics.valve.inflate_conductance),
        ("pneumatics.valve.exhaust_conductance", pneumatics.valve.exhaust_conductance),
        ("pneumatics.valve.response_ms", pneumatics.valve.response_ms),
        ("pneumatics.supply.pressure_psi", pneumatics.supply.pressure_psi),
        ("pneumatics.servo.deadband_psi", pneumatics.servo.deadband_psi),
        ("pneumatics.servo.inflate_ms", pneumatics.servo.inflate_ms),
        ("pneumatics.servo.exhaust_ms", pneumatics.servo.exhaust_ms),
        ("pneumatics.servo.refractory_ms", pneumatics.servo.refractory_ms),
        ("sensors.motor.command_step_a", s.motor.command_step_a),
        ("sensors.encoder.step_deg", s.encoder.step_deg),
        ("sensors.pressure.cutoff_hz", s.pressure.cutoff_hz),
        ("sensors.pressure.step_psi", s.pressure.step_psi),
        ("sensors.pressure.noise_psi", s.pressure.noise_psi),
        ("sensors.current.noise_a", s.current.noise_a),
        ("sensors.current.step_a", s.current.step_a),
        ("sensors.clock.jitter_us", s.clock.jitter_us),
    ];
    for (field, value) in not_negative {
        if !(value.is_finite() && value >= 0.0) {
            return Err(error(field, value, "must be a number that is not negative"));
        }
    }
    let finite = [
        ("sensors.motor.torque_constant_mnm_a", s.motor.torque_constant_mnm_a),
        ("sensors.motor.gear_ratio", s.motor.gear_ratio),
        ("sensors.current.offset_a", s.current.offset_a),
    ];
    for (field, value) in finite {
        if !value.is_finite() {
            return Err(error(field, value, "must be a finite number"));
        }
    }
    Ok(())
}

fn muscle(place: &str, p: &MuscleParameters) -> Result<(), RigError> {
    let field = |name: &str| format!("{place}.{name}");
    let braid = &p.braid;
    positive(&field("braid.length_mm"), braid.length_mm)?;
    positive(&field("braid.diameter_mm"), braid.diameter_mm)?;
    positive(&field("braid.bore_mm"), braid.bore_mm)?;
    // Above 54.7° a muscle pushes.
    if !(braid.angle_deg > 0.0 && braid.angle_deg < 54.7) {
        return Err(error(
            &field("braid.angle_deg"),
            braid.angle_deg,
            "must lie between 0 and 54.7, where a braid contracts under pressure",
        ));
    }
    positive(&field("wall.toe_width_mm"), p.wall.toe_width_mm)?;
    if !p.wall.preload_mm.is_finite() {
        return Err(error(&field("wall.preload_mm"), p.wall.preload_mm, "must be finite"));
    }
    let [short, long] = p.losses.slip_mm;
    positive(&field("losses.slip_mm[0]"), short)?;
    if !(long.is_finite() && long >= short) {
        return Err(error(
            &field("losses.slip_mm[1]"),
            long,
            "the longest slip distance must not be below the shortest",
        ));
    }
    for (name, value) in [
        ("braid.dead_volume_mm3", braid.dead_volume_mm3),
        ("wall.toe_stiffness_n_mm", p.wall.toe_stiffness_n_mm),
        ("wall.stiffness_n_mm", p.wall.stiffness_n_mm),
        ("losses.dry_n", p.losses.dry_n),
        ("losses.dry_n_per_kpa", p.losses.dry_n_per_kpa),
        ("losses.viscous_ns_m", p.losses.viscous_ns_m),
        ("losses.viscous_ns_m_per_kpa", p.losses.viscous_ns_m_per_kpa),
    ] {
        if !(value.is_finite() && value >= 0.0) {
            return Err(error(&field(name), value, "must be a number that is not negative"));
        }
    }
    Ok(())
}

fn friction(place: &str, p: &DryFriction) -> Result<(), RigError> {
    // Otherwise a joint that stops under a force between the two would be driven back by friction.
    if p.static_n < p.coulomb_n {
        let why = "friction at rest must not be below coulomb_n, that of sliding";
        return Err(error(&format!("{place}.static_n"), p.static_n, why));
    }
    Ok(())
}

fn positive(field: &str, value: f64) -> Result<(), RigError> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(error(field, value, "must be a positive number"))
    }
}

fn error(field: &str, value: f64, message: &str) -> RigError {
    RigError::Parameter { field: field.to_owned(), value, message: message.to_owned() }
}
