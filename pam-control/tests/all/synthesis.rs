//! The inverse synthesis against the published numbers, dense searches and a general optimiser.

mod certified;

use crate::common::{at_rest, published, winding};
use pam_control::ControlError;
use pam_control::motion::{MotionSpec, StiffnessProfile};
use pam_control::synthesis::plan::targets;
use pam_control::synthesis::{
    MassBounds, Outcome, Plan, Solution, SynthesisSettings, Synthesiser, Target,
};
use pam_core::units::MN_PER_N;
use pam_core::{AnyForce, ForceInput, ForceModel, JointModel, SealedMasses, SpringDamper};

type Model = JointModel<f64, AnyForce<f64>>;

fn force(model: &Model, masses: SealedMasses, x: f64, v: f64) -> f64 {
    let input = ForceInput {
        displacement_mm: x,
        velocity_mm_s: v,
        mass_flexor_g: masses.flexor_g,
        mass_extensor_g: masses.extensor_g,
    };
    let mut work = vec![0.0; ForceModel::<f64>::work_len(&model.force)];
    model.force.restoring_force_mn(&input, &mut work)
}

/// `m ẍ + f − F` and K̂ from the model itself.
fn check(model: &Model, target: &Target, masses: SealedMasses) -> (f64, f64) {
    let (x, v) = (target.displacement_mm, target.velocity_mm_s);
    let f = |offset: f64| force(model, masses, x + offset, v);
    let balance = model.physical().mass_kg * target.acceleration_mm_s2 + f(0.0) - target.load_mn;
    (balance, (f(2.0) + f(1.0) - f(-1.0) - f(-2.0)) / (6.0 * MN_PER_N))
}

fn motion(spec: &str, stiffness: f64, rate_hz: f64) -> Vec<Target> {
    let motion = MotionSpec::parse(spec).unwrap();
    targets(&motion, Some(&StiffnessProfile::Constant(stiffness)), 0.0, rate_hz).unwrap()
}

fn solve(model: &Model, targets: &[Target], bounds: MassBounds) -> Vec<Solution> {
    let settings = SynthesisSettings::published(bounds);
    Synthesiser::new(model, settings).unwrap().solve(targets).unwrap()
}

/// The published tests of tracking: every sample is dynamically consistent, and K̂ is K_d wherever the
/// solver says so.
#[test]
fn published_motions_are_met_to_the_tolerance() {
    let model = published();
    let bounds = MassBounds::trained(&model);
    for shape in ["sine", "triangle"] {
        for (amplitude, frequency, stiffness) in
            [(1.0, 0.1, 150.0), (2.0, 0.1, 150.0), (1.0, 1.0, 150.0), (1.0, 0.1, 160.0)]
        {
            let spec = format!("{shape}:A={amplitude},f={frequency},duration=2");
            let targets = motion(&spec, stiffness, 250.0);
            for (target, s) in targets.iter().zip(solve(&model, &targets, bounds)) {
                assert_ne!(s.outcome, Outcome::MotionUnreachable, "{spec}");
                let (balance, k) = check(&model, target, s.masses);
                assert!(balance.abs() <= 1e-3, "{spec}: {balance} mN at {} s", target.time_s);
                assert!((k - s.stiffness_n_mm).abs() < 1e-9);
                match s.outcome {
                    Outcome::Reached => assert!((k - stiffness).abs() <= 1e-6),
                    _ => {
                        let [low, high] = s.reachable_n_mm.unwrap();
                        assert!(!(low..=high).contains(&stiffness), "{spec}: {low} {high}");
                        assert!((k - stiffness.clamp(low, high)).abs() < 1e-6);
                    }
                }
            }
        }
    }
}

