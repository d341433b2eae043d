//! One window: simulated forward, swept backward.

use super::network::{Asked, AskedMemory, Replayed};
use super::observation::{Channels, at_samples, pull_back};
use super::operating_model::OperatingModel;
use crate::effects::EffectScalar;
use crate::simulation::integrator::JointIntegrator;
use crate::simulation::measured::Measured;
use crate::simulation::observation::measure;
use crate::simulation::parts::Parts;
use crate::simulation::steps::substeps;
use crate::simulation::{Base, Diverged, Nuisances, ResampledRecord};
use pam_autodiff::batch::{BatchNetwork, NetworkBlock, NetworkSums};
use pam_autodiff::{Gathered, Tape, Var};
use pam_core::Scalar;
use pam_core::simd::Float;

/// Points of the network that are worked out together.
const BLOCK: usize = 512;

/// Derivatives of the loss of one window, besides those by the weights.
#[derive(Debug, Clone, Default)]
pub(super) struct WindowGradient {
    /// Parameters and switches of the effects in turn.
    pub(super) values: Vec<f64>,
    /// m, C, ν and B.
    pub(super) physical: [f64; 4],
    /// Logarithms of the masses of flexor and extensor.
    pub(super) log_air: [f64; 2],
    /// The start `[x, ẋ, P_f, P_e]`.
    pub(super) start: [f64; 4],
}

/// Memory of a thread, kept from window to window.
#[derive(Debug)]
pub(super) struct Workspace<T> {
    asked: AskedMemory,
    /// Number of calls before each step.
    calls_before: Vec<usize>,
    /// Substeps of the last run.
    substeps: usize,
    states: Vec<f64>,
    channels: Channels<f64>,
    seen: Channels<f64>,
    tape: Tape,
    gathered: Gathered,
    block: NetworkBlock<T>,
    pub(super) sums: NetworkSums<T>,
    input: Vec<T>,
    output: Vec<T>,
    slopes: Vec<T>,
    ones: Vec<T>,
    weights: Vec<T>,
}

impl<T: Float> Workspace<T> {
    pub(super) fn new(network: &BatchNetwork<T>, plain: &BatchNetwork<f64>) -> Self {
        let zeros = |len: usize| vec![T::default(); len];
        Self {
            asked: AskedMemory::new(plain),
            calls_before: Vec::new(),
            substeps: 1,
            states: Vec::new(),
            channels: Channels::default(),
            seen: Channels::default(),
            tape: Tape::new(),
            gathered: Gathered::default(),
            block: network.block(BLOCK),
            sums: network.sums(BLOCK),
            input: zeros(BLOCK * network.input_stride()),
            output: zeros(BLOCK * network.output_stride()),
            slopes: zeros(BLOCK * network.inputs()),
            ones: vec![T::narrow(1.0); BLOCK],
            weights: zeros(BLOCK),
        }
    }

    /// Simulates a window from `start` and writes its predictions at the samples.
    pub(super) fn forward(
        &mut self,
        at: &OperatingModel<'_, T>,
        record: &ResampledRecord,
        time_s: &[f64],
        start: [f64; 4],
        out: &mut Vec<[f64; 4]>,
    ) -> Result<(), Diverged> {
        let parts = Parts::new(at.effects, at.values);
        let asked = Asked::new(at.plain, at.plain_bias, &mut self.asked);
        let measured = measured_from(record, start);
        let (base, none) = (&at.base, Nuisances::none());
        self.substeps =
            substeps(&mut JointIntegrator::new(record, base, &asked, &parts, &measured, &none, 1));
        asked.forget();
        let mut integrator =
            JointIntegrator::new(record, base, &asked, &parts, &measured, &none, self.substeps);
        let len = integrator.state_len();
        self.states.resize(record.points() * len, 0.0);
        self.calls_before.clear();
        let (states, calls_before) = (&mut self.states, &mut self.calls_before);
        integrator.run(record.points(), &mut self.channels, |k, integrator| {
            integrator.state_into(&mut states[k * len..(k + 1) * len]);
            calls_before.push(asked.count());
        })?;
        for (seen, channel) in self.seen.iter_mut().zip(&self.channels) {
            seen.clone_from(channel);
        }
        measure(record, &parts, &mut self.seen);
        at_samples(record, time_s, &self.seen, out);
        Ok(())
    }

