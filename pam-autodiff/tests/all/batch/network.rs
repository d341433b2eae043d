//! Every pass of the batched network against the generic one.

use num_dual::Dual64;
use pam_autodiff::batch::{BatchNetwork, NetworkBlock};
use pam_core::force::{Dense, Mlp};
use pam_core::simd::Float;
use pam_core::{Activation, ParametricForce, Scalar};
use proptest::prelude::*;

fn value(seed: u32, k: usize) -> f64 {
    (f64::from(seed) * 1.7 + k as f64 * 0.7391).sin()
}

/// A network of the given widths; the first is the number of inputs.
fn mlp(widths: &[usize], activation: &str, seed: u32) -> Mlp<f64> {
    let layers = widths
        .windows(2)
        .enumerate()
        .map(|(k, w)| {
            let seed = seed + 10 * k as u32;
            let scale = 1.5 / (w[0] as f64).sqrt();
            let weights: Vec<f64> = (0..w[0] * w[1]).map(|i| scale * value(seed, i)).collect();
            Dense::from_rows(&weights, (0..w[1]).map(|i| value(seed + 5, i)).collect()).unwrap()
        })
        .collect();
    Mlp::new(layers, Activation::from_name(activation).unwrap()).unwrap()
}

fn generic<S: Scalar>(mlp: &Mlp<S>, input: &[S]) -> Vec<S> {
    let mut out = vec![S::zero(); mlp.outputs()];
    mlp.forward_into(input, &mut out, &mut vec![S::zero(); mlp.work_len()]);
    out
}

/// One batch through all passes, with the numbers of the generic network.
struct Case {
    mlp: Mlp<f64>,
    constants: Vec<f64>,
    points: usize,
    /// `[points, inputs]`, tight.
    input: Vec<f64>,
    tangent: Vec<f64>,
    /// `[points, outputs]`, tight.
    cotangent: Vec<f64>,
    weights: Vec<f64>,
}

struct Passes {
    values: Vec<f64>,
    pushed: Vec<f64>,
    pulled: Vec<f64>,
    parameters: Vec<f64>,
    constants: Vec<f64>,
}

impl Case {
    fn new(widths: &[usize], constants: usize, activation: &str, points: usize, seed: u32) -> Self {
        let mlp = mlp(widths, activation, seed);
        let (inputs, outputs) = (mlp.inputs() - constants, mlp.outputs());
        let list = |n: usize, s: u32| (0..n).map(|k| value(seed + s, k)).collect();
        Self {
            constants: list(constants, 101),
            input: list(points * inputs, 102),
            tangent: list(points * inputs, 103),
            cotangent: list(points * outputs, 104),
            weights: list(points, 105),
            mlp,
            points,
        }
    }

    fn batched<T: Float>(&self) -> Passes {
        let network = BatchNetwork::<T>::new(&self.mlp, self.constants.len());
        let spread = |tight: &[f64]| -> Vec<T> {
            let mut out = vec![T::default(); self.points * network.input_stride()];
            for (o, t) in out
                .chunks_exact_mut(network.input_stride())
                .zip(tight.chunks_exact(network.inputs()))
            {
                for (o, &t) in o.iter_mut().zip(t) {
                    *o = T::narrow(t);
                }
            }
            out
        };
        let narrow = |v: &[f64]| -> Vec<T> { v.iter().map(|&x| T::narrow(x)).collect() };
        let tight = |padded: &[T]| -> Vec<f64> {
            padded
                .chunks_exact(network.output_stride())
                .flat_map(|p| p[..network.outputs()].iter().map(|x| x.widen()))
                .collect()
        };
        let (n, bias) = (self.points, network.fold(&self.constants));
        let (input, cotangent) = (spread(&self.input), narrow(&self.cotangent));
        let weights = narrow(&self.weights);
        let mut block = network.block(n);
        let mut out = vec![T::default(); n * network.output_stride()];
        let mut again = out.clone();
        let mut kept = vec![T::default(); n * network.kept_len()];
        network.values_into(n, &bias, &input, &mut again, &mut kept, &mut block);
        network.forward_into(n, &bias, &input, &mut out, &[], &mut block);
        assert_eq!(out, again, "with and without slopes");
        let pull = |kept: &[T], block: &mut NetworkBlock<T>, out: &mut [T]| {
            network.forward_into(n, &bias, &input, out, kept, block);
            let mut pulled = vec![T::default(); n * network.inputs()];
            network.pull_back(n, &cotangent, &mut pulled, kept, block);
            let mut sums = network.sums(n);
            network.accumulate(n, &weights, &input, &cotangent, kept, &mut sums, block);
            let mut parameters = vec![0.0; network.parameter_len()];
            let mut constants = vec![0.0; self.constants.len()];
            network.drain_into(&mut sums, &self.constants, &mut parameters, &mut constants);
            let pulled: Vec<f64> = pulled.iter().map(|x| x.widen()).collect();
            (pulled, parameters, constants)
        };
        let (pulled, parameters, constants) = pull(&[], &mut block, &mut out);
        let from_kept = pull(&kept, &mut network.block(n), &mut out);
        assert_eq!(out, again, "from what was kept");
        assert_eq!((&pulled, &parameters, &constants), (&from_kept.0, &from_kept.1, &from_kept.2));
        network.forward_into(n, &bias, &input, &mut out, &[], &mut block);
        let values = tight(&out);
        network.push_forward(n, &spread(&self.tangent), &mut out, &mut block);
        let pushed = tight(&out);
        Passes { values, pushed, pulled, parameters, constants }
    }

