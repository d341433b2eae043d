use pam_core::simd::Float;
use pam_core::simd::math::{exp_m1_and_exp, ln_1p_unit, sigmoid, tanh};

/// Against the standard library, relative to the larger of value and 1e-300.
fn worst<T: Float>(fast: impl Fn(T) -> T, exact: impl Fn(f64) -> f64, range: f64) -> f64 {
    (-4000..=4000)
        .map(|k| T::narrow(f64::from(k) / 4000.0 * range))
        .chain([1e-12, -1e-7, 3e-4].map(T::narrow))
        .map(|x| {
            let e = exact(x.widen());
            (fast(x).widen() - e).abs() / e.abs().max(1e-300)
        })
        .fold(0.0, f64::max)
}

#[test]
fn elementary_functions_are_accurate() {
    assert!(worst::<f64>(|x| exp_m1_and_exp(x).1, f64::exp, 700.0) < 4e-16);
    assert!(worst::<f64>(|x| exp_m1_and_exp(x).0, f64::exp_m1, 3.0) < 1e-15);
    assert!(worst::<f64>(tanh, f64::tanh, 20.0) < 1e-15);
    assert!(worst::<f64>(sigmoid, |x| 1.0 / (1.0 + (-x).exp()), 30.0) < 1e-15);
    assert!(worst::<f64>(|x| ln_1p_unit(x.magnitude()), |x| x.abs().ln_1p(), 1.0) < 1e-15);
    assert!(worst::<f32>(|x| exp_m1_and_exp(x).1, f64::exp, 80.0) < 3e-7);
    assert!(worst::<f32>(|x| exp_m1_and_exp(x).0, f64::exp_m1, 3.0) < 4e-7);
    assert!(worst::<f32>(tanh, f64::tanh, 9.0) < 4e-7);
    assert!(worst::<f32>(|x| ln_1p_unit(x.magnitude()), |x| x.abs().ln_1p(), 1.0) < 4e-7);
}

#[test]
fn arguments_out_of_range_saturate() {
    assert_eq!(tanh(1e4_f64), 1.0);
    assert_eq!(tanh(-1e30_f32), -1.0);
    assert_eq!(sigmoid(1e4_f64), 1.0);
    assert!(sigmoid(-1e4_f64) < 1e-300);
    assert!(tanh(f64::NAN).is_nan());
}
