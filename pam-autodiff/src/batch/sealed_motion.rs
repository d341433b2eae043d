//! The joint with sealed chambers as a batched field of two states.

use super::{BatchField, BatchNetwork, NetworkBlock, NetworkSums, ParameterSums, Points};
use pam_core::simd::Float;
use pam_core::{Activation, ActivationFunction, JointModel, NetworkForce, SealedMasses};

/// The joint with sealed chambers, reduced to its motion and batched:
///
/// ```text
/// ẋ = v
/// v̇ = (F_e − f_θ(x, v, m_f, m_e) − B v) / m
/// ```
///
/// With valves closed the pressures never act back on the motion; they follow from it by the gas law
/// (see [`JointModel::gas_law_pressures_kpa`]), so two states are enough. The masses are constant along
/// a trajectory and are folded into the network's first bias. States, time and sums are doubles; the
/// network runs in `T`.
///
/// Shared parameters: those of the network, then m (the mass itself, kg) and B (kg/s). A condition's
/// own: m_f, m_e (g).
#[derive(Debug, Clone)]
pub struct SealedMotion<T, A = Activation> {
    network: BatchNetwork<T, A>,
    mass_kg: f64,
    auxiliary_damping_kg_s: f64,
}

/// The air of one trajectory, with the network's first bias for it.
#[derive(Debug, Clone)]
pub struct SealedCondition<T> {
    masses: [f64; 2],
    bias: Vec<T>,
}

/// The air of each member, and scratch memory.
#[derive(Debug)]
pub struct MotionBatch<T> {
    /// The first bias of each member.
    biases: Vec<T>,
    input: Vec<T>,
    out: Vec<T>,
    block: NetworkBlock<T>,
}

/// Scratch memory of a block.
#[derive(Debug)]
pub struct MotionBlock<T> {
    input: Vec<T>,
    out: Vec<T>,
    /// Cotangents of the network's output: ones, since each point's weight comes later.
    ones: Vec<T>,
    slopes: Vec<T>,
    weights: Vec<T>,
    network: NetworkBlock<T>,
    sums: NetworkSums<T>,
    /// Points in the sums.
    pending: usize,
}

/// The network's sums are moved to doubles after about this many points: often enough for single
/// precision, seldom enough to cost nothing.
const PENDING_POINTS: usize = 2048;

/// Index of the mass m among the shared parameters, counted from the end of the network's.
pub const MASS: usize = 0;
/// Index of the auxiliary damping B among the shared parameters, counted from the end of the
/// network's.
pub const DAMPING: usize = 1;

impl<T: Float, A: ActivationFunction> SealedMotion<T, A> {
    /// The motion of a joint whose force is a network.
    #[must_use]
    pub fn new<F>(model: &JointModel<f64, F>, force: &NetworkForce<f64, A>) -> Self {
        Self {
            network: BatchNetwork::new(force.mlp(), 2),
            mass_kg: model.physical().mass_kg,
            auxiliary_damping_kg_s: model.auxiliary_damping_kg_s,
        }
    }

    /// The condition of a trajectory with these masses.
    #[must_use]
    pub fn condition(&self, masses: SealedMasses) -> SealedCondition<T> {
        let masses = [masses.flexor_g, masses.extensor_g];
        SealedCondition { masses, bias: self.network.fold(&masses) }
    }

    fn write_input(&self, y: &[f64], input: &mut [T]) {
        for (o, y) in input.chunks_exact_mut(self.network.input_stride()).zip(y.chunks_exact(2)) {
            o[0] = T::narrow(y[0]);
            o[1] = T::narrow(y[1]);
        }
    }
}

fn zeros<T: Float>(len: usize) -> Vec<T> {
    vec![T::default(); len]
}

impl<T: Float, A: ActivationFunction> BatchField for SealedMotion<T, A> {
    type Condition = SealedCondition<T>;
    type Batch = MotionBatch<T>;
    type Block = MotionBlock<T>;
    type Kept = T;

    fn state_len(&self) -> usize {
        2
    }
    fn input_len(&self) -> usize {
        1
    }
    fn parameter_len(&self) -> usize {
        self.network.parameter_len() + 2
    }
    fn condition_len(&self) -> usize {
        2
    }

    fn kept_len(&self) -> usize {
        self.network.kept_len()
    }

    fn batch(&self, capacity: usize) -> MotionBatch<T> {
        MotionBatch {
            biases: zeros(capacity * self.network.fold(&[0.0; 2]).len()),
            input: zeros(capacity * self.network.input_stride()),
            out: zeros(capacity * self.network.output_stride()),
            block: self.network.block(capacity),
        }
    }

