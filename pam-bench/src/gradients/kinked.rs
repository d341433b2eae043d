//! The truth for a joint whose network has kinks: the closed form from kink to kink.
//!
//! The closed form wants a force of straight lines. A smooth drive is read on a grid, linear between its
//! points; that moves the solution and its derivatives by a multiple of the square of the spacing, which
//! two grids show and extrapolation removes.

use super::case::Exact;
use pam_core::{JointModel, NetworkForce, SealedMasses};
use pam_data::Subject;
use pam_data::{MassOrigin, Recording};
use pam_solvers::Interpolation;
use pam_trajectory::{ClosedFormEngine, TrajectoryEngine, TrajectoryRequest, Windows};
use std::path::Path;

/// Grid points from one observation to the next, on the finer grid.
const POINTS: usize = 2000;

/// A joint with sealed air under a drive, and what is asked of it.
pub struct KinkedJoint<'a> {
    /// The joint, with a (leaky) ReLU network.
    pub model: &'a JointModel<f64, NetworkForce<f64>>,
    /// Its air.
    pub masses: SealedMasses,
    /// The force, mN, by time.
    pub drive: fn(f64, &mut [f64]),
    /// State at time zero.
    pub start: [f64; 4],
    /// When it is observed, s; the last is the end.
    pub observations_s: &'a [f64],
}

impl KinkedJoint<'_> {
    /// Value and gradient of a loss, and the observed states; `None` if the network has no closed form or
    /// the motion diverges. The parameters are those of [`JointField`](pam_core::JointField).
    pub fn truth(
        &self,
        loss: &(impl Fn(&[f64], &[f64], &mut [f64]) -> f64 + Sync),
    ) -> Option<Exact> {
        self.extrapolated(POINTS, loss)
    }

    /// The truth with this many points of the finer grid from one observation to the next.
    pub fn extrapolated(
        &self,
        points: usize,
        loss: &(impl Fn(&[f64], &[f64], &mut [f64]) -> f64 + Sync),
    ) -> Option<Exact> {
        let fine = self.on_grid(points, loss)?;
        let coarse = self.on_grid(points / 2, loss)?;
        let limit = |fine: &[f64], coarse: &[f64]| -> Vec<f64> {
            fine.iter().zip(coarse).map(|(f, c)| f + (f - c) / 3.0).collect()
        };
        Some(Exact {
            value: fine.value + (fine.value - coarse.value) / 3.0,
            parameters: limit(&fine.parameters, &coarse.parameters),
            initial_state: limit(&fine.initial_state, &coarse.initial_state),
            states: limit(&fine.states, &coarse.states),
        })
    }

    fn on_grid(
        &self,
        points: usize,
        loss: &(impl Fn(&[f64], &[f64], &mut [f64]) -> f64 + Sync),
    ) -> Option<Exact> {
        let mut times = vec![0.0];
        let mut before = 0.0;
        for &at in self.observations_s {
            let inside = (1..points).map(|k| before + (at - before) * k as f64 / points as f64);
            times.extend(inside);
            times.push(at);
            before = at;
        }
        let observed: Vec<usize> = (1..=self.observations_s.len()).map(|k| k * points).collect();
        let force = times.iter().map(|&t| {
            let mut u = [0.0];
            (self.drive)(t, &mut u);
            u[0]
        });
        let mut recording = Recording::empty(Path::new("drive"));
        let column = |value: f64| vec![value; times.len()];
        recording.force_mn = force.collect();
        recording.displacement_mm = column(self.start[0]);
        recording.velocity_mm_s = column(self.start[1]);
        recording.pressure_flexor_kpa = column(self.start[2]);
        recording.pressure_extensor_kpa = column(self.start[3]);
        recording.time_s = times;
        let subject = Subject { recording, masses: self.masses, origin: MassOrigin::Given };
        let at_observations =
            |_: usize, _: &Recording, states: &[[f64; 4]], cotangents: &mut [[f64; 4]]| {
                let seen: Vec<f64> = observed.iter().flat_map(|&k| states[k]).collect();
                let mut own = vec![0.0; seen.len()];
                let value = loss(self.observations_s, &seen, &mut own);
                cotangents.fill([0.0; 4]);
                for (&k, own) in observed.iter().zip(own.as_chunks::<4>().0) {
                    cotangents[k] = *own;
                }
                value
            };
        let mut solver = ClosedFormEngine::new(Interpolation::Linear);
        let (starts, windows) = ([self.start], Windows::of([subject], None));
        let request = TrajectoryRequest {
            starts: Some(&starts),
            ..TrajectoryRequest::new(self.model, &windows)
        };
        let found = solver
            .evaluate(&request, &at_observations, true)
            .ok()
            .filter(|g| g.failures.is_empty())?;
        let states = TrajectoryEngine::<NetworkForce<f64>>::predicted(&mut solver, 0);
        let mut parameters = found.force;
        parameters.extend([found.raw.mass, found.raw.gas_coefficient, found.raw.deformation]);
        parameters.push(found.auxiliary_damping);
        parameters.extend([found.masses[0].flexor_g, found.masses[0].extensor_g]);
        Some(Exact {
            value: found.value,
            parameters,
            initial_state: found.initial_states[0].to_vec(),
            states: observed.iter().flat_map(|&k| states[k]).collect(),
        })
    }
}
