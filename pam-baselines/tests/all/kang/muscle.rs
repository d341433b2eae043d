use pam_baselines::kang::{KangMuscle, MuscleSize};
use std::f64::consts::PI;

/// Without correction the force is that of the ideal braid: zero at cos²α = 1/3 (54.7°), the neutral
/// angle, and A0 p (3/tan² − 1/sin²) at ε = 0.
#[test]
fn the_ideal_muscle_is_the_textbook_one() {
    let mut m = KangMuscle::published_guess(MuscleSize::JOINT);
    (m.correction, m.viscous_ns, m.dry_n) = (0.0, 0.0, 0.0);
    m.braid_angle_deg = 25.0;
    // (1 − ε)² cos²α0 = cos²α: the neutral angle is reached where it equals 1/3.
    let neutral = 1.0 - (1.0_f64 / 3.0).sqrt() / 25.0_f64.to_radians().cos();
    assert!(m.elastic_n(400.0, neutral).abs() < 1e-9);
    let area = PI * 25.0;
    let (t, s) = (25.0_f64.to_radians().tan(), 25.0_f64.to_radians().sin());
    let expected = 0.4 * area * (3.0 / (t * t) - 1.0 / (s * s));
    assert!((m.elastic_n(400.0, 0.0) - expected).abs() < 1e-9);
    assert_eq!(m.tension_n(400.0, neutral + 0.05, 0.0, 0.0), 0.0);
}
