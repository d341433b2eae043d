//! A Runge–Kutta solution that ends a step at every kink.
//!
//! It evaluates the network layer by layer, without any linear regions, and finds kinks by the signs
//! of the pre-activations at the ends of short half steps. Between kinks the field is smooth, so the
//! fifth order of the method counts.

use super::Joint;
use pam_core::SealedMasses;
use pam_core::simd::arch;
use pulp::{Simd, WithSimd};

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
        let slope = model.force.mlp().activation().relu_slope().unwrap();
        Self { model, mass_kg: model.physical().mass_kg, masses, slope }
    }

    /// The force, and every pre-activation in `z`. The branch of each unit is the sign in `branch` if it
    /// is given, so that a step up to a kink uses one side of it throughout.
    fn force(&self, x: f64, v: f64, branch: Option<&[f64]>, z: &mut Vec<f64>) -> f64 {
        z.clear();
        let mut h = vec![self.masses.flexor_g, self.masses.extensor_g, x, v];
        let layers = self.model.force.mlp().layers();
        for (l, layer) in layers.iter().enumerate() {
            let mut out = layer.bias().to_vec();
            arch().dispatch(Layer { columns: layer.weight_columns(), inputs: &h, out: &mut out });
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
        self.solve_and_report(times, force, linear, longest_s, &mut |_| ())
    }

    /// As [`solve`](Self::solve); every accepted step is reported.
    fn solve_and_report(
        &self,
        times: &[f64],
        force: &[f64],
        linear: bool,
        longest_s: f64,
        tell: &mut dyn FnMut(Taken),
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
                    tell(Taken { y, h, u, flipped: None, sample: last.then_some(k + 1) });
                    y = end;
                    into = if last { length } else { into + h };
                    continue;
                }
                // The first length at which a margin is zero; margins at the start are not negative. Regula
                // falsi with halved values (Illinois), which closes in from both sides.
                let (mut low, mut high) = (0.0, if halfway < -tolerance { 0.5 * h } else { h });
                let (mut below, mut above) = (least(low).1.max(0.0), least(high).1);
                while high - low > 1e-17 && above < -100.0 * tolerance {
                    let chord = low + (high - low) * below / (below - above);
                    let middle =
                        if chord > low && chord < high { chord } else { 0.5 * (low + high) };
                    if middle <= low || middle >= high {
                        break;
                    }
                    let (_, margin, _) = least(middle);
                    if margin < -tolerance {
                        (high, above, below) = (middle, margin, 0.5 * below);
                    } else {
                        (low, below, above) = (middle, margin.max(0.0), 0.5 * above);
                    }
                }
                let (end, _, unit) = least(high);
                tell(Taken { y, h: high, u, flipped: Some(unit), sample: None });
                y = end;
                into += high;
                branch[unit] = -branch[unit];
            }
            out.push(y);
        }
        out
    }

    /// The discrete adjoint of these steps: the derivative of the sum of squares of all states by the
    /// network's parameters, m, B, both air masses and the initial state, one after the other.
    ///
    /// Lengths of steps are held, those up to kinks too. That they move adds nothing in the limit of
    /// small steps, since the field is continuous at a kink.
    pub(crate) fn gradient(
        &self,
        times: &[f64],
        force: &[f64],
        linear: bool,
        longest_s: f64,
    ) -> Vec<f64> {
        let mut steps = Vec::new();
        let states =
            self.solve_and_report(times, force, linear, longest_s, &mut |step| steps.push(step));
        let layers = self.model.force.mlp().layers();
        let parameters: usize = layers.iter().map(|l| (l.inputs() + 1) * l.outputs()).sum();
        let mut gradient = vec![0.0; parameters + 6];
        let mut z = Vec::new();
        self.force(0.0, 0.0, None, &mut z);
        let mut branch = z.clone();
        for flipped in steps.iter().filter_map(|s| s.flipped) {
            branch[flipped] = -branch[flipped];
        }
        let mut costate = [0.0; 2];
        for step in steps.iter().rev() {
            if let Some(sample) = step.sample {
                costate[0] += 2.0 * states[sample][0];
                costate[1] += 2.0 * states[sample][1];
            }
            if let Some(unit) = step.flipped {
                branch[unit] = -branch[unit];
            }
            costate = self.pull_back(step, &branch, costate, &mut gradient);
        }
        gradient[parameters + 4] = costate[0];
        gradient[parameters + 5] = costate[1];
        gradient
    }

    /// The costate before a step from that after it.
    fn pull_back(
        &self,
        step: &Taken,
        branch: &[f64],
        costate: [f64; 2],
        gradient: &mut [f64],
    ) -> [f64; 2] {
        let mut z = Vec::new();
        let Taken { y, h, u, .. } = *step;
        let damping = self.model.auxiliary_damping_kg_s;
        let mut at = [y; 6];
        let mut k = [[0.0; 2]; 6];
        for stage in 0..6 {
            for j in 0..stage {
                at[stage][0] += h * A[stage - 1][j] * k[j][0];
                at[stage][1] += h * A[stage - 1][j] * k[j][1];
            }
            let [x, v] = at[stage];
            let own = self.force(x, v, Some(branch), &mut z);
            k[stage] = [v, (u[0] + u[1] * C[stage] * h - own - damping * v) / self.mass_kg];
        }
        let others = gradient.len() - 6;
        let mut before = costate;
        let mut stages = [[0.0; 2]; 6];
        for stage in (0..6).rev() {
            let mut slope = [h * B[stage] * costate[0], h * B[stage] * costate[1]];
            for later in stage + 1..6 {
                slope[0] += h * A[later - 1][stage] * stages[later][0];
                slope[1] += h * A[later - 1][stage] * stages[later][1];
            }
            let [x, v] = at[stage];
            let scale = -slope[1] / self.mass_kg;
            let inputs = self.pull_back_force([x, v], branch, scale, gradient);
            gradient[others] -= slope[1] * k[stage][1] / self.mass_kg;
            gradient[others + 1] += scale * v;
            gradient[others + 2] += inputs[0];
            gradient[others + 3] += inputs[1];
            stages[stage] = [inputs[2], inputs[3] + slope[0] + scale * damping];
            before[0] += stages[stage][0];
            before[1] += stages[stage][1];
        }
        before
    }

    /// Adds `scale` times the derivative of the force by all weights, and returns that by its inputs.
    fn pull_back_force(
        &self,
        [x, v]: [f64; 2],
        branch: &[f64],
        scale: f64,
        gradient: &mut [f64],
    ) -> [f64; 4] {
        let layers = self.model.force.mlp().layers();
        let mut values = vec![vec![self.masses.flexor_g, self.masses.extensor_g, x, v]];
        let mut slopes = Vec::new();
        let mut first = 0;
        for layer in &layers[..layers.len() - 1] {
            let n = layer.outputs();
            let mut out = layer.bias().to_vec();
            let inputs = &values[values.len() - 1];
            arch().dispatch(Layer { columns: layer.weight_columns(), inputs, out: &mut out });
            let slope: Vec<f64> = branch[first..first + n]
                .iter()
                .map(|b| if *b > 0.0 { 1.0 } else { self.slope })
                .collect();
            out.iter_mut().zip(&slope).for_each(|(o, s)| *o *= s);
            first += n;
            values.push(out);
            slopes.push(slope);
        }
        let mut end = gradient.len() - 6;
        let mut carried = vec![scale];
        for (l, layer) in layers.iter().enumerate().rev() {
            let n = layer.outputs();
            let place = end - (layer.inputs() + 1) * n;
            let (columns, bias) = gradient[place..end].split_at_mut(layer.inputs() * n);
            end = place;
            bias.iter_mut().zip(&carried).for_each(|(g, c)| *g += c);
            let mut next = vec![0.0; layer.inputs()];
            arch().dispatch(LayerBack {
                columns: layer.weight_columns(),
                inputs: &values[l],
                carried: &carried,
                own: columns,
                next: &mut next,
            });
            if l > 0 {
                next.iter_mut().zip(&slopes[l - 1]).for_each(|(n, s)| *n *= s);
            }
            carried = next;
        }
        [carried[0], carried[1], carried[2], carried[3]]
    }
}

