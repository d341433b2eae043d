use super::{LowPass, gradient, gradient_at_times};
use crate::error::DataError;
use crate::recording::{LowPassed, Recording, median_step_s};

/// Cutoffs of the zero-phase low-pass of each channel, Hz; `None` where it is not filtered.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cutoffs {
    /// Of the displacement.
    pub displacement_hz: Option<f64>,
    /// Of both pressures.
    pub pressure_hz: Option<f64>,
    /// Of the force.
    pub force_hz: Option<f64>,
}

impl Cutoffs {
    /// One cutoff for all channels; 0 for none.
    #[must_use]
    pub fn all(cutoff_hz: f64) -> Self {
        let cutoff = (cutoff_hz != 0.0).then_some(cutoff_hz);
        Self { displacement_hz: cutoff, pressure_hz: cutoff, force_hz: cutoff }
    }

    /// Of x, ẋ (as the derivative of the filtered x), P_f, P_e.
    fn of_state(&self) -> [Option<f64>; 4] {
        [self.displacement_hz, self.displacement_hz, self.pressure_hz, self.pressure_hz]
    }

    fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// In words.
    fn describe(&self) -> String {
        if self.is_none() {
            return "unfiltered".into();
        }
        let named = [
            ("x", self.displacement_hz),
            ("force", self.force_hz),
            ("pressures", self.pressure_hz),
        ];
        if let Some(cutoff) = self.displacement_hz
            && *self == Self::all(cutoff)
        {
            return format!(
                "x, force and pressures filtered forward and back by a first-order Butterworth of {cutoff} Hz"
            );
        }
        let parts: Vec<String> =
            named.iter().filter_map(|(n, c)| c.map(|c| format!("{n} at {c} Hz"))).collect();
        format!("{} filtered forward and back by a first-order Butterworth", parts.join(", "))
    }
}

fn filter_for(recording: &Recording, cutoff_hz: f64) -> Result<LowPass, DataError> {
    let rate = 1.0 / median_step_s(&recording.time_s);
    let filter = LowPass::new(cutoff_hz, rate).ok_or_else(|| {
        DataError::file(
            &recording.source,
            format!(
                "a cutoff of {cutoff_hz} Hz needs data sampled faster than {} Hz, this is \
                 sampled at {rate:.3} Hz",
                2.0 * cutoff_hz,
            ),
        )
    })?;
    if recording.len() < LowPass::shortest() {
        return Err(DataError::file(
            &recording.source,
            format!("{} samples are too few to filter", recording.len()),
        ));
    }
    Ok(filter)
}

/// Filters displacement, force and pressures forward and back. The velocity stays.
///
/// # Errors
/// [`DataError::File`] if the recording is too short or a cutoff is not below half the rate.
pub fn filtered(mut recording: Recording, cutoffs: &Cutoffs) -> Result<Recording, DataError> {
    let before = recording.force_mn.clone();
    let seen = recording.resolution();
    let channels =
        [cutoffs.displacement_hz, cutoffs.force_hz, cutoffs.pressure_hz, cutoffs.pressure_hz];
    let filters =
        channels.map(|cutoff| cutoff.map(|cutoff| filter_for(&recording, cutoff)).transpose());
    let columns = [
        &mut recording.displacement_mm,
        &mut recording.force_mn,
        &mut recording.pressure_flexor_kpa,
        &mut recording.pressure_extensor_kpa,
    ];
    for (column, filter) in columns.into_iter().zip(filters) {
        if let Some(filter) = filter? {
            *column = filter.forward_backward(column);
        }
    }
    let mut recording = low_passed(recording, cutoffs);
    recording.low_passed.force_mn = cutoffs.force_hz.map(|_| before);
    recording.low_passed.resolution = seen;
    Ok(recording)
}

/// A recording whose channels have gone through these filters already.
#[must_use]
pub fn low_passed(mut recording: Recording, cutoffs: &Cutoffs) -> Recording {
    recording.low_passed = LowPassed { cutoff_hz: cutoffs.of_state(), ..Default::default() };
    recording.preprocessing = cutoffs.describe();
    recording
}

/// The recording with the gradient of its displacement as velocity. A displacement that is not filtered goes through a
/// low-pass of `cutoff_hz` first, if that is given; the displacement itself stays.
///
/// # Errors
/// [`DataError::File`] if the recording is too short or the cutoff is not below half the rate.
pub fn derivative_of(
    mut recording: Recording,
    cutoff_hz: Option<f64>,
) -> Result<Recording, DataError> {
    let of_x = recording.low_passed.cutoff_hz[0];
    let step = median_step_s(&recording.time_s);
    // A slower recording has no noise above the cutoff; a few samples cannot be filtered.
    let long = recording.len() >= LowPass::shortest();
    let cutoff_hz = cutoff_hz.filter(|c| long && of_x.is_none() && *c < 0.5 / step);
    let smooth = match cutoff_hz {
        Some(cutoff) => {
            filter_for(&recording, cutoff)?.forward_backward(&recording.displacement_mm)
        }
        None => recording.displacement_mm.clone(),
    };
    let uniform = recording.time_s.windows(2).all(|w| ((w[1] - w[0]) / step - 1.0).abs() < 1e-6);
    recording.velocity_mm_s = if uniform {
        gradient(&smooth, step)
    } else {
        gradient_at_times(&smooth, &recording.time_s)
    };
    recording.low_passed.cutoff_hz[1] = of_x.or(cutoff_hz);
    recording.preprocessing += &match (of_x, cutoff_hz) {
        (Some(_), _) => "; v = gradient of filtered x".to_owned(),
        (None, Some(cutoff)) => format!("; v = gradient of x filtered at {cutoff} Hz"),
        (None, None) => "; v = gradient of x".to_owned(),
    };
    Ok(recording)
}

/// Filters displacement, force and pressures forward and back and takes the velocity anew from the
/// filtered displacement. A cutoff of zero takes the velocity without filtering.
///
/// # Errors
/// [`DataError::File`] if the recording is too short or the cutoff is not below half the rate.
pub fn refilter(recording: Recording, cutoff_hz: f64) -> Result<Recording, DataError> {
    derivative_of(filtered(recording, &Cutoffs::all(cutoff_hz))?, None)
}
