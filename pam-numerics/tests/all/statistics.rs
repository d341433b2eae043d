use pam_numerics::statistics::{
    mean, mean_half_width_95, median, paired_t_test, quantile, resolution, root_mean_square,
    standard_deviation, t_quantile_95,
};

/// The extra hours of sleep of Student (1908), drug 2 less drug 1.
const SLEEP: [f64; 10] = [1.2, 2.4, 1.3, 1.3, 0.0, 1.0, 1.8, 0.8, 4.6, 1.4];

/// t = 4.0621, p = 0.002833; interval 0.700114 to 2.459886.
#[test]
fn students_sleep_data() {
    let test = paired_t_test(&SLEEP).unwrap();
    assert_eq!(test.pairs, 10);
    assert!((test.mean_difference - 1.58).abs() < 1e-12);
    assert!((test.t - 4.0621).abs() < 1e-4 && (test.p - 0.002_833).abs() < 1e-6, "{test:?}");
    let half = mean_half_width_95(&SLEEP).unwrap();
    assert!((half - (2.459_886 - 1.58)).abs() < 1e-5, "{half}");
    assert!(paired_t_test(&SLEEP[..1]).is_none());
    assert!(paired_t_test(&[1.0, 1.0]).is_none());
    assert!(mean_half_width_95(&SLEEP[..1]).is_none());
}

/// Tabulated: t₀.₉₇₅ is 12.7062 for 1, 2.2281 for 10, 1.9799 for 120, 1.95996 for infinitely many degrees
/// of freedom.
#[test]
fn quantiles_of_students_t() {
    for (freedom, t) in [(1.0, 12.7062), (10.0, 2.2281), (120.0, 1.9799), (1e8, 1.95996)] {
        assert!((t_quantile_95(freedom) - t).abs() < 5e-5, "{freedom}");
    }
    assert_eq!(t_quantile_95(0.0), 1.96);
}

/// `numpy.quantile([3, 1, 2, 10], [0, 0.1, 0.5, 0.75, 1])`.
#[test]
fn quantiles_of_numpy() {
    let values = [3.0, 1.0, 2.0, 10.0];
    for (share, q) in [(0.0, 1.0), (0.1, 1.3), (0.5, 2.5), (0.75, 4.75), (1.0, 10.0)] {
        assert!((quantile(&values, share) - q).abs() < 1e-14, "{share}");
    }
    assert_eq!((median(&[5.0, 1.0, 2.0]), median(&[7.0])), (2.0, 7.0));
    assert!(median(&[]).is_nan() && mean(&[]).is_nan() && root_mean_square(&[]).is_nan());
}

#[test]
fn moments_by_hand() {
    let values = [2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0];
    assert_eq!(mean(&values), 5.0);
    assert!((root_mean_square(&values) - 29.0_f64.sqrt()).abs() < 1e-14);
    assert!((standard_deviation(&values) - (32.0_f64 / 7.0).sqrt()).abs() < 1e-15);
    assert!(standard_deviation(&[1.0]).is_nan());
}

#[test]
fn resolution_is_the_step_of_a_sensor() {
    let motion = |k: usize| 3.0 * (0.05 * k as f64).sin() + 0.4;
    // Steps of 4096 per turn of a pulley of 6.875 mm radius.
    let step = std::f64::consts::TAU * 6.875 / 4096.0;
    let encoder: Vec<f64> = (0..2000).map(|k| step * (motion(k) / step).round()).collect();
    assert!((resolution(&encoder) / step - 1.0).abs() < 1e-9);
    // Rounding of decimals, with values that are missing between others.
    let rounded = [1.2, 1.5, 1.5, 2.1, 1.2, 2.1, 1.5, 1.2];
    assert!((resolution(&rounded) - 0.3).abs() < 1e-12);
    let smooth: Vec<f64> = (0..2000).map(motion).collect();
    assert_eq!(resolution(&smooth), 0.0);
    // Values that repeat without a common step.
    let repeated: Vec<f64> = (0..60).map(|k| motion(11 * (k % 7))).collect();
    assert_eq!(resolution(&repeated), 0.0);
    assert_eq!(resolution(&[2.0; 9]), 0.0);
    assert_eq!(resolution(&[]), 0.0);
}
