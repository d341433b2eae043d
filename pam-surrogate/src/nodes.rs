//! The force at nodes, in batches.

use pam_autodiff::batch::{BatchNetwork, NetworkBlock, NetworkSums};
use pam_core::simd::AlignedVec;
use pam_core::{Activation, ForceInput, ForceModel, NetworkForce, SealedMasses};

/// A force with the air of one trajectory, at nodes.
pub(crate) trait NodeForce {
    /// The force (mN) at points (mm, mm/s).
    fn values_into(&mut self, points: &[[f64; 2]], values: &mut [f64]);
}

/// A force at many points with the same air: a network in batches, any other force point by point.
///
/// ```
/// use pam_core::{SealedMasses, SpringDamper};
/// use pam_surrogate::PointForces;
///
/// let spring = SpringDamper::published();
/// let forces = PointForces::new(&spring);
/// let masses = SealedMasses::new(0.05, 0.05)?;
/// let mut values = [0.0; 2];
/// forces.values_into(masses, &[[-1.0, 0.0], [1.0, 0.0]], &mut values, &mut forces.memory());
/// assert_eq!(values[0], -values[1]);
/// # Ok::<(), pam_core::ModelError>(())
/// ```
#[derive(Debug)]
pub struct PointForces<'f, F> {
    force: &'f F,
    network: Option<NodeNetwork>,
}

/// Memory of [`PointForces`] for one thread.
#[derive(Debug)]
pub struct PointMemory {
    work: Vec<f64>,
    network: Option<NodeWorkspace>,
}

impl<'f, F: ForceModel<f64>> PointForces<'f, F> {
    /// Lays out the force.
    #[must_use]
    pub fn new(force: &'f F) -> Self {
        Self { force, network: force.network().map(NodeNetwork::new) }
    }

    /// Memory for one thread.
    #[must_use]
    pub fn memory(&self) -> PointMemory {
        let work = if self.network.is_some() { 0 } else { self.force.work_len() };
        PointMemory {
            work: vec![0.0; work],
            network: self.network.as_ref().map(NodeNetwork::workspace),
        }
    }

    /// The force (mN) at points (mm, mm/s) with given masses.
    ///
    /// # Panics
    /// If the memory is of another force.
    pub fn values_into(
        &self,
        masses: SealedMasses,
        points: &[[f64; 2]],
        values: &mut [f64],
        memory: &mut PointMemory,
    ) {
        if let Some(network) = &self.network {
            let work = memory.network.as_mut().expect("memory of this network");
            let masses_g = [masses.flexor_g, masses.extensor_g];
            return network.sealed(masses_g, work).values_into(points, values);
        }
        for (value, &[displacement_mm, velocity_mm_s]) in values.iter_mut().zip(points) {
            let input = ForceInput {
                displacement_mm,
                velocity_mm_s,
                mass_flexor_g: masses.flexor_g,
                mass_extensor_g: masses.extensor_g,
            };
            *value = self.force.restoring_force_mn(&input, &mut memory.work);
        }
    }
}

/// The force at the masses of one trajectory.
pub(crate) struct SealedPoints<'f, F> {
    pub(crate) forces: PointForces<'f, F>,
    pub(crate) masses: SealedMasses,
    pub(crate) memory: PointMemory,
}

impl<F: ForceModel<f64>> NodeForce for SealedPoints<'_, F> {
    fn values_into(&mut self, points: &[[f64; 2]], values: &mut [f64]) {
        self.forces.values_into(self.masses, points, values, &mut self.memory);
    }
}

/// Most points of one pass of the network.
const BLOCK: usize = 128;

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
    work: &'a mut NodeWorkspace,
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

    pub(crate) fn sealed<'a>(
        &'a self,
        masses_g: [f64; 2],
        work: &'a mut NodeWorkspace,
    ) -> SealedNodes<'a> {
        SealedNodes { network: &self.network, masses_g, bias: self.network.fold(&masses_g), work }
    }
}

