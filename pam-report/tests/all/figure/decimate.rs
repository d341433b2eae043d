use pam_report::figure::{envelope, thin};

#[test]
fn an_envelope_keeps_extremes_and_order() {
    let x: Vec<f64> = (0..10_000).map(f64::from).collect();
    let mut y: Vec<f64> = x.iter().map(|v| (v * 0.01).sin()).collect();
    y[5001] = 9.0;
    let points = envelope(&x, &y, 100);
    assert!(points.len() <= 202);
    assert!(points.iter().any(|p| p.1 == 9.0));
    assert!(points.windows(2).all(|w| w[0].0 <= w[1].0));
    assert_eq!(thin(&x, &y, 100).len(), 100);
}