    /// The gradient of a loss from its derivatives by the predictions of the last [`forward`](Self::forward).
    /// That by the weights is added to [`sums`](Self::sums), and those to `by_weights` when they are emptied.
    pub(super) fn backward(
        &mut self,
        at: &OperatingModel<'_, T>,
        record: &ResampledRecord,
        time_s: &[f64],
        start: [f64; 4],
        by_samples: &[[f64; 4]],
        by_weights: &mut [f64],
    ) -> WindowGradient {
        let mut gradient =
            WindowGradient { values: vec![0.0; at.values.len()], ..WindowGradient::default() };
        let by_channels = pull_back(
            at,
            record,
            time_s,
            &self.channels,
            by_samples,
            &mut self.tape,
            &mut gradient.values,
        );

        let mut tape = std::mem::take(&mut self.tape);
        let mut gathered = std::mem::take(&mut self.gathered);
        tape.clear();
        gathered.clear();
        let p = tape.variables(at.values);
        let own = &at.base;
        let numbers =
            tape.variables(&[own.mass_kg, own.gas_coefficient, own.deformation, own.damping_kg_s]);
        let begin = tape.variables(&start);
        let log_air = tape.variables(&[0.0; 2]);
        let base = Base {
            mass_kg: numbers[0],
            gas_coefficient: numbers[1],
            deformation: numbers[2],
            damping_kg_s: numbers[3],
            geometry: own.geometry,
        };
        let parts = Parts::new(at.effects, &p);
        let replayed = Replayed::default();
        let measured = measured_from(record, [begin[0], begin[1], begin[2], begin[3]]);
        let nuisances = Nuisances { log_air: [log_air[0], log_air[1]], ..Nuisances::none() };
        let (mut integrator, at_start, first_state) = tape.record(|| {
            let substeps = self.substeps;
            let mut integrator = JointIntegrator::new(
                record, &base, &replayed, &parts, &measured, &nuisances, substeps,
            );
            let mut state = vec![Var::constant(0.0); integrator.state_len()];
            integrator.state_into(&mut state);
            integrator.at_point(0);
            let pressures = integrator.pressures();
            (integrator, pressures, state)
        });
        let start_kpa = integrator.start_kpa();
        let mark = tape.mark();

        let (points, len) = (record.points(), integrator.state_len());
        let mut leaves = first_state.clone();
        let mut next = first_state.clone();
        let mut adjoint = vec![0.0; len];
        let mut by_kpa = [0.0; 2];
        // Steps whose network is worked out: from `from` to the one before `until`.
        let (mut from, mut until) = (points - 1, points - 1);
        for k in (0..points).rev() {
            let steps = k + 1 < points;
            if steps && k < from {
                self.flush(at, from..until, by_weights);
                until = from;
                from = self.first_of_block(until);
                self.work_out(at, from..until);
            }
            tape.rewind(mark);
            tape.variables_into(&self.states[k * len..(k + 1) * len], &mut leaves);
            if steps {
                let first = self.calls_before[from];
                let own = self.calls_before[k] - first..self.calls_before[k + 1] - first;
                let stride = at.network.inputs();
                let values = &self.asked.values[first..];
                replayed.begin(own.map(|c| {
                    let slopes = &self.slopes[c * stride..];
                    (values[c], std::array::from_fn(|i| slopes[i].widen()))
                }));
            }
            let pressures = tape.record(|| {
                integrator.restore(&leaves);
                integrator.at_point(k);
                let pressures = integrator.pressures();
                if steps {
                    integrator.step(k);
                    integrator.state_into(&mut next);
                }
                pressures
            });
            for i in 0..2 {
                by_kpa[i] += by_channels[2 + i][k];
            }
            let own = [leaves[0], leaves[1], pressures[0], pressures[1]];
            let own = own.into_iter().zip(by_channels.iter().map(|c| c[k]));
            let later = next.iter().copied().zip(adjoint.iter().copied());
            let seeds = own.chain(later.take(if steps { len } else { 0 }));
            let found = tape.reverse_since(mark, &mut gathered, seeds);
            for (a, &leaf) in adjoint.iter_mut().zip(&leaves) {
                *a = found.of(leaf);
            }
            if steps {
                let first = self.calls_before[k] - self.calls_before[from];
                let weights = &mut self.weights;
                replayed.results(|c, result| weights[first + c] = T::narrow(found.of(result)));
            }
        }
        self.flush(at, from..until, by_weights);
        tape.rewind(mark);
        let seeds = first_state.into_iter().zip(adjoint);
        let seeds = seeds
            .chain(start_kpa.into_iter().zip(by_kpa))
            .chain(at_start.into_iter().zip(by_kpa.map(|v| -v)));
        let found = tape.reverse_gathered(&gathered, seeds);
        found.add_to(&p, &mut gradient.values);
        found.add_to(&numbers, &mut gradient.physical);
        found.add_to(&log_air, &mut gradient.log_air);
        found.add_to(&begin, &mut gradient.start);
        self.tape = tape;
        self.gathered = gathered;
        gradient
    }

    /// The first of the steps before `until` whose calls fit a block.
    fn first_of_block(&self, until: usize) -> usize {
        let end = self.calls_before[until];
        self.calls_before[..until].partition_point(|&before| end - before > BLOCK).min(until - 1)
    }

    /// Values and slopes of the network at the calls of these steps.
    fn work_out(&mut self, at: &OperatingModel<'_, T>, steps: std::ops::Range<usize>) {
        let calls = &self.asked.calls[self.calls_before[steps.start]..self.calls_before[steps.end]];
        let network = at.network;
        for (to, call) in self.input.chunks_exact_mut(network.input_stride()).zip(calls) {
            for (to, &value) in to.iter_mut().zip(call) {
                *to = T::narrow(value);
            }
        }
        let count = calls.len();
        network.forward_into(
            count,
            at.first_bias,
            &self.input,
            &mut self.output,
            &[],
            &mut self.block,
        );
        network.pull_back(count, &self.ones, &mut self.slopes, &[], &mut self.block);
    }

    /// Adds the weight derivatives of these steps.
    fn flush(
        &mut self,
        at: &OperatingModel<'_, T>,
        steps: std::ops::Range<usize>,
        by_weights: &mut [f64],
    ) {
        let count = self.calls_before[steps.end] - self.calls_before[steps.start];
        if steps.is_empty() || count == 0 {
            return;
        }
        at.network.accumulate(
            count,
            &self.weights,
            &self.input,
            &self.ones,
            &[],
            &mut self.sums,
            &mut self.block,
        );
        at.network.drain_into(&mut self.sums, &[], by_weights, &mut []);
    }
}

/// The readings with another start `[x, ẋ, P_f, P_e]`.
fn measured_from<S: EffectScalar>(record: &ResampledRecord, start: [S; 4]) -> Measured<S> {
    let mut measured = Measured::of(record);
    measured.rest.start_mm = start[0];
    measured.start_mm_s = start[1];
    measured.rest.start_kpa = [start[2], start[3]];
    measured
}