    fn full_input(&self, point: usize) -> Vec<f64> {
        let n = self.mlp.inputs() - self.constants.len();
        let own = &self.input[point * n..(point + 1) * n];
        self.constants.iter().chain(own).copied().collect()
    }

    /// `Σ_p weight_p cotangent_p · out_p` with duals in the place that `seed` chooses.
    fn weighted_sum(&self, seed: impl Fn(&mut Mlp<Dual64>, &mut [Dual64])) -> f64 {
        let outputs = self.mlp.outputs();
        (0..self.points)
            .map(|p| {
                let mut lifted = self.mlp.map(Dual64::constant);
                let mut input: Vec<Dual64> =
                    self.full_input(p).into_iter().map(Dual64::constant).collect();
                seed(&mut lifted, &mut input);
                let out = generic(&lifted, &input);
                let cotangent = &self.cotangent[p * outputs..(p + 1) * outputs];
                self.weights[p] * out.iter().zip(cotangent).map(|(o, c)| o.eps * c).sum::<f64>()
            })
            .sum()
    }
}

fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * (1.0 + a.abs().max(b.abs()))
}

const SHAPES: &[(&[usize], usize)] = &[
    (&[4, 96, 96, 1], 2),
    (&[3, 20, 1], 0),
    (&[5, 7, 33, 12, 6], 1),
    (&[2, 3], 1),
    (&[4, 40, 9], 3),
];

#[test]
fn every_pass_equals_the_generic_network_for_every_activation() {
    for name in Activation::NAMES {
        for (shape, (widths, constants)) in SHAPES.iter().enumerate() {
            let case = Case::new(widths, *constants, name, 5, 3 + shape as u32);
            let (passes, rough) = (case.batched::<f64>(), case.batched::<f32>());
            let (outputs, inputs) = (case.mlp.outputs(), widths[0] - constants);
            let lifted = case.mlp.map(Dual64::constant);
            for p in 0..case.points {
                // Values and tangents along the given direction.
                let mut input: Vec<Dual64> =
                    case.full_input(p).into_iter().map(Dual64::constant).collect();
                for (i, d) in input[*constants..].iter_mut().enumerate() {
                    d.eps = case.tangent[p * inputs + i];
                }
                for (j, o) in generic(&lifted, &input).iter().enumerate() {
                    let at = p * outputs + j;
                    assert!(close(passes.values[at], o.re, 1e-12), "{name} {widths:?}");
                    assert!(close(passes.pushed[at], o.eps, 1e-12), "{name} {widths:?}");
                    assert!(close(rough.values[at], o.re, 1e-4), "{name} {widths:?} f32");
                }
                // Cotangents of the inputs.
                for i in 0..inputs {
                    let mut input: Vec<Dual64> =
                        case.full_input(p).into_iter().map(Dual64::constant).collect();
                    input[constants + i].eps = 1.0;
                    let exact: f64 = generic(&lifted, &input)
                        .iter()
                        .enumerate()
                        .map(|(j, o)| o.eps * case.cotangent[p * outputs + j])
                        .sum();
                    assert!(close(passes.pulled[p * inputs + i], exact, 1e-12), "{name}");
                    assert!(close(rough.pulled[p * inputs + i], exact, 1e-3), "{name} f32");
                }
            }
            for (i, &c) in passes.constants.iter().enumerate() {
                let exact = case.weighted_sum(|_, input| input[i].eps = 1.0);
                assert!(close(c, exact, 1e-12), "{name} constant {i}");
            }
        }
    }
}

#[test]
fn weight_cotangents_equal_dual_numbers() {
    for name in ["leaky_relu", "tanh", "gelu"] {
        for (widths, constants) in [(&[4, 9, 7, 1][..], 2), (&[3, 5, 2], 0), (&[2, 3], 1)] {
            let case = Case::new(widths, constants, name, 4, 11);
            let passes = case.batched::<f64>();
            for (i, &gradient) in passes.parameters.iter().enumerate() {
                let exact = case.weighted_sum(|mlp, _| {
                    let mut k = 0;
                    *mlp = mlp.map(|mut w| {
                        w.eps = f64::from(u8::from(k == i));
                        k += 1;
                        w
                    });
                });
                assert!(close(gradient, exact, 1e-12), "{name} {widths:?} {i}: {gradient} {exact}");
            }
        }
    }
    // The order is that of the force's parameters.
    let force = pam_core::NetworkForce::new(mlp(&[4, 6, 1], "tanh", 2)).unwrap();
    let network = BatchNetwork::<f64>::new(force.mlp(), 2);
    assert_eq!(network.parameter_len(), ParametricForce::parameter_len(&force));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// ⟨c, J v⟩ = ⟨Jᵀ c, v⟩ for random shapes, batches and activations.
    #[test]
    fn pull_back_is_the_transpose_of_push_forward(
        hidden in prop::collection::vec(1_usize..50, 0..4),
        inputs in 1_usize..6,
        outputs in 1_usize..7,
        points in 1_usize..20,
        activation in prop::sample::select(Activation::NAMES),
        seed in 0_u32..500,
    ) {
        let widths: Vec<usize> = [inputs].into_iter().chain(hidden).chain([outputs]).collect();
        let case = Case::new(&widths, 0, activation, points, seed);
        let passes = case.batched::<f64>();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let left = dot(&case.cotangent, &passes.pushed);
        let right = dot(&passes.pulled, &case.tangent);
        prop_assert!(close(left, right, 1e-11), "{} {}", left, right);
    }
}
