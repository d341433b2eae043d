//! The joint with sealed chambers as a batched field of two states.

use super::{BatchField, BatchNetwork, NetworkBlock, NetworkSums, ParameterSums, Points};
use pam_core::simd::{AlignedVec, Float};
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
    biases: AlignedVec<T>,
    input: AlignedVec<T>,
    out: AlignedVec<T>,
    block: NetworkBlock<T>,
}

/// Scratch memory of a block.
#[derive(Debug)]
pub struct MotionBlock<T> {
    input: AlignedVec<T>,
    out: AlignedVec<T>,
    /// Cotangents of the network's output: ones, since each point's weight comes later.
    ones: Vec<T>,
    slopes: AlignedVec<T>,
    weights: AlignedVec<T>,
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
            biases: AlignedVec::zeros(capacity * self.network.fold(&[0.0; 2]).len()),
            input: AlignedVec::zeros(capacity * self.network.input_stride()),
            out: AlignedVec::zeros(capacity * self.network.output_stride()),
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
            input: AlignedVec::zeros(capacity * self.network.input_stride()),
            out: AlignedVec::zeros(capacity * self.network.output_stride()),
            ones: vec![T::narrow(1.0); capacity],
            slopes: AlignedVec::zeros(capacity * 2),
            weights: AlignedVec::zeros(capacity),
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
