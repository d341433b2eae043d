use pam_baselines::kang::{BraidAngle, Fit, KangMuscle, MuscleSample, MuscleSize, fit};

/// Samples of a known muscle give it back.
#[test]
fn a_known_muscle_is_found() {
    let truth = KangMuscle {
        braid_angle_deg: 22.0,
        correction: 7.0,
        correction_rate_per_kpa: -0.003,
        viscous_ns: 90.0,
        dry_n: 12.0,
        ..KangMuscle::published_guess(MuscleSize::JOINT)
    };
    let mut samples = Vec::new();
    for p in 1..=8 {
        for c in -6..=6 {
            for rate in [-0.3, 0.0, 0.1] {
                let mut s = MuscleSample {
                    gauge_kpa: 69.0 * f64::from(p),
                    contraction: 5e-3 * f64::from(c),
                    rate_per_s: rate,
                    direction: if rate == 0.0 { 0.0 } else { rate.signum() },
                    force_n: 0.0,
                };
                s.force_n = truth.tension_n(s.gauge_kpa, s.contraction, rate, s.direction);
                samples.push(s);
            }
        }
    }
    let guess = KangMuscle::published_guess(MuscleSize::JOINT);
    let found = fit(&guess, BraidAngle::Fitted(Fit::Fit), &samples);
    assert_eq!(found.parameters, 5);
    assert!(found.r2 > 1.0 - 1e-9, "{found:?}");
    assert!((found.muscle.braid_angle_deg - 22.0).abs() < 1e-3, "{found:?}");
    assert!((found.muscle.dry_n - 12.0).abs() < 1e-2, "{found:?}");
    // A wrong angle that is held fits worse.
    assert!(fit(&guess, BraidAngle::Held(27.5), &samples).r2 < 0.99);
}
