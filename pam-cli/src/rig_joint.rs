//! The virtual rig as a joint under command.

use pam_control::execution::{Air, Joint, JointCommand, Reading, Valve};
use pam_core::units::{
    ATMOSPHERE_KPA, KPA_PER_PSI, MN_PER_N, PULLEY_RADIUS_MM, tendon_force_mn_per_a,
};
use pam_rig::pneumatics::Opening;
use pam_rig::{Command, Frame, PressureCommand, Rig, RigError, RigParameters};

/// A rig in operation, in the units of commands.
pub struct RigJoint {
    rig: Rig,
    last: Option<Frame>,
}

impl RigJoint {
    /// A rig whose muscles hold these pressures, kPa absolute.
    ///
    /// # Errors
    /// [`RigError::Parameter`] if the parameters are impossible.
    pub fn new(
        parameters: &RigParameters,
        seed: u64,
        pressures_kpa: [f64; 2],
    ) -> Result<Self, RigError> {
        let mut rig = Rig::new(parameters, seed, 0.0)?;
        rig.fill(pressures_kpa);
        Ok(Self { rig, last: None })
    }

    /// The last sample, with its truth.
    #[must_use]
    pub fn last(&self) -> Option<&Frame> {
        self.last.as_ref()
    }
}

fn gauge_psi(pressure_kpa: f64) -> f64 {
    (pressure_kpa - ATMOSPHERE_KPA) / KPA_PER_PSI
}

fn opening(valve: Valve) -> Opening {
    match valve {
        Valve::Shut => Opening::Shut,
        Valve::Inflate => Opening::Inflate,
        Valve::Exhaust => Opening::Exhaust,
    }
}

impl Joint for RigJoint {
    fn tick(&mut self, command: &JointCommand) -> Reading {
        let pressure = match command.air {
            Air::Sealed => PressureCommand::Sealed,
            Air::Servo(kpa) => PressureCommand::Servo(kpa.map(gauge_psi)),
            Air::Valves(valves) => PressureCommand::Valves(valves.map(opening)),
        };
        let current_a = command.force_n * MN_PER_N / tendon_force_mn_per_a();
        let frame = self.rig.tick(&Command { current_a, pressure });
        let row = &frame.row;
        let reading = Reading {
            displacement_mm: -row.angle_deg.to_radians() * PULLEY_RADIUS_MM,
            pressures_kpa: row.measured_psi.map(|p| p * KPA_PER_PSI + ATMOSPHERE_KPA),
        };
        self.last = Some(frame);
        reading
    }
}
