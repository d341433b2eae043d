use pam_autodiff::Richardson;

#[test]
fn the_estimate_bounds_the_error() {
    type Plain = fn(f64) -> f64;
    let functions: [(Plain, Plain); 3] = [
        (f64::exp, f64::exp),
        (f64::tan, |x| 1.0 + x.tan().powi(2)),
        (|x| 1.0 / (1.0 + 25.0 * x * x), |x| -50.0 * x / (1.0 + 25.0 * x * x).powi(2)),
    ];
    for (f, slope) in functions {
        for x in [-0.8, 0.1, 1.2] {
            let found = Richardson::default().estimate(&mut { f }, x);
            let error = (found.derivative - slope(x)).abs();
            assert!(error <= 10.0 * found.error + 1e-12, "{x}: {error} {found:?}");
            assert!(error < 1e-8, "{x}: {error}");
        }
    }
}
