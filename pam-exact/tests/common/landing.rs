//! A Runge–Kutta solution that ends a step at every kink.
//!
//! It evaluates the network layer by layer, knows nothing of affine pieces, and finds kinks by the signs
//! of the pre-activations at the ends of short half steps. Between kinks the field is smooth, so the
//! fifth order of the method counts.

use super::Joint;
use pam_core::SealedMasses;

/// Dormand and Prince 1980, fifth-order weights.
const A: [[f64; 5]; 5] = [
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
];
const B: [f64; 6] =
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0];
const C: [f64; 6] = [0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0];

pub(crate) struct Landing<'a> {
    model: &'a Joint,
    mass_kg: f64,
    masses: SealedMasses,
    slope: f64,
}

impl<'a> Landing<'a> {
    pub(crate) fn new(model: &'a Joint, masses: SealedMasses) -> Self {
        use pam_core::ActivationFunction;
        let slope = model.force.mlp().activation().rectifier_slope().unwrap();
        Self { model, mass_kg: model.physical().mass_kg, masses, slope }
    }

    /// The force, and every pre-activation in `z`. The branch of each unit is the sign in `branch` if it
    /// is given, so that a step up to a kink uses one side of it throughout.
    fn force(&self, x: f64, v: f64, branch: Option<&[f64]>, z: &mut Vec<f64>) -> f64 {
        z.clear();
        let mut h = vec![self.masses.flexor_g, self.masses.extensor_g, x, v];
        let layers = self.model.force.mlp().layers();
        for (l, layer) in layers.iter().enumerate() {
            let n = layer.outputs();
            let mut out = layer.bias().to_vec();
            for (h, column) in h.iter().zip(layer.weight_columns().chunks_exact(n)) {
                for (o, w) in out.iter_mut().zip(column) {
                    *o += h * w;
                }
            }
            if l + 1 == layers.len() {
                return out[0];
            }
            let start = z.len();
            z.extend_from_slice(&out);
            for (i, o) in out.iter_mut().enumerate() {
                let sign = branch.map_or(*o, |b| b[start + i]);
                *o *= if sign > 0.0 { 1.0 } else { self.slope };
            }
            h = out;
        }
        unreachable!("the last layer returns")
    }

    fn step(&self, y: [f64; 2], h: f64, u: [f64; 2], branch: &[f64], z: &mut Vec<f64>) -> [f64; 2] {
        let mut k = [[0.0; 2]; 6];
        for stage in 0..6 {
            let mut at = y;
            for (j, k) in k.iter().enumerate().take(stage) {
                at[0] += h * A[stage - 1][j] * k[0];
                at[1] += h * A[stage - 1][j] * k[1];
            }
            let force = u[0] + u[1] * C[stage] * h;
            let b = self.model.auxiliary_damping_kg_s * at[1];
            let a = (force - self.force(at[0], at[1], Some(branch), z) - b) / self.mass_kg;
            k[stage] = [at[1], a];
        }
        std::array::from_fn(|i| y[i] + h * (0..6).map(|s| B[s] * k[s][i]).sum::<f64>())
    }

    /// Displacement and velocity at every sample, steps of at most `longest_s`, the force held or
    /// linear between samples.
    pub(crate) fn solve(
        &self,
        times: &[f64],
        force: &[f64],
        linear: bool,
        longest_s: f64,
    ) -> Vec<[f64; 2]> {
        let mut y = [0.0, 0.0];
        let mut out = vec![y];
        let (mut z, mut after) = (Vec::new(), Vec::new());
        self.force(y[0], y[1], None, &mut z);
        let mut branch = z.clone();
        for k in 0..times.len() - 1 {
            let length = times[k + 1] - times[k];
            let rate = if linear { (force[k + 1] - force[k]) / length } else { 0.0 };
            let mut into = 0.0;
            while into < length {
                let h = (length - into).min(longest_s);
                let last = h == length - into;
                let u = [force[k] + rate * into, rate];
                // The least margin of the branch at the end of a step of length s; its argument.
                let mut least = |s: f64| {
                    let end = self.step(y, s, u, &branch, &mut z);
                    self.force(end[0], end[1], Some(&branch), &mut after);
                    let margin = branch.iter().zip(&after).map(|(b, a)| b.signum() * a);
                    let (unit, margin) = margin
                        .enumerate()
                        .min_by(|a, b| a.1.total_cmp(&b.1))
                        .expect("there are units");
                    (end, margin, unit)
                };
                let tolerance = 1e-13;
                let (end, margin, _) = least(h);
                let (_, halfway, _) = least(0.5 * h);
                if margin >= -tolerance && halfway >= -tolerance {
                    y = end;
                    into = if last { length } else { into + h };
                    continue;
                }
                // The first length at which a margin is zero; margins at the start are not negative.
                let (mut low, mut high) = (0.0, if halfway < -tolerance { 0.5 * h } else { h });
                while high - low > 1e-17 {
                    let middle = 0.5 * (low + high);
                    if middle <= low || middle >= high {
                        break;
                    }
                    let (_, margin, _) = least(middle);
                    if margin < -tolerance { high = middle } else { low = middle }
                }
                let (end, _, unit) = least(high);
                y = end;
                into += high;
                branch[unit] = -branch[unit];
            }
            out.push(y);
        }
        out
    }
}
