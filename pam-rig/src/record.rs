//! Recording a protocol: logs and their ground truth.

use crate::error::RigError;
use crate::protocol::{Protocol, Run};
use crate::rig::{Command, PressureCommand, Rig, RigParameters};
use crate::truth::Truth;
use pam_data::formats::raw_log::{self, Row};

/// Time at the head of a log before the controller starts, s.
const IDLE_S: f64 = 0.05;

/// A recording of the rig.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    /// Name of the recording and its log.
    pub name: String,
    /// Nominal frames per second.
    pub rate_hz: f64,
    /// The log's rows.
    pub rows: Vec<Row>,
    /// The ground truth.
    pub truth: Truth,
}

impl Recorded {
    /// The log's text.
    #[must_use]
    pub fn log_text(&self, note: &str) -> String {
        raw_log::to_text(note, self.rate_hz, 0, &self.rows)
    }
}

/// Derives the noise seed of a run from the session seed and the run's name, so that runs have independent noise.
///
/// This is FNV-1a over the name, with `seed` mixed into the initial state. Changing the function changes the recordings
/// of every published seed.
fn seed_of(seed: u64, name: &str) -> u64 {
    const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0100_0000_01b3;
    name.bytes().fold(OFFSET ^ seed, |sum, b| (sum ^ u64::from(b)).wrapping_mul(PRIME))
}

/// Most samples of one run: three hours at 1 kHz, or half the memory that readers allow.
const MOST_FRAMES: usize = 10_000_000;
/// Most steps of the plant in one run.
const MOST_STEPS: usize = 1_000_000_000;

/// Checks that a protocol does not ask for more samples than a run can have.
///
/// # Errors
/// [`RigError::Parameter`] naming the rate.
pub(crate) fn check_length(
    parameters: &RigParameters,
    protocol: &Protocol,
) -> Result<(), RigError> {
    let rate_hz = parameters.sensors.clock.rate_hz;
    let lead = &protocol.lead_in;
    let length_s = IDLE_S + lead.inflate_s + lead.rest_s + protocol.duration_s();
    // The cast saturates.
    let total = (length_s * rate_hz).round() as usize;
    let steps = total.saturating_mul(parameters.steps_per_sample);
    if total <= MOST_FRAMES && steps <= MOST_STEPS {
        return Ok(());
    }
    Err(RigError::Parameter {
        field: "sensors.clock.rate_hz".into(),
        value: rate_hz,
        message: format!(
            "a run of {length_s:.1} s takes {total} samples and {steps} steps of the plant; {MOST_FRAMES} and {MOST_STEPS} \
             are the most. Lower the rate, the steps per sample, or the length of the protocol"
        ),
    })
}

/// Carries out one run.
///
/// The log begins with the controller idle, then the servo inflates the muscles from room pressure,
/// the valves close, the joint rests, and at time zero the tracks of the protocol begin.
///
/// # Errors
/// [`RigError::Parameter`] if the rig's parameters are impossible or ask for too many samples,
/// [`RigError::Diverged`] if its motion does not stay finite.
pub fn record(
    parameters: &RigParameters,
    protocol: &Protocol,
    run: &Run,
    seed: u64,
) -> Result<Recorded, RigError> {
    check_length(parameters, protocol)?;
    let seed = seed_of(seed, &run.name);
    let rate_hz = parameters.sensors.clock.rate_hz;
    let frames = |time_s: f64| (time_s * rate_hz).round() as usize;
    let lead = &protocol.lead_in;
    let (idle, inflate, rest) = (frames(IDLE_S), frames(lead.inflate_s), frames(lead.rest_s));
    let before = idle + inflate + rest;
    let sample_s = parameters.sensors.clock.sample_s();
    let start_s = -(before as f64) * sample_s;
    let mut rig = Rig::new(parameters, seed, start_s)?;
    let total = before + frames(protocol.duration_s());
    let mut recorded = Recorded {
        name: run.name.clone(),
        rate_hz,
        rows: Vec::with_capacity(total),
        truth: Truth { start_s, sample_s, rows: Vec::with_capacity(total) },
    };
    // Driven pressures begin where the servo left them; sealed muscles are sealed before.
    let driven = !protocol.pressure.is_empty();
    for frame in 0..total {
        // The controller counts on its own clock.
        let time_s = (frame as f64 - before as f64) / rate_hz;
        let pressure = if frame < idle {
            PressureCommand::Sealed
        } else if frame < before {
            let inflating = frame < idle + inflate || driven;
            if inflating { PressureCommand::Servo(run.start_psi) } else { PressureCommand::Sealed }
        } else {
            protocol.targets_psi(time_s).map_or(PressureCommand::Sealed, PressureCommand::Servo)
        };
        let current_a = if frame < before { 0.0 } else { protocol.current_a(time_s, seed) };
        let mut made = rig.tick(&Command { current_a, pressure });
        if frame < idle {
            made.row.command = 0.0;
            made.row.sync = false;
        }
        if !made.is_finite() {
            return Err(RigError::Diverged { name: run.name.clone(), time_s });
        }
        recorded.rows.push(made.row);
        recorded.truth.rows.push(made.truth);
    }
    Ok(recorded)
}