/// `out += W inputs`, by columns.
struct Layer<'a> {
    columns: &'a [f64],
    inputs: &'a [f64],
    out: &'a mut [f64],
}

impl WithSimd for Layer<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        for (h, column) in self.inputs.iter().zip(self.columns.chunks_exact(self.out.len())) {
            for (o, w) in self.out.iter_mut().zip(column) {
                *o += h * w;
            }
        }
    }
}

/// Adds the outer product of a layer's inputs and the derivatives by its outputs to the gradient, and
/// computes the derivatives by its inputs.
struct LayerBack<'a> {
    columns: &'a [f64],
    inputs: &'a [f64],
    carried: &'a [f64],
    own: &'a mut [f64],
    next: &'a mut [f64],
}

impl WithSimd for LayerBack<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let n = self.carried.len();
        let columns = self.own.chunks_exact_mut(n).zip(self.columns.chunks_exact(n));
        for ((value, next), (own, weights)) in self.inputs.iter().zip(self.next).zip(columns) {
            for (g, c) in own.iter_mut().zip(self.carried) {
                *g += value * c;
            }
            let mut sums = [0.0; 8];
            let (whole, rest) = weights.as_chunks::<8>();
            for (w, c) in whole.iter().zip(self.carried.as_chunks::<8>().0) {
                for i in 0..8 {
                    sums[i] += w[i] * c[i];
                }
            }
            let tail = &self.carried[n - rest.len()..];
            *next =
                sums.iter().sum::<f64>() + rest.iter().zip(tail).map(|(w, c)| w * c).sum::<f64>();
        }
    }
}

/// A step that was taken.
#[derive(Debug, Clone, Copy)]
struct Taken {
    /// State, force and its slope at the start.
    y: [f64; 2],
    u: [f64; 2],
    h: f64,
    /// The unit that changes its sign at the end.
    flipped: Option<usize>,
    /// The sample at the end.
    sample: Option<usize>,
}
