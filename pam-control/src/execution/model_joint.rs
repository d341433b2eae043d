use super::{Air, Joint, JointCommand, Reading, SAMPLE_S};
use pam_core::units::MN_PER_N;
use pam_core::{ForceInput, ForceModel, JointModel, SealedMasses};
use pam_solvers::rk4_step;
use std::sync::Arc;

/// The model itself as a joint: what an experiment would give if the model were the truth.
///
/// `m ẍ = F_e − f(x, ẋ, m_f, m_e) − B ẋ` by one classical Runge–Kutta step per sample. A servo command holds the
/// air that the gas law gives for its pressures at the displacement of the moment, without delay; sealed air
/// stays. Noise, friction, the servo's errors and all else that the model does not hold are absent, so a
/// difference between what a rig and this joint give is no property of the commands or of the evaluation. A
/// model knows no valves: driven by hand, they stay shut.
#[derive(Debug, Clone)]
pub struct ModelJoint<F> {
    model: Arc<JointModel<f64, F>>,
    masses: SealedMasses,
    /// Displacement and velocity, mm and mm/s.
    state: [f64; 2],
    work: Vec<f64>,
}

impl<F: ForceModel<f64>> ModelJoint<F> {
    /// At rest in the middle with muscles at these pressures, kPa absolute.
    #[must_use]
    pub fn new(model: Arc<JointModel<f64, F>>, pressures_kpa: [f64; 2]) -> Self {
        let masses = model.gas_law_masses(0.0, pressures_kpa);
        let work = vec![0.0; model.force.work_len()];
        Self { model, masses, state: [0.0; 2], work }
    }

    fn rate(&mut self, [x, v]: [f64; 2], force_mn: f64) -> [f64; 2] {
        let input = ForceInput {
            mass_flexor_g: self.masses.flexor_g,
            mass_extensor_g: self.masses.extensor_g,
            displacement_mm: x,
            velocity_mm_s: v,
        };
        let restoring = self.model.force.restoring_force_mn(&input, &mut self.work);
        let damping = self.model.auxiliary_damping_kg_s * v;
        [v, (force_mn - restoring - damping) / self.model.physical().mass_kg]
    }
}

impl<F: ForceModel<f64>> Joint for ModelJoint<F> {
    fn tick(&mut self, command: &JointCommand) -> Reading {
        let x = self.state[0];
        if let Air::Servo(pressures_kpa) = command.air {
            self.masses = self.model.gas_law_masses(x, pressures_kpa);
        }
        let reading = Reading {
            displacement_mm: x,
            pressures_kpa: self.model.gas_law_pressures_kpa(x, self.masses),
        };
        let (start, force_mn) = (self.state, command.force_n * MN_PER_N);
        let k1 = self.rate(start, force_mn);
        self.state = rk4_step(start, k1, SAMPLE_S, |_, state| self.rate(state, force_mn));
        reading
    }
}
