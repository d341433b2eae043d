use pam_rig::protocol::CurrentSegment;

#[test]
fn pulses_have_their_width_and_alternate() {
    let pulses = CurrentSegment::Pulses {
        amplitude_a: 1.0,
        width_ms: 150.0,
        period_s: 2.0,
        alternate: true,
        duration_s: 8.0,
    };
    let at: Vec<f64> = (0..8000).map(|k| pulses.current_a(f64::from(k) * 1e-3, 1)).collect();
    let count = |value: f64| at.iter().filter(|a| **a == value).count();
    assert_eq!((count(1.0), count(-1.0)), (300, 300));
    assert_eq!(at[1000], 1.0);
    assert_eq!(at[3000], -1.0);
}

#[test]
fn a_triangle_starts_at_zero_and_reaches_its_amplitude() {
    let t = CurrentSegment::Triangle { amplitude_a: 2.0, frequency_hz: 1.0, duration_s: 1.0 };
    let at = [0.0, 0.125, 0.25, 0.5, 0.75].map(|time| t.current_a(time, 0));
    assert_eq!(at, [0.0, 1.0, 2.0, 0.0, -2.0]);
}

#[test]
fn random_pulses_repeat_for_a_seed() {
    let pulses = CurrentSegment::RandomPulses {
        amplitude_a: 0.5,
        width_ms: 150.0,
        pause_ms: [200.0, 900.0],
        duration_s: 30.0,
    };
    let run =
        |seed| (0..3000).map(|k| pulses.current_a(f64::from(k) * 1e-2, seed)).collect::<Vec<_>>();
    assert_eq!(run(4), run(4));
    assert_ne!(run(4), run(5));
    assert!(run(4).contains(&0.5) && run(4).contains(&-0.5));
}
