use pam_trajectory::metrics::{r2, rmse};

#[test]
fn r2_and_rmse_on_known_values() {
    let measured = [1.0, 2.0, 3.0, 4.0];
    assert_eq!(r2(&measured, &measured), 1.0);
    assert_eq!(r2(&measured, &[2.5; 4]), 0.0);
    // Residuals 1, −1, 1, −1: Σ = 4, total = 5.
    assert!((r2(&measured, &[0.0, 3.0, 2.0, 5.0]) - 0.2).abs() < 1e-15);
    assert_eq!(rmse(&measured, &[0.0, 3.0, 2.0, 5.0]), 1.0);
    assert!(r2(&[2.0, 2.0], &[2.0, 2.0]).is_nan());
    // A stuck channel that rounding moves: 0.1 + 0.2 is not 0.3.
    let stuck = [0.3, 0.1 + 0.2, 0.3, 0.3];
    assert!(stuck[0] != stuck[1] && r2(&stuck, &[1.0; 4]).is_nan());
}