impl NodeForce for SealedNodes<'_> {
    fn values_into(&mut self, points: &[[f64; 2]], values: &mut [f64]) {
        let network = self.network;
        for (points, values) in points.chunks(BLOCK).zip(values.chunks_mut(BLOCK)) {
            let NodeWorkspace { input, out, block, .. } = &mut *self.work;
            write_input(points, network.input_stride(), input);
            network.values_into(points.len(), &self.bias, input, out, &mut [], block);
            for (value, out) in values.iter_mut().zip(out.chunks_exact(network.output_stride())) {
                *value = out[0];
            }
        }
    }
}

impl SealedNodes<'_> {
    /// Adds to the derivatives by the network's parameters and by the masses, for cotangents of the force at points.
    pub(crate) fn pull_back(
        &mut self,
        points: &[[f64; 2]],
        cotangents: &[f64],
        parameters: &mut [f64],
        masses: &mut [f64; 2],
    ) {
        let network = self.network;
        for (points, weights) in points.chunks(BLOCK).zip(cotangents.chunks(BLOCK)) {
            let count = points.len();
            let NodeWorkspace { input, out, ones, slopes, block, sums } = &mut *self.work;
            write_input(points, network.input_stride(), input);
            network.forward_into(count, &self.bias, input, out, &[], block);
            network.pull_back(count, ones, slopes, &[], block);
            network.accumulate(count, weights, input, ones, &[], sums, block);
        }
        network.drain_into(&mut self.work.sums, &self.masses_g, parameters, masses);
    }
}

fn write_input(points: &[[f64; 2]], stride: usize, input: &mut [f64]) {
    for (to, point) in input.chunks_exact_mut(stride).zip(points) {
        to[..2].copy_from_slice(point);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pam_core::Mlp;
    use pam_core::force::Dense;

    /// A network of these widths with weights that have no pattern.
    fn network(activation: &str, widths: &[usize]) -> NetworkForce<f64> {
        let layer = |(k, w): (usize, &[usize])| {
            let number = |i: usize| ((i * 37 + k * 11) % 101) as f64 / 50.5 - 1.0;
            let weights: Vec<f64> = (0..w[0] * w[1]).map(number).collect();
            Dense::from_rows(&weights, (0..w[1]).map(number).collect()).expect("a layer")
        };
        let layers = widths.windows(2).enumerate().map(layer).collect();
        let activation = Activation::from_name(activation).expect("a known one");
        NetworkForce::new(Mlp::new(layers, activation).expect("fits")).expect("a force")
    }

    #[test]
    fn batches_are_the_network_point_by_point() {
        let masses = SealedMasses::new(0.05, 0.07).expect("positive");
        let points: Vec<[f64; 2]> =
            (0..300).map(|k| [0.01 * f64::from(k) - 1.0, 40.0 - 0.3 * f64::from(k)]).collect();
        for (activation, widths) in
            [("silu", &[4, 24, 17, 1][..]), ("tanh", &[4, 9, 1]), ("leaky_relu", &[4, 1])]
        {
            let network = network(activation, widths);
            let forces = PointForces::new(&network);
            assert!(forces.network.is_some(), "{activation}");
            let mut values = vec![0.0; points.len()];
            forces.values_into(masses, &points, &mut values, &mut forces.memory());
            let mut work = vec![0.0; network.work_len()];
            for ([x, v], value) in points.iter().zip(&values) {
                let input = ForceInput {
                    displacement_mm: *x,
                    velocity_mm_s: *v,
                    mass_flexor_g: masses.flexor_g,
                    mass_extensor_g: masses.extensor_g,
                };
                let expected = network.restoring_force_mn(&input, &mut work);
                let scale = expected.abs().max(1.0);
                assert!(
                    (value - expected).abs() < 1e-12 * scale,
                    "{activation}: {value} {expected}"
                );
            }
        }
    }
}
