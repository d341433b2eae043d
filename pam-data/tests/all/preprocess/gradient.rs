use pam_data::preprocess::{gradient, gradient_at_times};

#[test]
fn agrees_with_numpy() {
    // numpy.gradient([1, 4, 9, 16, 30], 0.5) and with coordinates [0, 1, 1.5, 3.5, 4].
    assert_eq!(gradient(&[1.0, 4.0, 9.0, 16.0, 30.0], 0.5), [6.0, 8.0, 12.0, 21.0, 28.0]);
    let g = gradient_at_times(&[1.0, 4.0, 9.0, 16.0, 30.0], &[0.0, 1.0, 1.5, 3.5, 4.0]);
    let expected = [3.0, 7.666_666_666_666_667, 8.7, 23.1, 28.0];
    for (a, b) in g.iter().zip(expected) {
        assert!((a - b).abs() < 1e-12);
    }
}
