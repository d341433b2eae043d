use pam_train::optimiser::clip_to_norm;

#[test]
fn long_gradients_are_cut_and_short_ones_left() {
    let mut g = [3.0, 4.0];
    assert_eq!(clip_to_norm(&mut g, 1.0), 5.0);
    assert!((g[0] - 0.6).abs() < 1e-15 && (g[1] - 0.8).abs() < 1e-15);
    let mut g = [0.3, 0.4];
    clip_to_norm(&mut g, 1.0);
    assert_eq!(g, [0.3, 0.4]);
}
