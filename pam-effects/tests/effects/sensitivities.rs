//! Derivatives that the fits use, against differences of plain runs.

use crate::support::published::{exact_run, weights};
use crate::support::values::medium;
use pam_core::Scalar;
use pam_data::MassOrigin;
use pam_effects::effects::{ALL, ActivityWindow, AnyEffect, Derivatives, by_id, timed};
use pam_effects::simulation::{Base, Nuisances, Trajectory, Trial, simulate};

/// Effects under which a chamber holds other air than the force table stands at. The table's slopes along the
/// masses vary with x and ẋ, and its derivatives leave that variation out: a few parts in a hundred at 3 % of
/// air.
const MOVES_THE_AIR: [&str; 5] =
    ["leak", "pressure_bias", "pressure_gain", "position_offset", "position_gain"];

/// Variation of the channels in these runs: mm, mm/s, kPa, kPa.
const UNITS: [f64; 4] = [2.0, 20.0, 30.0, 30.0];

#[test]
fn every_effect_is_among_them() {
    let listed = medium();
    for effect in ALL {
        let id = effect.info().id;
        let values = &listed.iter().find(|m| m.0 == id).unwrap_or_else(|| panic!("{id}")).1;
        assert_eq!(values.len(), effect.info().value_len(), "{id}");
    }
}

fn plain(
    trial: &Trial,
    base: &Base<f64>,
    effect: &dyn AnyEffect,
    values: &[f64],
) -> Trajectory<f64> {
    let mut out = Trajectory::default();
    simulate::<f64>(trial, base, &[effect], values, &Nuisances::none(), &mut out)
        .expect("in range");
    out
}

/// The derivative of every channel with respect to every parameter is that of the steps taken: it equals
/// central differences of the same simulation up to an error of second order in the change, and rounding.
#[test]
fn sensitivities_are_the_derivatives_of_the_simulation() {
    let model = weights();
    let mut subject = exact_run(&model, [30.0, 60.0], 0.08);
    subject.origin = MassOrigin::GasLaw;
    let trial = Trial::new(&model, &subject);
    let base = Base::of(&model);
    for (id, values) in medium() {
        compare(&trial, &base, by_id(id).expect("an id"), &values);
    }
}

/// The same of effects that begin and end within the run, by these times as well.
#[test]
fn sensitivities_by_times_are_the_derivatives_of_the_simulation() {
    let model = weights();
    let mut subject = exact_run(&model, [30.0, 60.0], 0.08);
    subject.origin = MassOrigin::GasLaw;
    let trial = Trial::new(&model, &subject);
    let base = Base::of(&model);
    for (id, values) in medium() {
        let effect = by_id(id).expect("an id");
        let (own, switches) = values.split_at(effect.info().parameters.len());
        let with = |times: &[f64]| [own, times, switches].concat();
        compare(&trial, &base, timed(effect, ActivityWindow::PASSES), &with(&[1.3127, 3.8713]));
        compare(&trial, &base, timed(effect, ActivityWindow::GROWS), &with(&[2.3127, 1.733]));
    }
}

/// Compares derivatives by all parameters with central differences.
fn compare(trial: &Trial, base: &Base<f64>, effect: &'static dyn AnyEffect, values: &[f64]) {
    let id = effect.info().id;
    let count = effect.info().parameters.len();
    let seeded: Vec<Derivatives> = values
        .iter()
        .enumerate()
        .map(
            |(k, &v)| {
                if k < count { Derivatives::variable(v, k) } else { Derivatives::constant(v) }
            },
        )
        .collect();
    let mut with = Trajectory::default();
    simulate::<Derivatives>(trial, base, &[effect], &seeded, &Nuisances::none(), &mut with)
        .expect("in range");
    let centre = plain(trial, base, effect, values);
    for (c, unit) in UNITS.into_iter().enumerate() {
        for (k, exact) in with.channels[c].iter().enumerate() {
            let value = (exact.value - centre.channels[c][k]).abs();
            assert!(value < 1e-9 * unit, "{id}: value at {k} differs by {value}");
        }
    }
    for (parameter, info) in effect.info().parameters.iter().enumerate() {
        // A kink of the network that lies within a change spoils that difference: the best one of four.
        let relative = [1e-5, 1e-6, 1e-7, 1e-8]
            .map(|share| {
                let change = share * values[parameter].abs();
                let moved = |sign: f64| {
                    let mut values = values.to_vec();
                    values[parameter] += sign * change;
                    plain(trial, base, effect, &values)
                };
                let (up, down) = (moved(1.0), moved(-1.0));
                let (mut miss, mut size) = (0.0, 0.0);
                for (c, unit) in UNITS.into_iter().enumerate() {
                    for k in 0..trial.record.points() {
                        let exact = with.channels[c][k].derivatives[parameter];
                        let by_difference =
                            (up.channels[c][k] - down.channels[c][k]) / (2.0 * change);
                        miss += ((by_difference - exact) / unit).powi(2);
                        size += (by_difference / unit).powi(2);
                    }
                }
                // Where it changes nothing, its derivative is zero.
                if size == 0.0 { miss } else { (miss / size).sqrt() }
            })
            .into_iter()
            .fold(f64::INFINITY, f64::min);
        println!("{id} {}: {relative:.2e}", info.name);
        let most = if MOVES_THE_AIR.contains(&id) { 1e-4 } else { 2e-6 };
        assert!(relative < most, "{id} {}: {relative:e}", info.name);
    }
}

