mod richardson;

use pam_autodiff::finite_difference::{DifferenceScheme, NAMES, from_name};
use pam_autodiff::{Central, ComplexDifference, Forward, FourPointSmoothed, Richardson};

/// The order at which the error falls when the step is halved.
fn order(coarse_step: f64, derivative: impl Fn(f64) -> f64) -> f64 {
    let exact = 0.7_f64.cos();
    let error = |h: f64| (derivative(h) - exact).abs();
    (error(coarse_step) / error(coarse_step / 2.0)).log2()
}

#[test]
fn orders_are_as_stated() {
    let f = |x: f64| x.sin();
    let cases = [
        (1.0, order(2e-3, |h| Forward { h }.derivative(&mut { f }, 0.7))),
        (2.0, order(2e-3, |h| Central { h }.derivative(&mut { f }, 0.7))),
        (2.0, order(2e-3, |h| FourPointSmoothed { h }.derivative(&mut { f }, 0.7))),
        (2.0, order(2e-3, |h| Richardson { h, levels: 1 }.derivative(&mut { f }, 0.7))),
        (4.0, order(0.1, |h| Richardson { h, levels: 2 }.derivative(&mut { f }, 0.7))),
        (6.0, order(0.4, |h| Richardson { h, levels: 3 }.derivative(&mut { f }, 0.7))),
        (2.0, order(2e-3, |h| ComplexDifference { h }.derivative(num_dual::DualNum::sin, 0.7))),
    ];
    for (k, (stated, found)) in cases.into_iter().enumerate() {
        assert!((stated - found).abs() < 0.05, "case {k}: {stated} {found}");
    }
}

#[test]
fn all_are_exact_on_a_straight_line() {
    for name in NAMES {
        let scheme = from_name(name).unwrap();
        assert_eq!(&scheme.name(), name);
        let found = scheme.derivative(&mut |x| 3.0 * x - 1.0, 2.0);
        assert!((found - 3.0).abs() < 1e-7, "{name}: {found}");
    }
    assert!(from_name("sideways").err().unwrap().to_string().contains("richardson"));
}
