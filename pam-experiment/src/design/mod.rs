//! What to measure next: the protocol that finds more, or distinguishes the live causes.
//!
//! A protocol is a set of sealed pressures and a sequence of segments of current: sines, sums of sines, chirps, triangles,
//! steps, holds and rests. [`design`] searches them within [limits](DesignLimits) by an evolution with a fixed seed
//! (mutations of the best of several lineages; Beyer and Schwefel 2002), since the objective has no derivative
//! by the kinds and the number of segments. Each proposal is simulated with the model; its worth follows from the
//! [signatures](pam_diagnose::joint::Signatures) of the effects under it, as in [`detect`](crate::detect).

mod objective;
mod report;
mod search;
mod space;

pub use objective::{LiveCause, Objective};
pub use report::design_report;
pub use search::{Design, DesignOptions, Gain, Separated, design};
pub use space::{DesignLimits, standard};

use pam_rig::Protocol;
use pam_rig::sensors::MotorParameters;

/// The commands of a protocol over time as CSV: `time_s, current_a`, and the pressures (kPa absolute) at which the muscles are
/// sealed before; one text for each recording with its name.
///
/// # Errors
/// [`RigError`](pam_rig::RigError) if the protocol has no conditions.
pub fn commands_csv(
    protocol: &Protocol,
    motor: &MotorParameters,
    rate_hz: f64,
    seed: u64,
) -> Result<Vec<(String, String)>, pam_rig::RigError> {
    use pam_core::units::{ATMOSPHERE_KPA, KPA_PER_PSI};
    let samples = (protocol.duration_s() * rate_hz).round() as usize;
    let of = |run: pam_rig::Run| {
        let [f, e] = run.start_psi.map(|p| p * KPA_PER_PSI + ATMOSPHERE_KPA);
        let mut text = String::from("time_s,current_a,pressure_flexor_kpa,pressure_extensor_kpa\n");
        for k in 0..samples {
            let t = k as f64 / rate_hz;
            let current = motor.current_a(protocol.current_a(t, seed));
            text += &format!("{t:.4},{current:.5},{f:.3},{e:.3}\n");
        }
        (run.name, text)
    };
    Ok(protocol.runs()?.into_iter().map(of).collect())
}