    fn set_condition(
        &self,
        member: usize,
        condition: &SealedCondition<T>,
        batch: &mut MotionBatch<T>,
    ) {
        let n = condition.bias.len();
        batch.biases[member * n..(member + 1) * n].copy_from_slice(&condition.bias);
    }

    fn move_condition(&self, from: usize, to: usize, batch: &mut MotionBatch<T>) {
        let n = batch.biases.len() / batch.block.capacity();
        batch.biases.copy_within(from * n..(from + 1) * n, to * n);
    }

    fn eval_batch(
        &self,
        points: Points<'_>,
        dy: &mut [f64],
        kept: &mut [T],
        batch: &mut MotionBatch<T>,
    ) {
        let Points { t, y, u } = points;
        let points = t.len();
        self.write_input(&y[..2 * points], &mut batch.input);
        let MotionBatch { biases, input, out, block } = batch;
        self.network.values_into(points, biases, input, out, kept, block);
        let forces = out.chunks_exact(self.network.output_stride());
        let states = y.chunks_exact(2).zip(dy.chunks_exact_mut(2));
        for (((y, dy), force), u) in states.zip(forces).zip(u).take(points) {
            dy[0] = y[1];
            dy[1] = (u - force[0].widen() - self.auxiliary_damping_kg_s * y[1]) / self.mass_kg;
        }
    }

    fn block(&self, capacity: usize) -> MotionBlock<T> {
        MotionBlock {
            input: zeros(capacity * self.network.input_stride()),
            out: zeros(capacity * self.network.output_stride()),
            ones: vec![T::narrow(1.0); capacity],
            slopes: zeros(capacity * 2),
            weights: zeros(capacity),
            network: self.network.block(capacity),
            sums: self.network.sums(capacity),
            pending: 0,
        }
    }

    fn linearise(
        &self,
        condition: &SealedCondition<T>,
        points: Points<'_>,
        kept: &[T],
        jacobians: &mut [f64],
        block: &mut MotionBlock<T>,
    ) {
        let (y, points) = (points.y, points.t.len());
        self.write_input(&y[..2 * points], &mut block.input);
        let MotionBlock { input, out, ones, slopes, network, .. } = block;
        self.network.forward_into(points, &condition.bias, input, out, kept, network);
        self.network.pull_back(points, ones, slopes, kept, network);
        let (b, m) = (self.auxiliary_damping_kg_s, self.mass_kg);
        for (j, slope) in jacobians.chunks_exact_mut(4).zip(slopes.chunks_exact(2)).take(points) {
            j[0] = 0.0;
            j[1] = 1.0;
            j[2] = -slope[0].widen() / m;
            j[3] = -(slope[1].widen() + b) / m;
        }
    }

    fn accumulate(
        &self,
        condition: &SealedCondition<T>,
        points: Points<'_>,
        kept: &[T],
        w: &[f64],
        sums: &mut ParameterSums<'_>,
        block: &mut MotionBlock<T>,
    ) {
        let Points { t, y, u } = points;
        let (points, m) = (t.len(), self.mass_kg);
        let physical = &mut sums.shared[self.network.parameter_len()..];
        let forces = block.out.chunks_exact(self.network.output_stride());
        let states = y.chunks_exact(2).zip(u).zip(w.chunks_exact(2));
        for ((weight, force), ((y, u), w)) in
            block.weights.iter_mut().zip(forces).zip(states).take(points)
        {
            *weight = T::narrow(-w[1] / m);
            let resultant = u - force[0].widen() - self.auxiliary_damping_kg_s * y[1];
            physical[MASS] -= w[1] * resultant / (m * m);
            physical[DAMPING] -= w[1] * y[1] / m;
        }
        let MotionBlock { input, ones, weights, network, sums: block_sums, pending, .. } = block;
        self.network.accumulate(points, weights, input, ones, kept, block_sums, network);
        *pending += points;
        if *pending >= PENDING_POINTS {
            self.drain(condition, sums, block);
        }
    }

