use pam_baselines::regression::Moments;
use pam_numerics::least_squares;

/// A linear map is found again from exact rows, in as many blocks as it takes.
#[test]
fn an_exact_map_is_found() {
    let map = [[1.0, -2.0, 0.5], [0.0, 3.0, -1.0]];
    let row = |k: usize| {
        let t = k as f64 * 0.37;
        [1.0, t.sin(), (1.7 * t).cos()]
    };
    let mut moments = Moments::new(3, 2);
    let mut other = Moments::new(3, 2);
    for k in 0..1400 {
        let part = if k < 900 { &mut moments } else { &mut other };
        part.add(|f, y| {
            f.copy_from_slice(&row(k));
            for (y, m) in y.iter_mut().zip(&map) {
                *y = m.iter().zip(row(k)).map(|(m, r)| m * r).sum();
            }
        });
    }
    moments.merge(other);
    assert_eq!(moments.rows(), 1400);
    let found = moments.solve(0.0).unwrap();
    for (f, m) in found.iter().zip(map.iter().flatten()) {
        assert!((f - m).abs() < 1e-12, "{f} {m}");
    }
}

#[test]
fn dependent_features_need_a_ridge() {
    let rows = || (0..50).map(|k| ([f64::from(k), 2.0 * f64::from(k)], f64::from(5 * k)));
    assert!(least_squares(rows(), 0.0).is_none_or(|f| (f[0] + 2.0 * f[1] - 5.0).abs() < 1e-3));
    let [a, b] = least_squares(rows(), 1e-9).unwrap();
    assert!((a + 2.0 * b - 5.0).abs() < 1e-6);
}
