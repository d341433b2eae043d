//! Full states of sealed chambers from the motion `(x, ẋ)` that fast solvers find.

use super::pressures::{GasCotangents, SealedGas};
use super::{GradientSums, IndexedLoss, TrajectoryGradient, TrajectoryRequest};
use pam_core::JointModel;
use std::sync::Mutex;

/// Memory for full states and their cotangents.
#[derive(Debug, Default)]
pub(super) struct SealedStates {
    windows: Vec<Mutex<WindowStates>>,
    /// Cotangents of full states, one buffer for each thread at work: they are of no use afterwards, and
    /// memory that is used again at once is fast.
    cotangents: Mutex<Vec<Vec<[f64; 4]>>>,
}

/// Full states of one window, and the derivatives of its loss through the pressures.
#[derive(Debug, Default)]
struct WindowStates {
    states: Vec<[f64; 4]>,
    gas: GasCotangents,
}

impl SealedStates {
    /// Makes room for this many windows.
    pub(super) fn reserve(&mut self, windows: usize) {
        if self.windows.len() < windows {
            self.windows.resize_with(windows, Mutex::default);
        }
    }

    /// The loss as a function of the motion `[times, (x, ẋ)]`: adds the pressures, and pulls their cotangents
    /// back.
    pub(super) fn loss_of_motion<'a, F: Sync>(
        &'a self,
        request: &'a TrajectoryRequest<'_, F>,
        loss: &'a IndexedLoss<'_>,
        backward: bool,
    ) -> impl Fn(usize, &[f64], &mut [f64]) -> f64 + Sync + 'a {
        move |index, observed, cotangents| {
            let subject = request.subject(index);
            let measured = &subject.recording;
            let gas = SealedGas::new(request.model, subject.masses, request.start(index));
            let mut own = self.windows[index].lock().expect("no loss panics");
            own.states.resize(measured.len(), [0.0; 4]);
            gas.complete(observed, &mut own.states);
            let spare = || self.cotangents.lock().expect("no loss panics");
            let mut of_states = spare().pop().unwrap_or_default();
            of_states.resize(measured.len(), [0.0; 4]);
            let value = loss(index, measured, &own.states, &mut of_states);
            if backward {
                own.gas = gas.pull_back(observed, &of_states, cotangents);
            }
            spare().push(of_states);
            value
        }
    }

    /// Adds the derivatives through the pressures to those of the motion, and takes the mean.
    pub(super) fn mean_with_pressures<F>(
        &mut self,
        model: &JointModel<f64, F>,
        motion: GradientSums,
    ) -> TrajectoryGradient {
        let mut sums =
            GradientSums { joint_by_raw: GradientSums::physical_by_raw(model), ..motion };
        for (i, own) in self.windows.iter_mut().take(sums.values.len()).enumerate() {
            if sums.failures.iter().any(|f| f.problem == i) {
                continue;
            }
            let gas = own.get_mut().expect("no loss panics").gas;
            sums.joint[1] += gas.gas_coefficient;
            sums.joint[2] += gas.deformation;
            for k in 0..2 {
                sums.masses[i][k] += gas.masses[k];
                sums.initial_states[i][2 + k] += gas.start_kpa[k];
            }
            sums.initial_states[i][0] += gas.start_mm;
        }
        TrajectoryGradient::mean_of(sums)
    }

    /// The states of a window of the last call.
    pub(super) fn of(&mut self, index: usize) -> &[[f64; 4]] {
        &self.windows[index].get_mut().expect("no loss panics").states
    }
}
