//! What simulations leave out because it changes nothing.

use crate::support::published::{exact_run, weights};
use crate::support::values::medium;
use pam_core::Scalar;
use pam_data::preprocess::LowPass;
use pam_effects::effects::{
    AnyEffect, ChamberLaw, Command, Derivatives, EffectHooks, FixedState, Observed, Rest, by_id,
};
use pam_effects::simulation::{
    Base, Nuisances, Trajectory, Trial, motion_until, sensed, simulate, simulate_until,
};

/// A hook that an effect does not list returns what it would without the effect, wherever the joint is.
#[test]
fn hooks_that_are_not_listed_are_neutral() {
    for (id, values) in medium() {
        let effect: &dyn AnyEffect = by_id(id).expect("an id");
        let hooks: &dyn EffectHooks<f64> = effect;
        let listed = effect.hooks();
        let remembered = vec![0.3; effect.memory_len()];
        for (x, v) in [(1.7, -30.0), (-2.9, 0.02), (0.4, 11.0), (-0.1, -0.4)] {
            let mut joint = FixedState::at_rest([411.0, 307.0]);
            joint.time_s = 7.0;
            joint.restoring_mn = 2e4;
            joint.motion.displacement_mm = x;
            joint.motion.velocity_mm_s = v;
            joint.motion.driving_mn = 5e4;
            let at = joint.point();
            let mut memory = remembered.clone();
            if !listed.force {
                assert_eq!(hooks.force_mn(&values, &at, &memory), 0.0, "{id}");
            }
            if !listed.dry_friction {
                assert_eq!(hooks.dry_friction_mn(&values, &at, &memory), 0.0, "{id}");
            }
            if !listed.air_flow {
                assert_eq!(hooks.air_g_s(&values, &at, &memory), [0.0; 2], "{id}");
            }
            if !listed.advance {
                hooks.advance(&values, &at, &mut memory);
                assert_eq!(memory, remembered, "{id}");
            }
            if !listed.drive {
                let command = Command { time_s: 7.0, since_s: 2e-3, force_mn: 1e5 * x };
                assert_eq!(hooks.drive(&values, &command, &mut memory), 1e5 * x, "{id}");
            }
            if !listed.rest {
                let rest = || Rest {
                    start_s: 0.0,
                    start_force_mn: 0.0,
                    sealed_mm: x,
                    sealed_kpa: [411.0, 307.0],
                    start_mm: 0.5 * x,
                    start_kpa: [400.0, 300.0],
                };
                let mut read = rest();
                hooks.rest(&values, &mut read);
                let numbers = |r: Rest<f64>| (r.sealed_mm, r.sealed_kpa, r.start_mm, r.start_kpa);
                assert_eq!(numbers(read), numbers(rest()), "{id}");
            }
        }
        if !listed.constants {
            assert_eq!([hooks.delay_s(&values, 1.0), hooks.inertia_kg(&values, 1.0)], [0.0; 2]);
            let mut law = ChamberLaw::<f64>::plain();
            hooks.chamber(&values, 1.0, &mut law);
            assert_eq!(law, ChamberLaw::plain(), "{id}");
        }
        if !listed.observe {
            let series = || -> Vec<f64> { (0..50).map(|k| f64::from(k * k % 17)).collect() };
            let (mut x, mut v, mut pf, mut pe) = (series(), series(), series(), series());
            let mut seen = Observed {
                start_s: 0.0,
                step_s: 4e-3,
                half_step_forces_mn: &[0.0; 100],
                displacement_mm: &mut x,
                velocity_mm_s: &mut v,
                pressures_kpa: [&mut pf, &mut pe],
                before: None,
            };
            hooks.observe(&values, &mut seen);
            assert!([x, v, pf, pe].iter().all(|s| *s == series()), "{id}");
        }
    }
}

/// The low-pass looks ahead, and forgets what is far.
#[test]
fn a_run_up_to_a_point_is_the_beginning_of_the_whole_run() {
    let model = weights();
    let mut trial = Trial::new(&model, &exact_run(&model, [30.0, 60.0], 0.08));
    trial.record.low_pass = [LowPass::new(20.0, 1.0 / trial.record.step_s); 4];
    let (base, none) = (Base::of(&model), Nuisances::none());
    let friction = [by_id("coulomb_friction").expect("an id") as &dyn AnyEffect];
    let (mut whole, mut part) = (Trajectory::default(), Trajectory::default());
    simulate(&trial, &base, &friction, &[20.0], &none, &mut whole).expect("in range");
    let until = trial.record.points() / 2;
    let points = trial.record.points_for(until);
    assert!(until < points && points < until + 200);
    simulate_until(&trial, &base, &friction, &[20.0], &none, points, &mut part).expect("in range");
    for (part, whole) in part.channels.iter().zip(&whole.channels) {
        assert_eq!(part.len(), points);
        assert_eq!(part[..until], whole[..until]);
    }
}

/// Delays and low-passes of sensors and play before the encoder leave the motion, so its derivatives are zero, and what the
/// sensors show of it is that of the simulation bit for bit.
#[test]
fn sensors_show_a_motion_that_is_simulated_once() {
    let model = weights();
    let trial = Trial::new(&model, &exact_run(&model, [30.0, 60.0], 0.08));
    let (base, points) = (Base::of(&model), trial.record.points());
    let motion = motion_until(&trial, &base, &[], &[], &Nuisances::none(), points);
    let motion = motion.expect("in range");
    let mut count = 0;
    for (id, values) in medium() {
        let effects = [by_id(id).expect("an id") as &dyn AnyEffect];
        if !effects[0].hooks().leave_the_motion() {
            continue;
        }
        count += 1;
        let values: Vec<Derivatives> =
            values.iter().enumerate().map(|(k, &v)| Derivatives::variable(v, k)).collect();
        let (mut once, mut anew) = (Trajectory::default(), Trajectory::default());
        sensed(&trial, &effects, &values, &motion, &mut once);
        let none = Nuisances::none();
        simulate(&trial, &base, &effects, &values, &none, &mut anew).expect("in range");
        for (once, anew) in once.channels.iter().zip(&anew.channels) {
            for (a, b) in once.iter().zip(anew) {
                assert_eq!(a.real().to_bits(), b.real().to_bits(), "{id}");
                assert_eq!(a.derivatives, b.derivatives, "{id}");
            }
        }
    }
    assert_eq!(count, 5);
}
