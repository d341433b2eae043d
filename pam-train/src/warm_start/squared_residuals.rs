//! Squared residuals of the equation of motion, in batches of points.

use super::derivative_matching::Point;
use crate::coordinates::Coordinates;
use pam_autodiff::batch::{BatchNetwork, NetworkBlock, NetworkSums};
use pam_core::{RawParameters, Scalar};
use pam_trajectory::engine::NetworkJoint;
use rayon::prelude::*;

/// Points per task. Partial sums are added in the order of the tasks, so that the result does not depend on the number of threads.
const CHUNK: usize = 128;

/// The mean of `(F − m ẍ − B ẋ − f_θ)²/scale` over a batch, with its gradient. Buffers are reused from one batch to the next.
pub(super) struct SquaredResiduals {
    /// mN².
    scale: f64,
    tasks: Vec<Task>,
}

/// Memory and sums of one task.
struct Task {
    input: Vec<f32>,
    output: Vec<f32>,
    cotangent: Vec<f32>,
    input_cotangent: Vec<f32>,
    ones: Vec<f32>,
    block: NetworkBlock<f32>,
    sums: NetworkSums<f32>,
    /// Sum of the squares, mN².
    square: f64,
    by_mass: f64,
    by_weights: Vec<f64>,
}

impl Task {
    fn new(network: &BatchNetwork<f32>) -> Self {
        Self {
            input: vec![0.0; CHUNK * network.input_stride()],
            output: vec![0.0; CHUNK * network.output_stride()],
            cotangent: vec![0.0; CHUNK],
            input_cotangent: vec![0.0; CHUNK * network.inputs()],
            ones: vec![1.0; CHUNK],
            block: network.block(CHUNK),
            sums: network.sums(CHUNK),
            square: 0.0,
            by_mass: 0.0,
            by_weights: vec![0.0; network.parameter_len()],
        }
    }

    fn run(&mut self, network: &BatchNetwork<f32>, mass: f64, damping: f64, points: &[Point]) {
        let n = points.len();
        write_inputs(points, network.input_stride(), &mut self.input);
        let bias = network.fold(&[]);
        network.forward_into(n, &bias, &self.input, &mut self.output, &[], &mut self.block);
        (self.square, self.by_mass) = (0.0, 0.0);
        let forces = self.output.chunks_exact(network.output_stride());
        for ((p, force), c) in points.iter().zip(forces).zip(&mut self.cotangent) {
            let inertia = mass * p.acceleration + damping * p.input[3];
            let residual = p.force_mn - inertia - f64::from(force[0]);
            self.square += residual * residual;
            self.by_mass -= 2.0 * residual * p.acceleration;
            *c = (-2.0 * residual) as f32;
        }
        let cotangent = &self.cotangent[..n];
        network.pull_back(n, cotangent, &mut self.input_cotangent, &[], &mut self.block);
        let (ones, block) = (&self.ones[..n], &mut self.block);
        network.accumulate(n, ones, &self.input, cotangent, &[], &mut self.sums, block);
        self.by_weights.fill(0.0);
        network.drain_into(&mut self.sums, &[], &mut self.by_weights, &mut []);
    }
}

impl SquaredResiduals {
    /// Residuals whose squares are divided by `scale`, mN².
    pub(super) fn over(scale: f64) -> Self {
        Self { scale, tasks: Vec::new() }
    }

    /// The mean of a batch, and its gradient by the coordinates. All models must have one shape.
    pub(super) fn value_and_gradient(
        &mut self,
        coordinates: &Coordinates,
        model: &NetworkJoint,
        points: &[Point],
    ) -> (f64, Vec<f64>) {
        let mass = model.physical().mass_kg;
        let damping = coordinates.auxiliary_damping_kg_s();
        let network = BatchNetwork::<f32>::new(model.force.mlp(), 0);
        let count = points.len().div_ceil(CHUNK);
        while self.tasks.len() < count {
            self.tasks.push(Task::new(&network));
        }
        let tasks = &mut self.tasks[..count];
        tasks
            .par_iter_mut()
            .zip(points.par_chunks(CHUNK))
            .for_each(|(task, part)| task.run(&network, mass, damping, part));

        let per_point = 1.0 / (points.len() as f64 * self.scale);
        let mut by_weights = vec![0.0; network.parameter_len()];
        let (mut square, mut by_mass) = (0.0, 0.0);
        for task in tasks {
            square += task.square;
            by_mass += task.by_mass;
            for (all, own) in by_weights.iter_mut().zip(&task.by_weights) {
                *all += own * per_point;
            }
        }
        let raw = RawParameters {
            mass: by_mass * per_point * model.raw.mass.sigmoid(),
            gas_coefficient: 0.0,
            deformation: 0.0,
        };
        (square * per_point, coordinates.gradient_of(model, &by_weights, &raw))
    }
}

/// Writes the inputs of points row by row.
fn write_inputs(points: &[Point], stride: usize, input: &mut [f32]) {
    for (row, p) in input.chunks_exact_mut(stride).zip(points) {
        for (to, from) in row.iter_mut().zip(p.input) {
            *to = from as f32;
        }
    }
}