/// Along the equilibria at x = 0, with the flexor's air from 0.0315272 to 0.1211015 g (170 to 653 kPa) and
/// the extensor's such that f = 0, the published weights give 127.0 to 174.2 N/mm.
#[test]
fn the_published_stiffness_range_comes_out() {
    let model = published();
    let bounds = MassBounds::new(0.02, 0.14).unwrap();
    let synthesiser = Synthesiser::new(&model, SynthesisSettings::published(bounds)).unwrap();
    let branches = synthesiser.curve(&at_rest(0.0, 150.0));
    assert_eq!(branches.len(), 1);
    let stiffness_at = |flexor_g: f64| {
        let pair = branches[0]
            .windows(2)
            .find(|pair| (pair[0].0.flexor_g - flexor_g) * (pair[1].0.flexor_g - flexor_g) <= 0.0);
        let [a, b] = pair.unwrap() else { panic!("a pair") };
        let share = (flexor_g - a.0.flexor_g) / (b.0.flexor_g - a.0.flexor_g);
        a.1 + share * (b.1 - a.1)
    };
    let inside =
        branches[0].iter().filter(|(m, _)| (0.031_527_2..=0.121_101_5).contains(&m.flexor_g));
    let ends = [stiffness_at(0.031_527_2), stiffness_at(0.121_101_5)];
    let (low, high) = inside
        .map(|(_, k)| *k)
        .chain(ends)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), k| (a.min(k), b.max(k)));
    assert!((low - 127.0).abs() < 0.05 && (high - 174.2).abs() < 0.05, "{low} to {high} N/mm");
}

/// The least |K̂ − K_d| over a dense grid of consistent masses: for each of many flexor masses all
/// extensor masses at which the dynamics change sign between neighbours of a fine grid.
fn dense_search(model: &Model, target: &Target, bounds: MassBounds, n: usize) -> Option<f64> {
    let place = |k: usize, n: usize| bounds.least_g + bounds.width_g() * k as f64 / n as f64;
    let balance =
        |f: f64, e: f64| check(model, target, SealedMasses { flexor_g: f, extensor_g: e }).0;
    let mut best: Option<f64> = None;
    for i in 0..=n {
        let f = place(i, n);
        let mut last = balance(f, place(0, n));
        for j in 1..=n {
            let (mut low, mut high) = (place(j - 1, n), place(j, n));
            let now = balance(f, high);
            if (last > 0.0) != (now > 0.0) {
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if (balance(f, middle) > 0.0) == (now > 0.0) {
                        high = middle;
                    } else {
                        low = middle;
                    }
                }
                let masses = SealedMasses { flexor_g: f, extensor_g: low };
                let miss = (check(model, target, masses).1 - target.stiffness_n_mm).abs();
                best = Some(best.map_or(miss, |b| b.min(miss)));
            }
            last = now;
        }
    }
    best
}

fn assert_no_worse_than_dense(model: &Model, target: &Target, bounds: MassBounds, n: usize) {
    let solution = solve(model, &[*target], bounds)[0];
    let dense = dense_search(model, target, bounds, n);
    let miss = (solution.stiffness_n_mm - target.stiffness_n_mm).abs();
    match dense {
        Some(dense) => {
            assert!(miss <= dense + 1e-6, "{miss} against {dense} of a dense search: {target:?}");
            assert!(solution.residual_mn.abs() <= 1e-3);
        }
        None => assert_eq!(solution.outcome, Outcome::MotionUnreachable),
    }
}

#[test]
fn no_dense_search_finds_a_nearer_stiffness() {
    let model = published();
    let bounds = MassBounds::trained(&model);
    for (x, v, k) in [(0.0, 0.0, 150.0), (0.3, 5.0, 170.0), (-1.5, 0.0, 120.0), (2.0, -3.0, 160.0)]
    {
        let target = Target { velocity_mm_s: v, ..at_rest(x, k) };
        assert_no_worse_than_dense(&model, &target, bounds, 60);
    }
}

/// Forces that no joint has, with several branches and many extremes of K̂.
#[test]
fn winding_forces_are_searched_globally() {
    for activation in ["leaky_relu", "tanh"] {
        for seed in [0.3, 1.7, 2.9] {
            let model = winding(activation, seed);
            let bounds = MassBounds::trained(&model);
            let still = check(
                &model,
                &at_rest(0.0, 150.0),
                SealedMasses { flexor_g: 0.08, extensor_g: 0.07 },
            );
            for (x, k) in [(0.0, still.1), (0.7, 1.0), (-0.4, 40.0)] {
                // The load makes a consistent pair sure at the first point.
                let target = Target { load_mn: still.0, ..at_rest(x, k.abs().max(0.01)) };
                assert_no_worse_than_dense(&model, &target, bounds, 120);
            }
        }
    }
}

