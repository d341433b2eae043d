//! Values and slopes of a force for many points at once.

use pam_autodiff::Chunk;
use pam_autodiff::batch::{BatchNetwork, NetworkBlock};
use pam_core::{AnyForce, ForceInput, ForceModel, NetworkForce, Scalar, scalar};

/// Inputs of a force in the order of a network's: m_f, m_e (g), x (mm), ẋ (mm/s).
pub type Point = [f64; 4];

/// A restoring force for many points at once, with its slopes along all four inputs.
pub trait ForceBatch: Sync {
    /// Scratch memory.
    type Work: Send;

    /// Memory for up to `capacity` points.
    fn work(&self, capacity: usize) -> Self::Work;

    /// Writes the forces (mN) at `points`.
    fn values_into(&self, points: &[Point], forces_mn: &mut [f64], work: &mut Self::Work);

    /// Writes forces (mN) and their slopes along m_f, m_e, x and ẋ at `points`; at a kink those of one of
    /// its sides.
    fn slopes_into(
        &self,
        points: &[Point],
        forces_mn: &mut [f64],
        slopes: &mut [Point],
        work: &mut Self::Work,
    );
}

/// Any force, point by point, by forward differentiation.
#[derive(Debug, Clone)]
pub struct Pointwise<F, D> {
    values: F,
    derivatives: D,
}

impl<F, D> Pointwise<F, D>
where
    F: ForceModel<f64> + Sync,
    D: ForceModel<Chunk<4>> + Sync,
{
    /// From the force over plain numbers and over chunks of four directions.
    pub fn new(values: F, derivatives: D) -> Self {
        Self { values, derivatives }
    }
}

fn input<S: Scalar>(at: [S; 4]) -> ForceInput<S> {
    let [mass_flexor_g, mass_extensor_g, displacement_mm, velocity_mm_s] = at;
    ForceInput { displacement_mm, velocity_mm_s, mass_flexor_g, mass_extensor_g }
}

impl<F, D> ForceBatch for Pointwise<F, D>
where
    F: ForceModel<f64> + Sync,
    D: ForceModel<Chunk<4>> + Sync,
{
    type Work = (Vec<f64>, Vec<Chunk<4>>);

    fn work(&self, _capacity: usize) -> Self::Work {
        (scalar::zeros(self.values.work_len()), scalar::zeros(self.derivatives.work_len()))
    }

    fn values_into(&self, points: &[Point], forces_mn: &mut [f64], work: &mut Self::Work) {
        for (p, f) in points.iter().zip(forces_mn) {
            *f = self.values.restoring_force_mn(&input(*p), &mut work.0);
        }
    }

    fn slopes_into(
        &self,
        points: &[Point],
        forces_mn: &mut [f64],
        slopes: &mut [Point],
        work: &mut Self::Work,
    ) {
        for ((p, f), s) in points.iter().zip(forces_mn).zip(slopes) {
            let variables = std::array::from_fn(|k| Chunk::variable(p[k], k));
            let force = self.derivatives.restoring_force_mn(&input(variables), &mut work.1);
            (*f, *s) = (force.value, force.derivatives);
        }
    }
}

/// A network, as matrix products.
#[derive(Debug, Clone)]
pub struct NetworkBatch {
    network: BatchNetwork<f64>,
    bias: Vec<f64>,
}

/// Scratch memory of a [`NetworkBatch`].
#[derive(Debug)]
pub struct NetworkWork {
    input: Vec<f64>,
    out: Vec<f64>,
    ones: Vec<f64>,
    slopes: Vec<f64>,
    block: NetworkBlock<f64>,
}

impl NetworkBatch {
    /// Lays out the weights.
    #[must_use]
    pub fn new(force: &NetworkForce<f64>) -> Self {
        let network = BatchNetwork::new(force.mlp(), 0);
        let bias = network.fold(&[]);
        Self { network, bias }
    }

    fn write(&self, points: &[Point], input: &mut [f64]) {
        for (to, from) in input.chunks_exact_mut(self.network.input_stride()).zip(points) {
            to[..4].copy_from_slice(from);
        }
    }

