//! Orders of convergence of the plant's step, and how fine the default step is.

use crate::common::{ideal, kpa, largest, no_friction, sealed, sine};
use pam_rig::RigParameters;
use pam_rig::plant::{Drive, DryFriction, Plant, PlantParameters};
use std::f64::consts::TAU;

/// Displacements every 4 ms of a joint that is let go and pushed by a smooth force.
fn trajectory(p: &PlantParameters, steps: usize) -> Vec<f64> {
    let step_s = 4e-3 / steps as f64;
    let mut plant = Plant::new(p, Default::default(), &[]);
    plant.fill([kpa(30.0), kpa(60.0)]);
    plant.place(0.5, 0.0);
    (0..250)
        .map(|sample| {
            for k in 0..steps {
                let t = (sample * steps + k) as f64 * step_s + 0.5 * step_s;
                let force_n = 180.0 * (TAU * 1.5 * t).sin();
                plant.step(step_s, &Drive { force_n, ..Drive::default() });
            }
            plant.displacement_mm()
        })
        .collect()
}

/// Largest errors for 4, 8, 16 and 32 steps in 4 ms, against 2048.
fn errors_mm(p: &PlantParameters) -> [f64; 4] {
    let exact = trajectory(p, 2048);
    [4, 8, 16, 32].map(|steps| {
        let made = trajectory(p, steps);
        largest(made.iter().zip(&exact).map(|(a, b)| (a - b).abs()))
    })
}

fn orders(errors: [f64; 4]) -> Vec<f64> {
    errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect()
}

/// No dry friction, no strands that slip.
fn smooth() -> PlantParameters {
    let mut p = PlantParameters { friction: no_friction(), ..PlantParameters::default() };
    for losses in [&mut p.flexor.losses, &mut p.extensor.losses] {
        (losses.dry_n, losses.dry_n_per_kpa) = (0.0, 0.0);
    }
    p
}

#[test]
fn a_smooth_joint_converges_with_the_second_order() {
    let errors = errors_mm(&smooth());
    for order in orders(errors) {
        assert!((order - 2.0).abs() < 0.1, "{errors:?}");
    }
}

#[test]
fn friction_leaves_at_least_the_first_order() {
    let rough = PlantParameters::default();
    let stribeck = PlantParameters {
        friction: DryFriction { coulomb_n: 10.0, static_n: 40.0, velocity_mm_s: 2.0 },
        ..smooth()
    };
    for p in [rough, stribeck] {
        let errors = errors_mm(&p);
        let order = (errors[0] / errors[3]).log2() / 3.0;
        assert!(order > 0.9, "{order}: {errors:?}");
        assert!(errors[3] < 1e-3, "{errors:?}");
    }
}

/// Ten steps a millisecond are within a hundredth of the encoder's step of 0.01055 mm.
#[test]
fn the_default_step_is_fine_enough() {
    let x = |steps_per_sample: usize| {
        let rig = RigParameters { steps_per_sample, ..ideal(&[]) };
        let frames = sealed(&rig, [30.0, 60.0], 6.0, |t| {
            if t < 4.0 { sine(1.5, 0.5)(t) } else { sine(1.5, 2.0)(t) }
        });
        frames.into_iter().map(|f| f.truth.displacement_mm)
    };
    let off = largest(x(10).zip(x(100)).map(|(a, b)| (a - b).abs()));
    assert!(off < 1e-4, "{off} mm");
}