    fn drain(
        &self,
        condition: &SealedCondition<T>,
        sums: &mut ParameterSums<'_>,
        block: &mut MotionBlock<T>,
    ) {
        let network = &mut sums.shared[..self.network.parameter_len()];
        self.network.drain_into(&mut block.sums, &condition.masses, network, sums.own);
        block.pending = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_dual::Dual64;
    use pam_core::force::{Dense, Mlp};
    use pam_core::{ParametricField, Scalar, VectorField};

    fn model() -> JointModel<f64, NetworkForce<f64>> {
        let layer = |inputs: usize, outputs: usize, seed: f64, scale: f64| {
            let value = |k: usize| scale * (seed + k as f64 * 1.313).sin();
            let weights: Vec<f64> = (0..inputs * outputs).map(value).collect();
            Dense::from_rows(&weights, (0..outputs).map(|k| value(k + 99)).collect()).unwrap()
        };
        let layers = vec![layer(4, 20, 0.3, 1.0), layer(20, 12, 1.1, 0.4), layer(12, 1, 2.2, 3e3)];
        let activation = Activation::from_name("leaky_relu").unwrap();
        let force = NetworkForce::new(Mlp::new(layers, activation).unwrap()).unwrap();
        let mut model = JointModel::datasheet(force);
        model.auxiliary_damping_kg_s = 700.0;
        model
    }

    /// Jacobians and parameter cotangents equal those of the generic field by dual numbers.
    #[test]
    fn equals_the_generic_field() {
        let model = model();
        let masses = SealedMasses::new(0.05, 0.09).unwrap();
        let field = model.sealed(masses);
        let motion = SealedMotion::<f64>::new(&model, &model.force);
        let condition = motion.condition(masses);
        let points = 7;
        let number = |seed: f64, k: usize| (seed + 0.77 * k as f64).sin();
        let t = vec![0.0; points];
        let y: Vec<f64> = (0..2 * points).map(|k| 2.0 * number(0.1, k)).collect();
        let u: Vec<f64> = (0..points).map(|k| 1e5 * number(0.5, k)).collect();
        let w: Vec<f64> = (0..2 * points).map(|k| number(0.9, k)).collect();

        let mut batch = motion.batch(points);
        (0..points).for_each(|k| motion.set_condition(k, &condition, &mut batch));
        let mut dy = vec![0.0; 2 * points];
        let mut kept = vec![0.0; points * motion.kept_len()];
        let at = Points { t: &t, y: &y, u: &u };
        motion.eval_batch(at, &mut dy, &mut kept, &mut batch);
        let mut jacobians = vec![0.0; 4 * points];
        let mut block = motion.block(points);
        motion.linearise(&condition, at, &kept, &mut jacobians, &mut block);
        let mut shared = vec![0.0; motion.parameter_len()];
        let mut own = vec![0.0; 2];
        let mut sums = ParameterSums { shared: &mut shared, own: &mut own };
        motion.accumulate(&condition, at, &kept, &w, &mut sums, &mut block);
        motion.drain(&condition, &mut sums, &mut block);

        let parameters = field.parameters();
        let lift = |p: &[f64]| p.iter().map(|&v| Dual64::constant(v)).collect::<Vec<_>>();
        let evaluate = |parameters: &[Dual64], state: [Dual64; 2], force: f64| {
            let field = field.with_parameters(parameters);
            let mut out = [Dual64::constant(0.0); 4];
            let mut work = vec![Dual64::constant(0.0); VectorField::<Dual64>::work_len(&field)];
            let y = [state[0], state[1], Dual64::constant(400.0), Dual64::constant(400.0)];
            field.eval_into(0.0, &y, &[Dual64::constant(force)], &mut out, &mut work);
            [out[0], out[1]]
        };
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-11 * (1e-3 + a.abs().max(b.abs()));
        for p in 0..points {
            for column in 0..2 {
                let mut state = [Dual64::constant(y[2 * p]), Dual64::constant(y[2 * p + 1])];
                state[column].eps = 1.0;
                let exact = evaluate(&lift(&parameters), state, u[p]);
                for row in 0..2 {
                    assert!(close(jacobians[4 * p + 2 * row + column], exact[row].eps));
                    assert!(close(dy[2 * p + row], exact[row].re));
                }
            }
        }
        let network_len = shared.len() - 2;
        let softplus_slope = model.raw.mass.sigmoid();
        for (i, _) in parameters.iter().enumerate() {
            let mut lifted = lift(&parameters);
            lifted[i].eps = 1.0;
            let exact: f64 = (0..points)
                .map(|p| {
                    let state = [Dual64::constant(y[2 * p]), Dual64::constant(y[2 * p + 1])];
                    let d = evaluate(&lifted, state, u[p]);
                    d[0].eps * w[2 * p] + d[1].eps * w[2 * p + 1]
                })
                .sum();
            let ours = match i - i.min(network_len) {
                _ if i < network_len => shared[i],
                0 => shared[network_len + MASS] * softplus_slope,
                1 | 2 => 0.0, // C and ν do not act on the motion
                3 => shared[network_len + DAMPING],
                k => own[k - 4],
            };
            assert!(close(ours, exact), "parameter {i}: {ours} {exact}");
        }
    }
}
