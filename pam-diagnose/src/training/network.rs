//! The network in a march: asked in plain numbers, and given back to a tape.

use crate::effects::Restoring;
use crate::simulation::march::BaseForce;
use pam_autodiff::Var;
use pam_core::{ForceInput, ForceModel, NetworkForce};
use std::cell::RefCell;

/// A point at which the network was asked: `(m_f, m_e, x, ẋ)` in g, g, mm, mm/s.
pub(super) type Call = [f64; 4];

/// The network in plain numbers, which notes where it is asked.
pub(super) struct Asked<'n> {
    force: &'n NetworkForce<f64>,
    inner: RefCell<AskedMemory>,
}

/// What [`Asked`] writes to; kept from run to run.
#[derive(Debug, Default)]
pub(super) struct AskedMemory {
    work: Vec<f64>,
    pub(super) calls: Vec<Call>,
}

impl<'n> Asked<'n> {
    pub(super) fn new(force: &'n NetworkForce<f64>, mut memory: AskedMemory) -> Self {
        memory.work.resize(force.work_len(), 0.0);
        memory.calls.clear();
        Self { force, inner: RefCell::new(memory) }
    }

    /// Number of calls up to now.
    pub(super) fn count(&self) -> usize {
        self.inner.borrow().calls.len()
    }

    pub(super) fn into_memory(self) -> AskedMemory {
        self.inner.into_inner()
    }
}

impl BaseForce<f64> for Asked<'_> {
    type Sealed<'a>
        = AskedWith<'a>
    where
        Self: 'a;

    fn sealed(&self, air_g: [f64; 2]) -> AskedWith<'_> {
        AskedWith { force: self.force, inner: &self.inner, air_g }
    }
}

/// [`Asked`] with given air.
pub(super) struct AskedWith<'a> {
    force: &'a NetworkForce<f64>,
    inner: &'a RefCell<AskedMemory>,
    air_g: [f64; 2],
}

impl Restoring<f64> for AskedWith<'_> {
    fn restoring_mn(&self, x: f64, v: f64) -> f64 {
        let memory = &mut *self.inner.borrow_mut();
        let [mass_flexor_g, mass_extensor_g] = self.air_g;
        memory.calls.push([mass_flexor_g, mass_extensor_g, x, v]);
        let at =
            ForceInput { displacement_mm: x, velocity_mm_s: v, mass_flexor_g, mass_extensor_g };
        self.force.restoring_force_mn(&at, &mut memory.work)
    }
}

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
