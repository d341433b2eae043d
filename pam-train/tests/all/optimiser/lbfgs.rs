use pam_train::optimiser::{Lbfgs, LbfgsSettings, StepKind};

type Sample = Option<(f64, Vec<f64>)>;

/// Rosenbrock's valley; its minimum is zero at (1, 1).
fn rosenbrock(at: &[f64]) -> Sample {
    let (x, y) = (at[0], at[1]);
    let (a, b) = (1.0 - x, y - x * x);
    Some((a * a + 100.0 * b * b, vec![-2.0 * a - 400.0 * x * b, 200.0 * b]))
}

/// `Σ 10^(4k/(n − 1)) (x_k − k)²`.
fn quadratic(at: &[f64]) -> Sample {
    let last = (at.len() - 1) as f64;
    let weight = |k: usize| 10_f64.powf(4.0 * k as f64 / last);
    let value = at.iter().enumerate().map(|(k, x)| weight(k) * (x - k as f64).powi(2)).sum();
    Some((value, at.iter().enumerate().map(|(k, x)| 2.0 * weight(k) * (x - k as f64)).collect()))
}

#[test]
fn it_finds_the_end_of_the_valley() {
    let mut lbfgs = Lbfgs::new(LbfgsSettings::default(), 2);
    let mut at = [-1.2, 1.0];
    let (mut value, mut evaluations, mut steps) = (f64::INFINITY, 0, 0);
    while value >= 1e-10 {
        let outcome = lbfgs.minimise_step(&mut at, &mut rosenbrock);
        assert_eq!(outcome.kind, StepKind::Moved);
        assert!(outcome.value < value, "values never rise");
        assert_eq!(Some(outcome.value), rosenbrock(&at).map(|s| s.0));
        value = outcome.value;
        evaluations += outcome.evaluations;
        steps += 1;
        assert!(steps < 100);
    }
    assert!(at.iter().all(|x| (x - 1.0).abs() < 1e-4), "{at:?}");
    assert!(evaluations < 100, "{evaluations}");
}

#[test]
fn it_finds_the_minimum_of_a_bad_quadratic() {
    let mut lbfgs = Lbfgs::new(LbfgsSettings::default(), 10);
    let mut at = vec![100.0; 10];
    for _ in 0..500 {
        lbfgs.minimise_step(&mut at, &mut quadratic);
    }
    for (k, x) in at.iter().enumerate() {
        assert!((x - k as f64).abs() < 1e-6, "{k}: {x}");
    }
}

/// x − ln x has its minimum at 1 and no value below 0, where the first trial goes.
#[test]
fn solves_that_diverge_are_walls() {
    let settings = LbfgsSettings { first_step: 50.0, ..LbfgsSettings::default() };
    let mut lbfgs = Lbfgs::new(settings, 1);
    let mut at = [5.0];
    let mut refused = 0;
    for _ in 0..30 {
        lbfgs.minimise_step(&mut at, &mut |at: &[f64]| {
            let x = at[0];
            refused += usize::from(x <= 0.0);
            (x > 0.0).then(|| (x - x.ln(), vec![1.0 - 1.0 / x]))
        });
    }
    assert!((at[0] - 1.0).abs() < 1e-6, "{at:?}");
    assert!(refused > 0);
}

#[test]
fn a_written_state_goes_on_bit_by_bit() {
    let mut at = vec![3.0; 50];
    let mut lbfgs = Lbfgs::new(LbfgsSettings { memory: 4, ..LbfgsSettings::default() }, 50);
    for _ in 0..7 {
        lbfgs.minimise_step(&mut at, &mut quadratic);
    }
    let mut other: Lbfgs = serde_json::from_str(&serde_json::to_string(&lbfgs).unwrap()).unwrap();
    assert_eq!(other, lbfgs);
    let mut other_at = at.clone();
    for _ in 0..7 {
        let outcome = lbfgs.minimise_step(&mut at, &mut quadratic);
        assert_eq!(other.minimise_step(&mut other_at, &mut quadratic), outcome);
        assert_eq!(other_at, at);
    }
}

#[test]
fn points_from_which_there_is_no_step_are_named() {
    let step = |f: &mut dyn FnMut(&[f64]) -> Sample| {
        let mut at = [2.0];
        let outcome = Lbfgs::new(LbfgsSettings::default(), 1).minimise_step(&mut at, f);
        assert_eq!(at, [2.0]);
        outcome.kind
    };
    assert_eq!(step(&mut |_| Some((1.0, vec![0.0]))), StepKind::Stationary);
    assert_eq!(step(&mut |_| None), StepKind::Undefined);
    assert_eq!(step(&mut |_| Some((f64::NAN, vec![0.0]))), StepKind::Undefined);
    // A gradient of the wrong sign.
    assert_eq!(step(&mut |at| Some((at[0], vec![-1.0]))), StepKind::Stuck);
}

/// At (2) of x², then of (x − 3)²: without being told it would take the old value for the new one's.
#[test]
fn a_changed_function_is_evaluated_again() {
    let square = |centre: f64| {
        move |at: &[f64]| -> Sample {
            Some(((at[0] - centre).powi(2), vec![2.0 * (at[0] - centre)]))
        }
    };
    let mut lbfgs = Lbfgs::new(LbfgsSettings::default(), 1);
    let mut at = [2.0];
    for _ in 0..20 {
        lbfgs.minimise_step(&mut at, &mut square(0.0));
    }
    lbfgs.invalidate();
    for _ in 0..20 {
        lbfgs.minimise_step(&mut at, &mut square(3.0));
    }
    assert!((at[0] - 3.0).abs() < 1e-6, "{at:?}");
}

#[test]
fn no_step_is_longer_than_the_largest() {
    let settings = LbfgsSettings { largest_step: Some(0.3), ..LbfgsSettings::default() };
    let mut lbfgs = Lbfgs::new(settings, 2);
    let mut at = [-1.2, 1.0];
    for _ in 0..30 {
        let length = lbfgs.minimise_step(&mut at, &mut rosenbrock).length;
        assert!(length <= 0.3 * (1.0 + 1e-12), "{length}");
    }
}