/// A general constrained optimiser (SLSQP) from the solution's neighbourhood finds nothing better, and from
/// afar it ends at the same masses.
#[test]
fn a_general_optimiser_agrees() {
    let model = published();
    let bounds = MassBounds::trained(&model);
    let width = bounds.width_g();
    for (x, v, k) in [(0.0, 0.0, 150.0), (0.8, 0.4, 155.0), (-1.0, -0.2, 160.0)] {
        let target = Target { velocity_mm_s: v, ..at_rest(x, k) };
        let ours = solve(&model, &[target], bounds)[0];
        let masses = |u: &[f64]| SealedMasses {
            flexor_g: bounds.least_g + width * u[0],
            extensor_g: bounds.least_g + width * u[1],
        };
        let objective = |u: &[f64]| (check(&model, &target, masses(u)).1 - k).powi(2);
        let balance = |u: &[f64]| 1e-3 * check(&model, &target, masses(u)).0;
        let by_difference = |f: &dyn Fn(&[f64]) -> f64, u: &[f64], g: &mut [f64]| {
            for i in 0..2 {
                let (mut a, mut b) = ([u[0], u[1]], [u[0], u[1]]);
                a[i] -= 1e-7;
                b[i] += 1e-7;
                g[i] = (f(&b) - f(&a)) / 2e-7;
            }
        };
        // Two inequalities stand for the equality.
        let above = |u: &[f64], g: Option<&mut [f64]>, _: &mut ()| {
            if let Some(g) = g {
                by_difference(&balance, u, g);
            }
            balance(u)
        };
        let below = |u: &[f64], g: Option<&mut [f64]>, _: &mut ()| {
            if let Some(g) = g {
                by_difference(&|u| -balance(u), u, g);
            }
            -balance(u)
        };
        let cost = |u: &[f64], g: Option<&mut [f64]>, _: &mut ()| {
            if let Some(g) = g {
                by_difference(&objective, u, g);
            }
            objective(u)
        };
        let constraints: Vec<&dyn slsqp::Func<()>> = vec![&above, &below];
        let found = slsqp::minimize(
            cost,
            &[0.5, 0.5],
            &[(0.0, 1.0), (0.0, 1.0)],
            &constraints,
            (),
            200,
            None,
        );
        let (_, u, value) =
            found.unwrap_or_else(|(_, u, value)| (slsqp::SuccessStatus::Success, u, value));
        assert!(value < 1e-4, "SLSQP ends at {value} (N/mm)²");
        let theirs = masses(&u);
        assert!((theirs.flexor_g - ours.masses.flexor_g).abs() < 2e-5, "{theirs:?} {ours:?}");
        assert!((theirs.extensor_g - ours.masses.extensor_g).abs() < 2e-5);
    }
}

/// For a linear spring the masses are known: their sum gives the stiffness, their difference the position.
#[test]
fn a_spring_has_its_closed_form() {
    let spring = SpringDamper { shift_per_mass_mm_g: 30.0, ..SpringDamper::<f64>::published() };
    let model: Model = JointModel::datasheet(AnyForce::SpringDamper(spring));
    let targets = motion("sine:A=0.5,f=0.5,x0=0.1", 150.0, 100.0);
    for (t, s) in targets.iter().zip(solve(&model, &targets, MassBounds::trained(&model))) {
        let total = (150e3 - spring.stiffness_mn_mm) / spring.stiffness_per_mass_mn_mm_g;
        let wanted_force = -model.physical().mass_kg * t.acceleration_mm_s2
            - spring.damping_kg_s * t.velocity_mm_s;
        let difference = (t.displacement_mm - wanted_force / 150e3) / 30.0;
        assert_eq!(s.outcome, Outcome::Reached);
        assert!((s.masses.flexor_g + s.masses.extensor_g - total).abs() < 1e-9);
        assert!((s.masses.flexor_g - s.masses.extensor_g - difference).abs() < 1e-9);
    }
}

#[test]
fn threads_and_lanes_change_nothing_that_matters() {
    let model = published();
    let bounds = MassBounds::trained(&model);
    let targets = motion("sine:A=1,f=0.5", 150.0, 500.0);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let two = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    let a = one.install(|| solve(&model, &targets, bounds));
    let b = two.install(|| solve(&model, &targets, bounds));
    assert_eq!(a, b);
    let settings = SynthesisSettings { segments: 3, ..SynthesisSettings::published(bounds) };
    let c = Synthesiser::new(&model, settings).unwrap().solve(&targets).unwrap();
    for (a, c) in a.iter().zip(&c) {
        assert!((a.masses.flexor_g - c.masses.flexor_g).abs() < 1e-9);
    }
}

