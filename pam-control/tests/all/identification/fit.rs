use pam_control::identification::{Response, identify, simulate};

fn noisy(stiffness: f64, damping: f64, seed: u64, amplitude: f64) -> Response {
    let force_n: Vec<f64> = (0..300).map(|k| if k < 150 { -90.0 } else { 0.0 }).collect();
    let mut response = Response {
        mass_kg: 304.6,
        sample_s: 1e-3,
        start_mm: 0.4,
        start_mm_s: 0.6,
        start_mm_s2: 0.0,
        force_n,
        displacement_mm: Vec::new(),
    };
    let clean = simulate(&response, stiffness, damping);
    let mut state = seed;
    response.displacement_mm = clean
        .iter()
        .map(|x| {
            // Twelve uniform numbers make a normal one.
            let normal: f64 = (0..12)
                .map(|_| {
                    state =
                        state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                    (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
                })
                .sum();
            x + amplitude * normal
        })
        .collect();
    response
}

/// The closed form of an under-damped oscillator under a step.
#[test]
fn the_simulation_is_the_step_response() {
    let response = Response {
        mass_kg: 300.0,
        sample_s: 1e-3,
        force_n: vec![50.0; 400],
        ..Response::default()
    };
    let (k, b, m) = (150e3, 5000.0, 300.0);
    let decay = b / (2.0 * m);
    let omega = f64::sqrt(k / m - decay * decay);
    for (i, x) in simulate(&response, 150.0, b).into_iter().enumerate() {
        let t = 1e-3 * i as f64;
        let swing = (omega * t).cos() + decay / omega * (omega * t).sin();
        let exact = 50.0 / 150.0 * (1.0 - (-decay * t).exp() * swing);
        assert!((x - exact).abs() < 1e-8, "{i}: {x} {exact}");
    }
}

#[test]
fn the_start_of_the_search_does_not_matter() {
    for (k, b) in [(60.0, 1500.0), (126.0, 6000.0), (176.0, 9000.0), (300.0, 20e3)] {
        let found = identify(&noisy(k, b, 1, 0.0)).unwrap();
        assert!((found.stiffness_n_mm - k).abs() < 1e-5 * k);
        assert!((found.damping_kg_s - b).abs() < 1e-5 * b);
    }
}

/// With white noise the intervals hold the truth about as often as they say.
#[test]
fn the_intervals_cover() {
    let trials = 200;
    let held = (0..trials)
        .filter(|&seed| {
            let found = identify(&noisy(150.0, 6500.0, seed * 7919 + 3, 0.01)).unwrap();
            let [low, high] = found.stiffness_interval_n_mm;
            (low..=high).contains(&150.0)
        })
        .count();
    assert!((165..=199).contains(&held), "{held} of {trials}");
}

#[test]
fn nothing_is_identified_from_nothing() {
    assert!(identify(&Response::default()).is_err());
    let mut still = noisy(150.0, 6500.0, 1, 0.0);
    still.force_n.fill(0.0);
    assert!(identify(&still).unwrap_err().to_string().contains("no force"));
}
