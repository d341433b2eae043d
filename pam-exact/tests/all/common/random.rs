//! Joints with random kinks.

use super::{Joint, published};
use pam_core::force::{Dense, Mlp};
use pam_core::{Activation, ActivationFunction, NetworkForce};

/// Evenly spread numbers in ±1, the same every time.
pub(crate) fn spread() -> impl FnMut() -> f64 {
    let mut state = 1_u64;
    move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
    }
}

/// A joint whose network has hidden layers of these widths (of two units or more each), and is a spring of
/// about 150 N/mm with a damper and random kinks.
pub(crate) fn random_joint(widths: &[usize], activation: Activation) -> Joint {
    assert!(activation.relu_slope().is_some());
    let mut next = spread();
    let sizes = [0.05, 0.05, 0.7, 12.0];
    // Two units carry x and ẋ through all layers.
    let carry = |rows: &mut [f64], bias: &mut [f64], inputs: usize, from: [usize; 2]| {
        for (unit, column) in from.into_iter().enumerate() {
            rows[unit * inputs..(unit + 1) * inputs].fill(0.0);
            rows[unit * inputs + column] = 1.0;
            bias[unit] = if inputs == 4 { 1e3 } else { 0.0 };
        }
    };
    let mut rows: Vec<f64> = (0..4 * widths[0]).map(|k| next() / sizes[k % 4]).collect();
    let mut biases: Vec<f64> =
        rows.chunks_exact(4).map(|w| -0.08 * (w[0] + w[1]) + next()).collect();
    carry(&mut rows, &mut biases, 4, [2, 3]);
    let mut layers = vec![Dense::from_rows(&rows, biases).expect("layers fit")];
    for pair in widths.windows(2) {
        let [inputs, width] = [pair[0], pair[1]];
        let gain = 1.7 / (inputs as f64).sqrt();
        let mut rows: Vec<f64> = (0..inputs * width).map(|_| gain * next()).collect();
        for row in rows.chunks_exact_mut(inputs) {
            row[..2].fill(0.0);
        }
        let mut biases: Vec<f64> = (0..width).map(|_| 0.7 * next()).collect();
        carry(&mut rows, &mut biases, inputs, [0, 1]);
        layers.push(Dense::from_rows(&rows, biases).expect("layers fit"));
    }
    let width = widths[widths.len() - 1];
    let mut last: Vec<f64> = (0..width).map(|_| 2e4 / (width as f64).sqrt() * next()).collect();
    last[0] = 150e3;
    last[1] = 6500.0;
    let offset = -1e3 * (last[0] + last[1]);
    layers.push(Dense::from_rows(&last, vec![offset]).expect("layers fit"));
    let force =
        NetworkForce::new(Mlp::new(layers, activation).expect("layers fit")).expect("4 to 1");
    published().map(|v| v, |_| force.clone())
}
