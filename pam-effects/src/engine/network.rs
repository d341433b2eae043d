//! The network in a simulation: evaluated in plain numbers, and replayed on a tape.

use crate::effects::Restoring;
use crate::simulation::base::{BaseForce, SealedForce};
use pam_autodiff::Var;
use pam_autodiff::batch::{BatchNetwork, NetworkBlock};
use std::cell::RefCell;

/// A point at which the network was evaluated: `(m_f, m_e, x, ẋ)` in g, g, mm, mm/s.
pub(super) type Call = [f64; 4];

/// The network in plain numbers, which notes its inputs and values.
pub(super) struct Asked<'n> {
    network: &'n BatchNetwork<f64>,
    first_bias: &'n [f64],
    inner: RefCell<&'n mut AskedMemory>,
}

/// Memory of [`Asked`], kept from run to run.
#[derive(Debug)]
pub(super) struct AskedMemory {
    block: NetworkBlock<f64>,
    input: Vec<f64>,
    output: Vec<f64>,
    pub(super) calls: Vec<Call>,
    /// Values of the network, mN.
    pub(super) values: Vec<f64>,
}

impl AskedMemory {
    pub(super) fn new(network: &BatchNetwork<f64>) -> Self {
        Self {
            block: network.block(1),
            input: vec![0.0; network.input_stride()],
            output: vec![0.0; network.output_stride()],
            calls: Vec::new(),
            values: Vec::new(),
        }
    }
}

impl<'n> Asked<'n> {
    pub(super) fn new(
        network: &'n BatchNetwork<f64>,
        first_bias: &'n [f64],
        memory: &'n mut AskedMemory,
    ) -> Self {
        memory.calls.clear();
        memory.values.clear();
        Self { network, first_bias, inner: RefCell::new(memory) }
    }

    /// Forgets the calls up to now.
    pub(super) fn forget(&self) {
        let memory = &mut **self.inner.borrow_mut();
        memory.calls.clear();
        memory.values.clear();
    }

    /// Number of calls up to now.
    pub(super) fn count(&self) -> usize {
        self.inner.borrow().calls.len()
    }
}

impl<'n> BaseForce<f64> for Asked<'n> {
    type Sealed<'a>
        = AskedWith<'a, 'n>
    where
        Self: 'a;

    fn sealed(&self, air_g: [f64; 2]) -> AskedWith<'_, 'n> {
        AskedWith { asked: self, air_g }
    }
}

/// [`Asked`] with given air.
pub(super) struct AskedWith<'a, 'n> {
    asked: &'a Asked<'n>,
    air_g: [f64; 2],
}

impl Restoring<f64> for AskedWith<'_, '_> {
    fn restoring_mn(&self, x: f64, v: f64) -> f64 {
        let Asked { network, first_bias, inner } = self.asked;
        let memory = &mut **inner.borrow_mut();
        let call = [self.air_g[0], self.air_g[1], x, v];
        memory.input[..4].copy_from_slice(&call);
        let (input, output) = (&memory.input, &mut memory.output);
        network.values_into(1, first_bias, input, output, &mut [], &mut memory.block);
        let value = memory.output[0];
        memory.calls.push(call);
        memory.values.push(value);
        value
    }
}

impl SealedForce<f64> for AskedWith<'_, '_> {}

/// The network of one step on a tape: values and slopes that were found before, call by call.
#[derive(Default)]
pub(super) struct Replayed(RefCell<Replay>);

#[derive(Default)]
struct Replay {
    /// Values and slopes by `(m_f, m_e, x, ẋ)`.
    known: Vec<(f64, [f64; 4])>,
    next: usize,
    results: Vec<Var>,
}

impl Replayed {
    /// Begins a step with what is known of its calls.
    pub(super) fn begin(&self, known: impl Iterator<Item = (f64, [f64; 4])>) {
        let replay = &mut *self.0.borrow_mut();
        replay.known.clear();
        replay.known.extend(known);
        replay.next = 0;
        replay.results.clear();
    }

    /// Tells the results of the step's calls in their order.
    pub(super) fn results(&self, mut tell: impl FnMut(usize, Var)) {
        for (k, &result) in self.0.borrow().results.iter().enumerate() {
            tell(k, result);
        }
    }
}

impl BaseForce<Var> for Replayed {
    type Sealed<'a>
        = ReplayedWith<'a>
    where
        Self: 'a;

    fn sealed(&self, air_g: [Var; 2]) -> ReplayedWith<'_> {
        ReplayedWith { replay: &self.0, air_g }
    }
}

/// [`Replayed`] with given air.
pub(super) struct ReplayedWith<'a> {
    replay: &'a RefCell<Replay>,
    air_g: [Var; 2],
}

impl Restoring<Var> for ReplayedWith<'_> {
    fn restoring_mn(&self, x: Var, v: Var) -> Var {
        let replay = &mut *self.replay.borrow_mut();
        let k = replay.next;
        replay.next += 1;
        // The same numbers take the same branches, so that every call was made before.
        let (value, [by_flexor, by_extensor, by_x, by_v]) = replay.known[k];
        let [flexor, extensor] = self.air_g;
        let result = Var::computed(
            value,
            [(x, by_x), (v, by_v), (flexor, by_flexor), (extensor, by_extensor)],
        );
        replay.results.push(result);
        result
    }
}

impl SealedForce<Var> for ReplayedWith<'_> {}