    fn read(&self, out: &[f64], forces_mn: &mut [f64]) {
        for (f, out) in forces_mn.iter_mut().zip(out.chunks_exact(self.network.output_stride())) {
            *f = out[0];
        }
    }
}

impl ForceBatch for NetworkBatch {
    type Work = NetworkWork;

    fn work(&self, capacity: usize) -> NetworkWork {
        NetworkWork {
            input: vec![0.0; capacity * self.network.input_stride()],
            out: vec![0.0; capacity * self.network.output_stride()],
            ones: vec![1.0; capacity],
            slopes: vec![0.0; capacity * 4],
            block: self.network.block(capacity),
        }
    }

    fn values_into(&self, points: &[Point], forces_mn: &mut [f64], work: &mut NetworkWork) {
        let capacity = work.block.capacity().max(1);
        for (points, forces_mn) in points.chunks(capacity).zip(forces_mn.chunks_mut(capacity)) {
            self.write(points, &mut work.input);
            let NetworkWork { input, out, block, .. } = work;
            self.network.values_into(points.len(), &self.bias, input, out, &mut [], block);
            self.read(out, forces_mn);
        }
    }

    fn slopes_into(
        &self,
        points: &[Point],
        forces_mn: &mut [f64],
        slopes: &mut [Point],
        work: &mut NetworkWork,
    ) {
        let n = points.len();
        self.write(points, &mut work.input);
        let NetworkWork { input, out, ones, slopes: flat, block } = work;
        self.network.forward_into(n, &self.bias, input, out, &[], block);
        self.network.pull_back(n, ones, flat, &[], block);
        self.read(out, &mut forces_mn[..n]);
        for (to, from) in slopes.iter_mut().zip(flat.chunks_exact(4)).take(n) {
            to.copy_from_slice(from);
        }
    }
}

/// The batch of a force that files know by name.
#[derive(Debug, Clone)]
pub enum AnyBatch {
    /// A network.
    Network(NetworkBatch),
    /// Anything else.
    Pointwise(Box<Pointwise<AnyForce<f64>, AnyForce<Chunk<4>>>>),
}

impl AnyBatch {
    /// The batch of a force.
    #[must_use]
    pub fn new(force: &AnyForce<f64>) -> Self {
        match force {
            AnyForce::Network(network) => Self::Network(NetworkBatch::new(network)),
            other => Self::Pointwise(Box::new(Pointwise::new(
                other.clone(),
                other.map(Chunk::<4>::constant),
            ))),
        }
    }
}

/// Scratch memory of an [`AnyBatch`].
#[derive(Debug)]
pub enum AnyWork {
    /// A network's.
    Network(NetworkWork),
    /// Of anything else.
    Pointwise((Vec<f64>, Vec<Chunk<4>>)),
}

impl ForceBatch for AnyBatch {
    type Work = AnyWork;

    fn work(&self, capacity: usize) -> AnyWork {
        match self {
            Self::Network(n) => AnyWork::Network(n.work(capacity)),
            Self::Pointwise(p) => AnyWork::Pointwise(p.work(capacity)),
        }
    }

    fn values_into(&self, points: &[Point], forces_mn: &mut [f64], work: &mut AnyWork) {
        match (self, work) {
            (Self::Network(n), AnyWork::Network(w)) => n.values_into(points, forces_mn, w),
            (Self::Pointwise(p), AnyWork::Pointwise(w)) => p.values_into(points, forces_mn, w),
            _ => unreachable!("memory of another batch"),
        }
    }

    fn slopes_into(
        &self,
        points: &[Point],
        forces_mn: &mut [f64],
        slopes: &mut [Point],
        work: &mut AnyWork,
    ) {
        match (self, work) {
            (Self::Network(n), AnyWork::Network(w)) => n.slopes_into(points, forces_mn, slopes, w),
            (Self::Pointwise(p), AnyWork::Pointwise(w)) => {
                p.slopes_into(points, forces_mn, slopes, w);
            }
            _ => unreachable!("memory of another batch"),
        }
    }
}
