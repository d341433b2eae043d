//! The force at nodes, in batches.

use pam_autodiff::batch::{BatchNetwork, NetworkBlock, NetworkSums};
use pam_core::simd::AlignedVec;
use pam_core::{Activation, NetworkForce};

/// Most points of one pass of the network.
const BLOCK: usize = 256;

/// A network laid out for batches of points (x, ẋ) at given masses.
#[derive(Debug)]
pub(crate) struct NodeNetwork {
    network: BatchNetwork<f64, Activation>,
}

/// Memory for the passes of one thread.
#[derive(Debug)]
pub(crate) struct NodeWorkspace {
    input: AlignedVec<f64>,
    out: AlignedVec<f64>,
    ones: Vec<f64>,
    slopes: Vec<f64>,
    block: NetworkBlock<f64>,
    sums: NetworkSums<f64>,
}

/// The network at the masses of one trajectory.
#[derive(Debug)]
pub(crate) struct SealedNodes<'a> {
    network: &'a BatchNetwork<f64, Activation>,
    masses_g: [f64; 2],
    bias: Vec<f64>,
}

impl NodeNetwork {
    pub(crate) fn new(force: &NetworkForce<f64>) -> Self {
        Self { network: BatchNetwork::new(force.mlp(), 2) }
    }

    pub(crate) fn parameter_len(&self) -> usize {
        self.network.parameter_len()
    }

    pub(crate) fn workspace(&self) -> NodeWorkspace {
        let n = &self.network;
        NodeWorkspace {
            input: AlignedVec::zeros(BLOCK * n.input_stride()),
            out: AlignedVec::zeros(BLOCK * n.output_stride()),
            ones: vec![1.0; BLOCK],
            slopes: vec![0.0; BLOCK * n.inputs()],
            block: n.block(BLOCK),
            sums: n.sums(BLOCK),
        }
    }

    pub(crate) fn sealed(&self, masses_g: [f64; 2]) -> SealedNodes<'_> {
        SealedNodes { network: &self.network, masses_g, bias: self.network.fold(&masses_g) }
    }
}

impl SealedNodes<'_> {
    fn write_input(&self, points: &[[f64; 2]], input: &mut [f64]) {
        for (to, point) in input.chunks_exact_mut(self.network.input_stride()).zip(points) {
            to[..2].copy_from_slice(point);
        }
    }

    /// The force (mN) at points (mm, mm/s).
    pub(crate) fn values_into(
        &self,
        points: &[[f64; 2]],
        values: &mut [f64],
        work: &mut NodeWorkspace,
    ) {
        for (points, values) in points.chunks(BLOCK).zip(values.chunks_mut(BLOCK)) {
            let NodeWorkspace { input, out, block, .. } = work;
            self.write_input(points, input);
            self.network.values_into(points.len(), &self.bias, input, out, &mut [], block);
            for (value, out) in values.iter_mut().zip(out.chunks_exact(self.network.output_stride())) {
                *value = out[0];
            }
        }
    }

    /// Adds to the derivatives by the network's parameters and by the masses, for cotangents of the force at points.
    pub(crate) fn pull_back(
        &self,
        points: &[[f64; 2]],
        cotangents: &[f64],
        parameters: &mut [f64],
        masses: &mut [f64; 2],
        work: &mut NodeWorkspace,
    ) {
        for (points, weights) in points.chunks(BLOCK).zip(cotangents.chunks(BLOCK)) {
            let count = points.len();
            let NodeWorkspace { input, out, ones, slopes, block, sums } = work;
            self.write_input(points, input);
            self.network.forward_into(count, &self.bias, input, out, &[], block);
            self.network.pull_back(count, ones, slopes, &[], block);
            self.network.accumulate(count, weights, input, ones, &[], sums, block);
        }
        self.network.drain_into(&mut work.sums, &self.masses_g, parameters, masses);
    }
}
