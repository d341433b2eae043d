//! Energy of a joint that is left alone only falls, and the motor's work is accounted for.

use crate::common::{kpa, no_friction, no_losses, springs};
use pam_rig::plant::{Drive, HeatExchange, Plant, PlantParameters};
use std::f64::consts::TAU;

const EXCHANGES: [HeatExchange; 3] =
    [HeatExchange::Isothermal, HeatExchange::Adiabatic, HeatExchange::Conduction { scale: 0.55 }];
const PSI: [[f64; 2]; 5] = [[10.0, 10.0], [45.0, 45.0], [80.0, 80.0], [30.0, 60.0], [10.0, 80.0]];

/// A joint that is let go 1.5 mm from zero.
fn let_go(p: &PlantParameters, psi: [f64; 2]) -> Plant {
    let mut plant = Plant::new(p, Default::default(), &[]);
    plant.fill(psi.map(kpa));
    plant.place(1.5, 0.0);
    plant
}

/// What a ring-down does to the energy, in units of the largest kinetic energy.
struct RingDown {
    /// Largest rise above what it was before.
    rise: f64,
    /// Fall from start to end.
    fall: f64,
}

fn ring_down(mut plant: Plant, step_s: f64, seconds: f64) -> RingDown {
    let start = plant.energy_mj();
    let (mut lowest, mut rise, mut kinetic) = (start, 0.0_f64, 0.0_f64);
    for _ in 0..(seconds / step_s).round() as usize {
        plant.step(step_s, &Drive::default());
        let now = plant.energy_mj();
        rise = rise.max(now - lowest);
        lowest = lowest.min(now);
        kinetic = kinetic.max(0.5e-3 * 315.0 * plant.velocity_mm_s().powi(2));
    }
    RingDown { rise: rise / kinetic, fall: (start - plant.energy_mj()) / kinetic }
}

#[test]
fn the_swing_of_a_lossless_joint_is_of_second_order_and_does_not_drift() {
    for heat in [HeatExchange::Isothermal, HeatExchange::Adiabatic] {
        let p = PlantParameters { heat, ..springs() };
        let coarse = ring_down(let_go(&p, [30.0, 60.0]), 4e-4, 4.0).rise;
        let fine = ring_down(let_go(&p, [30.0, 60.0]), 2e-4, 4.0).rise;
        assert!((coarse / fine - 4.0).abs() < 0.1, "{coarse:e} {fine:e}");
        let long = ring_down(let_go(&p, [30.0, 60.0]), 2e-4, 20.0);
        assert!(long.rise < 1.05 * fine, "{:e} {fine:e}", long.rise);
    }
}

/// What motor and friction do together is what the joint gains, if nothing else takes it.
#[test]
fn the_energy_is_the_work_of_motor_and_friction() {
    let p = PlantParameters {
        heat: HeatExchange::Adiabatic,
        friction: PlantParameters::default().friction,
        ..springs()
    };
    let mut plant = Plant::new(&p, Default::default(), &[]);
    plant.fill([kpa(30.0), kpa(60.0)]);
    let start = plant.energy_mj();
    let (mut motor_mj, mut friction_mj, mut most_mj) = (0.0, 0.0, 0.0_f64);
    for k in 0..40_000 {
        let force_n = 150.0 * (TAU * f64::from(k) * 1e-4).sin();
        let (before, velocity) = (plant.displacement_mm(), plant.velocity_mm_s());
        plant.step(1e-4, &Drive { force_n, ..Drive::default() });
        let travel = plant.displacement_mm() - before;
        motor_mj += force_n * travel;
        friction_mj += plant.friction_n() * travel;
        // A step in which the joint stops or turns has friction of both signs.
        let slides = velocity * plant.velocity_mm_s() > 0.0;
        assert!(!slides || plant.friction_n() * travel < 0.0, "friction drives the joint");
        most_mj = most_mj.max(motor_mj.abs());
        let off = plant.energy_mj() - start - motor_mj - friction_mj;
        assert!(off.abs() < 5e-6 * most_mj.max(100.0), "{off} of {most_mj} mJ");
    }
    assert!(motor_mj > 200.0 && friction_mj < -300.0, "{motor_mj} {friction_mj}");
}

/// Losses of the muscles and heat take more: never less than nothing.
#[test]
fn no_cycle_of_a_lossy_joint_gives_energy() {
    let mut plant = Plant::new(&PlantParameters::default(), Default::default(), &[]);
    plant.fill([kpa(30.0), kpa(60.0)]);
    let mut surplus = plant.energy_mj();
    let mut lowest = surplus;
    for k in 0..40_000 {
        let force_n = 200.0 * (TAU * f64::from(k) * 2e-4).sin();
        let before = plant.displacement_mm();
        let energy = plant.energy_mj();
        plant.step(1e-4, &Drive { force_n, ..Drive::default() });
        let work = (force_n + plant.friction_n()) * (plant.displacement_mm() - before);
        surplus += plant.energy_mj() - energy - work;
        assert!(surplus < lowest + 1e-6, "{} mJ from nothing", surplus - lowest);
        lowest = lowest.min(surplus);
    }
}

/// Run by `cargo test --release --workspace --tests -- --ignored long::`.
mod long {
    use super::*;

    /// A symmetric step of h swings the energy of a lossless oscillator by (ω h)²/4 of the kinetic energy:
    /// 1.3e-6 for the joint's 3.6 Hz and steps of 0.1 ms. Anything that dissipates hides the swing.
    #[test]
    #[ignore = "long"]
    fn a_joint_that_is_left_alone_never_gains_energy() {
        for psi in PSI {
            for heat in EXCHANGES {
                for (friction, losses) in
                    [(true, true), (true, false), (false, true), (false, false)]
                {
                    let mut p = PlantParameters { heat, ..PlantParameters::default() };
                    if !friction {
                        p.friction = no_friction();
                    }
                    if !losses {
                        (p.flexor.losses, p.extensor.losses) = (no_losses(), no_losses());
                    }
                    let lossless =
                        !friction && !losses && !matches!(heat, HeatExchange::Conduction { .. });
                    let made = ring_down(let_go(&p, psi), 1e-4, 3.0);
                    let allowed = if lossless { 2e-6 } else { 2e-8 };
                    let which = format!("{psi:?}, {heat:?}, friction {friction}, losses {losses}");
                    assert!(made.rise < allowed, "{which}: rises by {:e}", made.rise);
                    let falls = made.fall > if lossless { -2e-6 } else { 0.2 };
                    assert!(falls, "{which}: falls by {:e}", made.fall);
                }
            }
        }
    }
}