/// The plan of a period, repeated, is the plan of all samples.
#[test]
fn a_period_is_planned_once() {
    let model = published();
    let bounds = MassBounds::trained(&model);
    let settings = SynthesisSettings::published(bounds);
    let targets = motion("sine:A=1,f=0.5,duration=5", 150.0, 100.0);
    let all = Plan::new(&model, targets.clone(), settings).unwrap();
    let repeated = Plan::periodic(&model, targets, 200, settings).unwrap();
    assert_eq!(repeated.solutions[450], repeated.solutions[50]);
    for (a, b) in all.solutions.iter().zip(&repeated.solutions) {
        assert!((a.masses.flexor_g - b.masses.flexor_g).abs() < 1e-8, "{a:?} {b:?}");
        assert!((a.masses.extensor_g - b.masses.extensor_g).abs() < 1e-8, "{a:?} {b:?}");
    }
    for (k, (a, b)) in all.targets.iter().zip(&repeated.targets).enumerate() {
        assert_eq!(a.time_s, b.time_s);
        assert!((a.displacement_mm - b.displacement_mm).abs() < 1e-9, "sample {k}");
    }
}

#[test]
fn what_cannot_be_reached_is_said() {
    let model = published();
    let bounds = MassBounds::trained(&model);
    let settings = SynthesisSettings::published(bounds);
    let plan = Plan::new(&model, motion("hold:x=0", 190.0, 10.0), settings).unwrap();
    let summary = plan.summary();
    assert_eq!(summary.nearest_stiffness, summary.samples);
    assert!(summary.stiffness_n_mm[1] < 175.0 && summary.largest_stiffness_error_n_mm > 15.0);
    assert_eq!(summary.extrapolated, 0);
    match Plan::new(&model, motion("sine:A=3,f=4", 150.0, 100.0), settings) {
        Err(ControlError::Motion { missing_n, count, samples, .. }) => {
            assert!(missing_n > 1.0 && count > 0 && count <= samples);
        }
        other => panic!("{other:?}"),
    }
    let mut targets = motion("hold:x=0", 150.0, 10.0);
    targets[3].velocity_mm_s = f64::NAN;
    let message = Plan::new(&model, targets, settings).unwrap_err().to_string();
    assert!(message.contains("velocity") && message.contains("NaN"), "{message}");
    let wide = SynthesisSettings::published(MassBounds::new(0.02, 0.2).unwrap());
    let plan = Plan::new(&model, motion("hold:x=0", 178.0, 10.0), wide).unwrap();
    assert!(plan.extrapolates(0) && plan.summary().extrapolated > 0);
    assert!(MassBounds::new(0.1, 0.05).is_err());
}

/// Samples that hold the nearest stiffness hold the motion as exactly as all others, also where the smooth force's
/// curve ends at a wall of the bounds.
#[test]
fn the_nearest_stiffness_keeps_the_motion() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../pam-cli/models/default.safetensors");
    let model = pam_data::load_model(path).unwrap().model;
    let targets = motion("sine:A=1,f=0.1,duration=2", 176.0, 100.0);
    let solutions = solve(&model, &targets, MassBounds::new(0.02, 0.15).unwrap());
    let mut nearest = 0;
    for (target, s) in targets.iter().zip(&solutions) {
        let (balance, _) = check(&model, target, s.masses);
        assert!(balance.abs() <= 1e-3, "{balance} mN at {} s", target.time_s);
        nearest += usize::from(s.outcome == Outcome::NearestStiffness);
    }
    assert!(nearest > 50 && nearest < solutions.len(), "{nearest}");
}

/// The nearest stiffness of the smooth default model, also where it lies at a wall of the bounds (2.129 s and
/// 7.121 s) or between the vertices of the curve.
#[test]
fn the_default_models_nearest_stiffness_is_the_nearest() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../pam-cli/models/default.safetensors");
    let model = pam_data::load_model(path).unwrap().model;
    let bounds = MassBounds::trained(&model);
    let targets = motion("sine:A=2,f=0.1,duration=9", 150.0, 1000.0);
    for k in [1600, 1900, 2129, 2500, 3300, 7121, 7123, 8000] {
        assert_no_worse_than_dense(&model, &targets[k], bounds, 80);
    }
}
