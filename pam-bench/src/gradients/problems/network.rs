//! Networks that behave like the force of a joint, made without data.

use pam_core::force::Dense;
use pam_core::{Activation, Mlp, NetworkForce};

/// Ridge of the fit, relative to the mean square of the features.
const RIDGE: f64 = 1e-8;
/// States at which the last layer is fitted.
const SAMPLES: usize = 700;
/// Force of one unit of the fit, mN.
const FORCE_MN: f64 = 1e5;

/// Evenly spread numbers in ±1, the same every time.
struct Spread(u64);

impl Spread {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
    }
}

/// The force that the network is fitted to, mN: a spring that grows stiffer with air and with
/// displacement, and a damper.
#[must_use]
pub fn target_mn([flexor_g, extensor_g, x, v]: [f64; 4]) -> f64 {
    let stiffness = 110e3 + 270e3 * (flexor_g + extensor_g);
    stiffness * x * (1.0 + 0.3 * x * x) + 6500.0 * v
}

/// A network 4–`width`–`width`–1 of the given activation: two random layers, the last one fitted by least
/// squares to a stiffening spring with a damper. The same every time.
///
/// # Panics
/// Never: the layers fit each other.
#[must_use]
pub fn force(activation: Activation, width: usize) -> NetworkForce<f64> {
    let mut spread = Spread(width as u64);
    // Inputs are unscaled: masses of about 0.08 g, some mm, some ten mm/s.
    let sizes = [0.05, 0.05, 0.7, 12.0];
    let first: Vec<f64> =
        (0..4 * width).map(|k| 1.2 * spread.next() / sizes[k % sizes.len()]).collect();
    // Kinks and bends are spread over where the joint moves, at an air mass of 0.08 g.
    let first_bias: Vec<f64> =
        first.chunks_exact(4).map(|w| -0.08 * (w[0] + w[1]) + 1.2 * spread.next()).collect();
    let gain = 1.7 / (width as f64).sqrt();
    let second: Vec<f64> = (0..width * width).map(|_| gain * spread.next()).collect();
    let second_bias: Vec<f64> = (0..width).map(|_| 0.7 * spread.next()).collect();
    let layer = |rows: &[f64], bias: Vec<f64>| Dense::from_rows(rows, bias).expect("layers fit");
    let hidden = vec![layer(&first, first_bias), layer(&second, second_bias)];

    let mut features_of = hidden.clone();
    let identity: Vec<f64> =
        (0..width * width).map(|k| f64::from(u8::from(k % (width + 1) == 0))).collect();
    features_of.push(layer(&identity, vec![0.0; width]));
    let features_of = Mlp::new(features_of, activation).expect("layers fit");
    let mut work = vec![0.0; features_of.work_len()];
    let mut rows = Vec::with_capacity(SAMPLES);
    for _ in 0..SAMPLES {
        let at = [
            0.08 + 0.05 * spread.next(),
            0.08 + 0.05 * spread.next(),
            1.4 * spread.next(),
            25.0 * spread.next(),
        ];
        let mut features = vec![0.0; width];
        features_of.forward_into(&at, &mut features, &mut work);
        features.push(1.0);
        rows.push((features, target_mn(at) / FORCE_MN));
    }
    let mut last = least_squares(&rows, width + 1);
    for weight in &mut last {
        *weight *= FORCE_MN;
    }
    let bias = vec![last.pop().unwrap_or_default()];
    let mut layers = hidden;
    layers.push(layer(&last, bias));
    let mlp = Mlp::new(layers, activation).expect("layers fit");
    NetworkForce::new(mlp).expect("four inputs and one output")
}

/// `argmin Σ (features · w − y)² + ridge ‖w‖²` by Cholesky's factors of the normal equations.
fn least_squares(rows: &[(Vec<f64>, f64)], n: usize) -> Vec<f64> {
    let mut a = vec![0.0; n * n];
    let mut w = vec![0.0; n];
    for (features, y) in rows {
        for i in 0..n {
            w[i] += features[i] * y;
            for j in 0..=i {
                a[i * n + j] += features[i] * features[j];
            }
        }
    }
    let trace: f64 = (0..n).map(|i| a[i * n + i]).sum();
    for i in 0..n {
        a[i * n + i] += RIDGE * trace / n as f64;
        for j in 0..=i {
            let dot: f64 = (0..j).map(|k| a[i * n + k] * a[j * n + k]).sum();
            let rest = a[i * n + j] - dot;
            a[i * n + j] = if i == j { rest.sqrt() } else { rest / a[j * n + j] };
        }
    }
    for i in 0..n {
        let dot: f64 = (0..i).map(|k| a[i * n + k] * w[k]).sum();
        w[i] = (w[i] - dot) / a[i * n + i];
    }
    for i in (0..n).rev() {
        let dot: f64 = (i + 1..n).map(|k| a[k * n + i] * w[k]).sum();
        w[i] = (w[i] - dot) / a[i * n + i];
    }
    w
}
