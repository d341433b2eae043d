//! Tendons only pull.

use crate::common::{NEWTON_PER_AMPERE, ideal, kpa, sine};
use approx::assert_relative_eq;
use pam_rig::plant::Muscle;
use pam_rig::{Command, PressureCommand, Rig};

/// Ticks a rig; after every sample the caller sees it.
fn push(psi: [f64; 2], seconds: f64, current_a: impl Fn(f64) -> f64, mut see: impl FnMut(&Rig)) {
    let mut rig = Rig::new(&ideal(&[]), 1, 0.0).unwrap();
    rig.fill(psi.map(kpa));
    for k in 0..(1e3 * seconds) as usize {
        let current_a = current_a(k as f64 * 1e-3);
        rig.tick(&Command { current_a, pressure: PressureCommand::Sealed });
        see(&rig);
    }
}

/// At 10 psi a muscle pulls with less than 100 N; 3 A (400 N) overrule it.
#[test]
fn a_tendon_that_is_pushed_goes_slack_and_comes_back() {
    let (mut slack, mut returned) = ([0; 2], [0; 2]);
    let mut volumes = [const { Vec::new() }; 2];
    push([10.0, 10.0], 6.0, sine(3.0, 0.5), |rig| {
        let plant = rig.plant();
        let tensions = plant.tensions_n();
        let ends = [plant.displacement_mm(), -plant.displacement_mm()];
        for (i, muscle) in plant.muscles().iter().enumerate() {
            let contraction = muscle.contraction_mm();
            assert!(tensions[i] >= 0.0);
            // The air fills the muscle as long as it is, not as long as the tendon says.
            let expected = muscle.gas_volume_mm3(contraction);
            assert_relative_eq!(muscle.air.volume_mm3(), expected, max_relative = 1e-12);
            if muscle.is_slack() {
                slack[i] += 1;
                assert_eq!(tensions[i], 0.0);
                assert!(contraction < ends[i]);
                volumes[i].push((ends[i], muscle.air.volume_mm3()));
            } else {
                assert_eq!(contraction, ends[i]);
                returned[i] += i32::from(slack[i] > 0);
            }
        }
    });
    for i in 0..2 {
        assert!(slack[i] > 500 && returned[i] > 500, "{slack:?} {returned:?}");
        let span = |f: fn(&(f64, f64)) -> f64| {
            let all = || volumes[i].iter().map(f);
            all().fold(f64::MIN, f64::max) - all().fold(f64::MAX, f64::min)
        };
        let (travel, change) = (span(|v| v.0), span(|v| v.1));
        // A taut muscle changes its volume by more than 700 mm³ a millimetre.
        assert!(travel > 1.0 && change < 150.0 * travel, "{travel} mm, {change} mm³");
    }
}

/// The slack muscle rests at its own force-free length, and the other one carries the load alone.
#[test]
fn a_slack_muscle_is_free_of_force() {
    for side in [1.0, -1.0] {
        let mut last: Option<(f64, [f64; 2], [Muscle; 2])> = None;
        push(
            [10.0, 10.0],
            4.0,
            |t| side * 3.0 * t.min(1.0),
            |rig| {
                let plant = rig.plant();
                last = Some((plant.friction_n(), plant.tensions_n(), *plant.muscles()));
            },
        );
        let (friction, tensions, muscles) = last.unwrap();
        let (free, loaded) = if side > 0.0 { (0, 1) } else { (1, 0) };
        assert!(muscles[free].is_slack() && tensions[free] == 0.0);
        let carried = tensions[loaded] - side * friction;
        assert_relative_eq!(carried, 3.0 * NEWTON_PER_AMPERE, max_relative = 1e-6);
        // What is left of the elastic force is held by the dry friction of the strands, a few newtons.
        let muscle = muscles[free];
        let elastic = muscle.elastic_tension_n(muscle.contraction_mm(), muscle.gauge_kpa());
        assert!(elastic.abs() < 2.0 + 0.0045 * muscle.gauge_kpa() + 1e-2, "{elastic} N");
    }
}
