use pam_numerics::ScaledCholesky;

/// The Hilbert matrix of order 4 with its integer inverse, rows and columns scaled over 12 decades.
#[test]
fn badly_scaled_unknowns_are_solved() {
    let size = [1e-6, 1.0, 1e3, 1e6];
    let a = |i: usize, j: usize| size[i] * size[j] / (i + j + 1) as f64;
    let factor = ScaledCholesky::new(4, a, 0.0).unwrap();
    let inverse = [16.0, -120.0, 240.0, -140.0];
    let x = factor.solve(&[size[0], 0.0, 0.0, 0.0]).unwrap();
    for i in 0..4 {
        assert!((x[i] * size[i] / inverse[i] - 1.0).abs() < 1e-10, "{i}: {}", x[i]);
    }
}

#[test]
fn a_ridge_is_relative_to_the_diagonal() {
    let factor = ScaledCholesky::new(2, |i, j| if i == j { 1e8 } else { 0.0 }, 0.25).unwrap();
    let x = factor.solve(&[1e8, 5e8]).unwrap();
    assert!((x[0] - 0.8).abs() < 1e-14 && (x[1] - 4.0).abs() < 1e-14);
}

#[test]
fn unknowns_without_influence_stay_at_zero_and_indefinite_matrices_are_refused() {
    let a = [[2.0, 0.0], [0.0, 0.0]];
    let x = ScaledCholesky::new(2, |i, j| a[i][j], 0.0).unwrap().solve(&[4.0, 0.0]).unwrap();
    assert!((x[0] - 2.0).abs() < 1e-15 && x[1] == 0.0);
    let a = [[1.0, 2.0], [2.0, 1.0]];
    assert!(ScaledCholesky::new(2, |i, j| a[i][j], 0.0).is_none());
    assert!(ScaledCholesky::new(1, |_, _| f64::NAN, 0.0).is_none());
    assert!(ScaledCholesky::new(1, |_, _| -1.0, 0.0).is_none());
}
