use crate::error::ControlError;
use crate::execution::{Pulse, PulseRecord, PulseShape, SAMPLE_S};
use pam_core::units::MN_PER_N;
use pam_data::Recording;

/// Smallest force that is a pulse, as a share of the recording's largest.
const SHARE: f64 = 0.5;
/// Time without force before a pulse, s.
const QUIET_S: f64 = 0.05;

/// The pulses of force in a recording at 1 kHz: wherever the force rises past half of the recording's
/// largest after 50 ms below a tenth of it. The commanded stiffness is not known and is NaN.
///
/// # Errors
/// [`ControlError::Insufficient`] if the recording is not sampled at 1 kHz or holds no pulse.
pub fn pulses_in_recording(
    recording: &Recording,
    shape: &PulseShape,
) -> Result<Vec<PulseRecord>, ControlError> {
    let insufficient =
        |why: &str| ControlError::Insufficient(format!("recording {}: {why}", recording.name));
    let steps = recording.time_s.windows(2).map(|t| t[1] - t[0]);
    if steps.clone().any(|s| (s - SAMPLE_S).abs() > 0.2 * SAMPLE_S) {
        return Err(insufficient("pulses are identified at 1 kHz; resample it"));
    }
    let force_n: Vec<f64> = recording.force_mn.iter().map(|f| f / MN_PER_N).collect();
    let largest = force_n.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
    let samples = |s: f64| (s / SAMPLE_S).round() as usize;
    let (quiet, before, window) =
        (samples(QUIET_S), samples(shape.before_s), samples(shape.window_s));
    let mut records = Vec::new();
    let mut k = quiet.max(before);
    while largest > 0.0 && k + window < force_n.len() {
        let rises = force_n[k].abs() >= SHARE * largest
            && force_n[k - quiet..k].iter().all(|f| f.abs() < 0.1 * largest);
        if rises {
            let range = k - before..k + window;
            records.push(PulseRecord {
                pulse: Pulse {
                    time_s: recording.time_s[k],
                    direction: force_n[k].signum(),
                    place: "recorded",
                },
                commanded_n_mm: f64::NAN,
                displacement_mm: recording.displacement_mm[range.clone()].to_vec(),
                force_n: force_n[range].to_vec(),
                pressures_kpa: [
                    recording.pressure_flexor_kpa[k],
                    recording.pressure_extensor_kpa[k],
                ],
                start: before,
            });
            k += window;
        } else {
            k += 1;
        }
    }
    if records.is_empty() {
        return Err(insufficient("no pulse of force after 50 ms without is in it"));
    }
    Ok(records)
}