/// The derivative with respect to a delay does not vanish at zero delay, so a fit that reaches zero can leave it.
#[test]
fn a_delay_has_a_derivative_where_it_is_zero() {
    let model = weights();
    let trial = Trial::new(&model, &exact_run(&model, [45.0, 45.0], 0.08));
    let base = Base::of(&model);
    for id in ["actuation_delay", "position_delay", "pressure_delay"] {
        let effect = by_id(id).expect("an id");
        let mut with = Trajectory::default();
        let zero = [Derivatives::variable(0.0, 0)];
        simulate::<Derivatives>(&trial, &base, &[effect], &zero, &Nuisances::none(), &mut with)
            .expect("in range");
        let small_ms = 1e-3;
        let [none, some] = [0.0, small_ms].map(|ms| plain(&trial, &base, effect, &[ms]));
        let (mut miss, mut size) = (0.0, 0.0);
        for (c, unit) in UNITS.into_iter().enumerate() {
            for (k, exact) in with.channels[c].iter().enumerate() {
                assert!((exact.value - none.channels[c][k]).abs() < 1e-9 * unit, "{id}: {k}");
                let change = (some.channels[c][k] - none.channels[c][k]) / small_ms;
                miss += ((change - exact.derivatives[0]) / unit).powi(2);
                size += (change / unit).powi(2);
            }
        }
        let relative = (miss / size).sqrt();
        assert!(size > 0.0 && relative < 1e-2, "{id}: {relative:e}");
    }
}

/// The same by what a recording leaves uncertain.
#[test]
fn sensitivities_by_uncertain_numbers() {
    let model = weights();
    let trial = Trial::new(&model, &exact_run(&model, [45.0, 45.0], 0.08));
    let base = Base::of(&model);
    let of = |k: usize, v: f64| {
        let mut n = Nuisances::<f64>::none();
        let [a, b] = &mut n.log_air;
        *[&mut n.log_mass, &mut n.log_deformation, &mut n.start_mm, &mut n.start_mm_s, a, b][k] = v;
        let mut out = Trajectory::default();
        simulate::<f64>(&trial, &base, &[], &[], &n, &mut out).expect("in range");
        out
    };
    let mut n = Nuisances::<Derivatives>::none();
    let [a, b] = &mut n.log_air;
    let all = [&mut n.log_mass, &mut n.log_deformation, &mut n.start_mm, &mut n.start_mm_s, a, b];
    for (k, value) in all.into_iter().enumerate() {
        *value = Derivatives::variable(0.0, k);
    }
    let mut with = Trajectory::default();
    simulate::<Derivatives>(&trial, &base, &[], &[], &n, &mut with).expect("in range");
    for k in 0..6 {
        let change = 1e-6;
        let (up, down) = (of(k, change), of(k, -change));
        let (mut miss, mut size) = (0.0, 0.0);
        for c in [0, 2, 3] {
            for i in 0..trial.record.points() {
                let by_difference = (up.channels[c][i] - down.channels[c][i]) / (2.0 * change);
                miss += (by_difference - with.channels[c][i].derivatives[k]).powi(2);
                size += by_difference.powi(2);
            }
        }
        let relative = (miss / size).sqrt();
        println!("uncertain {k}: {relative:.2e}");
        assert!(relative < 1e-4, "uncertain {k}: {relative:e}");
    }
}
