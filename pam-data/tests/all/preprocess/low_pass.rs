use pam_data::preprocess::LowPass;

/// Values of SciPy 1.17, `filtfilt(*butter(1, 20, fs=1000), sin(0.3 k) + 0.1 k)` for k < 12.
#[test]
fn agrees_with_scipy() {
    let x: Vec<f64> = (0..12).map(|k| (0.3 * f64::from(k)).sin() + 0.1 * f64::from(k)).collect();
    let y = LowPass::new(20.0, 1000.0).unwrap().forward_backward(&x);
    for (k, (a, b)) in y.iter().zip(SCIPY).enumerate() {
        assert!((a - b).abs() < 1e-13, "sample {k}: {a} is not {b}");
    }
}

const SCIPY: [f64; 12] = [
    -0.15006601955191268,
    -0.01969459249335976,
    0.10418150938663882,
    0.21775940154365336,
    0.3178563518647588,
    0.4021627718784736,
    0.4694119499942367,
    0.5194507836059055,
    0.553204517473704,
    0.5725378602872478,
    0.5800239915598165,
    0.5786410686962238,
];

/// `⟨w, F x⟩ = ⟨Fᵀ w, x⟩`.
#[test]
fn the_transpose_is_that_of_the_filter() {
    let number = |k: u32, step: f64| (step * f64::from(k)).sin() + 0.3;
    for n in [LowPass::shortest() as u32, 40] {
        let x: Vec<f64> = (0..n).map(|k| number(k, 1.7)).collect();
        let w: Vec<f64> = (0..n).map(|k| number(k, 0.9)).collect();
        let filter = LowPass::new(20.0, 250.0).unwrap();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (left, right) =
            (dot(&w, &filter.forward_backward(&x)), dot(&filter.transposed(&w), &x));
        assert!((left - right).abs() < 1e-12 * left.abs(), "{left} is not {right}");
    }
}

#[test]
fn a_straight_line_far_from_the_ends_passes_unchanged() {
    let x: Vec<f64> = (0..4000).map(|k| 3.0 - 0.25 * f64::from(k)).collect();
    let y = LowPass::new(20.0, 1000.0).unwrap().forward_backward(&x);
    for k in 1000..3000 {
        assert!((x[k] - y[k]).abs() < 1e-9);
    }
}

/// At another sampling rate, the filter attenuates a slow sine like the filter of the data: to
/// `1/(1 + (tan(π f/rate)/tan(π cutoff/rate))²)` of its amplitude.
#[test]
fn a_filter_acts_alike_on_samples_of_another_rate() {
    use std::f64::consts::PI;
    let (cutoff_hz, own_rate_hz, hertz) = (20.0, 250.0, 3.0);
    for rate_hz in [70.0, 100.0, 500.0, 1000.0, 5000.0] {
        let warped = |f: f64| (PI * f / rate_hz).tan();
        let expected = 1.0 / (1.0 + (warped(hertz) / warped(cutoff_hz)).powi(2));
        let x: Vec<f64> =
            (0..2000).map(|k| (2.0 * PI * hertz * f64::from(k) / own_rate_hz).sin()).collect();
        let like = LowPass::like(cutoff_hz, rate_hz, own_rate_hz).unwrap();
        let y = like.forward_backward(&x);
        let middle = 500..1500;
        let ratio = middle.clone().map(|k| x[k] * y[k]).sum::<f64>()
            / middle.map(|k| x[k] * x[k]).sum::<f64>();
        assert!((ratio - expected).abs() < 3e-4, "{rate_hz} Hz: {ratio} is not {expected}");
    }
    assert_eq!(LowPass::like(20.0, 250.0, 250.0), LowPass::new(20.0, 250.0));
    assert!(LowPass::like(50.0, 100.0, 250.0).is_none());
}

#[test]
fn cutoffs_past_nyquist_are_refused() {
    assert!(LowPass::new(500.0, 1000.0).is_none());
    assert!(LowPass::new(0.0, 1000.0).is_none());
    assert!(LowPass::new(20.0, f64::NAN).is_none());
}
