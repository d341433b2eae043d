use super::{LowPass, RawLogOptions, gradient, refilter};
use crate::error::DataError;
use crate::formats::raw_log::RawLog;
use crate::recording::{Recording, SealedReading, split_at_gaps};

/// Turns a raw log into recordings: one, or one for each stretch between gaps of the frame counter.
///
/// # Errors
/// [`DataError`] if the log ends before the excitation starts, an option makes no sense for it, or
/// what remains is no valid recording.
pub fn recordings_from_raw_log(
    log: &RawLog,
    options: &RawLogOptions,
) -> Result<Vec<Recording>, DataError> {
    let path = &log.path;
    let rows = log.len();
    let rate = options.frame_rate_hz.or(log.frame_rate_hz).unwrap_or(1000.0);
    if !(rate.is_finite() && rate > 0.0) {
        return Err(DataError::file(path, format!("a frame rate of {rate} Hz is not positive")));
    }
    let mut recording = Recording::empty(path);
    let (start, found) = excitation_start(log.command(), options);
    if start >= rows {
        return Err(DataError::file(
            path,
            format!(
                "the log has {rows} rows, but the excitation is looked for from row \
                 {} on; lower `search_from_row` to read a short log",
                options.search_from_row
            ),
        ));
    }
    if !found {
        recording.notes.push(format!(
            "no excitation found (|gradient(u)| never exceeds {}); the recording starts at row {start}",
            options.excitation_threshold
        ));
    }

    let kpa = |psi: f64| psi * options.kpa_per_psi + options.atmosphere_kpa;
    let mm_per_deg = options.displacement_mm_per_deg();
    let mn_per_a = options.force_mn_per_a();
    let before = start.saturating_sub(options.sealed_rows)..start;
    if before.is_empty() {
        recording.notes.push("no rows before the excitation: no sealed reading".into());
    } else {
        let mean =
            |values: &[f64]| values[before.clone()].iter().sum::<f64>() / before.len() as f64;
        recording.sealed = Some(SealedReading {
            displacement_mm: mean(log.angle_deg()) * mm_per_deg,
            pressure_flexor_kpa: kpa(mean(log.pressure_flexor_psi())),
            pressure_extensor_kpa: kpa(mean(log.pressure_extensor_psi())),
        });
    }

    let frames = &log.frame()[start..];
    let scaled =
        |values: &[f64], f: &dyn Fn(f64) -> f64| values[start..].iter().map(|&v| f(v)).collect();
    recording.time_s = frames.iter().map(|f| (f - frames[0]) / rate).collect();
    recording.displacement_mm = scaled(log.angle_deg(), &|v| v * mm_per_deg);
    recording.force_mn = scaled(log.current_a(), &|v| v * mn_per_a);
    recording.pressure_flexor_kpa = scaled(log.pressure_flexor_psi(), &kpa);
    recording.pressure_extensor_kpa = scaled(log.pressure_extensor_psi(), &kpa);
    recording.velocity_mm_s = vec![0.0; recording.len()];

    let shortest = LowPass::shortest();
    if recording.len() < shortest {
        return Err(DataError::file(
            path,
            format!(
                "{} row(s) remain after the start of the excitation (row {start}); at least \
                 {shortest} are needed to filter",
                recording.len()
            ),
        ));
    }
    split_at_gaps(recording, shortest)?
        .into_iter()
        .map(|part| {
            let part = refilter(part, options.cutoff_hz)?;
            part.validate()?;
            Ok(part)
        })
        .collect()
}

/// First row at or after `search_from_row` where the command changes, and whether there is one.
fn excitation_start(command: &[f64], options: &RawLogOptions) -> (usize, bool) {
    let from = options.search_from_row;
    let slopes = gradient(command, 1.0);
    let found = slopes.iter().skip(from).position(|g| g.abs() > options.excitation_threshold);
    (from + found.unwrap_or(0), found.is_some())
}
