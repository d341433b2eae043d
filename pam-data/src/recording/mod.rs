//! One run of the joint with sealed muscles.

mod channel;
mod gaps;
mod origin;

pub use channel::Channel;
pub use gaps::{contiguous_ranges, median_step_s, split_at_gaps};
pub use origin::{LowPassed, SealedReading, StatedPressure};

use crate::error::DataError;
use crate::rig_file::RigFile;
use pam_core::SealedMasses;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// One run of the joint: six columns of equal length, and what is known of their origin.
///
/// ```
/// use pam_data::{Channel, Recording};
///
/// let time_s = (0..1000).map(|k| 1e-3 * f64::from(k)).collect();
/// let recording = Recording::at_rest("a", time_s, [412.0, 412.0]) // kPa absolute
///     .with_force(|t| 1e5 * (6.28 * t).sin()); // mN
/// assert_eq!(recording.len(), 1000);
/// assert_eq!(recording.channel(Channel::Pf)[0], 412.0);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Name, from the file; parts of a run with gaps are numbered.
    pub name: String,
    /// The file it came from.
    pub source: PathBuf,
    /// Time, s; increasing. Need not begin at zero.
    pub time_s: Vec<f64>,
    /// Tendon displacement x, mm.
    pub displacement_mm: Vec<f64>,
    /// Velocity ẋ, mm/s.
    pub velocity_mm_s: Vec<f64>,
    /// Flexor pressure, kPa absolute.
    pub pressure_flexor_kpa: Vec<f64>,
    /// Extensor pressure, kPa absolute.
    pub pressure_extensor_kpa: Vec<f64>,
    /// External force F_e, mN.
    pub force_mn: Vec<f64>,
    /// Sealed masses that the file itself gives.
    pub given_masses: Option<SealedMasses>,
    /// The reading at rest after the valves closed, if the file has one.
    pub sealed: Option<SealedReading>,
    /// Commanded gauge pressures of flexor and extensor, psi, from the name `nn_FFEE`.
    pub command_psi: Option<[f64; 2]>,
    /// The rig it was recorded on, if a rig file or the recording's own file says it: sizes, air and limits, without the
    /// columns of files.
    pub rig: Option<Arc<RigFile>>,
    /// How the file states the pressures, if it was read by a rig file.
    pub pressure_in_file: Option<StatedPressure>,
    /// The low-pass between sensors and columns, where it is known.
    pub low_passed: LowPassed,
    /// Processing of the data between file and recording.
    pub preprocessing: String,
    /// Notes for the reader: gaps, decisions, doubts.
    pub notes: Vec<String>,
}

impl Recording {
    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// True if there are no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// The measured values of a channel.
    #[must_use]
    pub fn channel(&self, channel: Channel) -> &[f64] {
        match channel {
            Channel::X => &self.displacement_mm,
            Channel::V => &self.velocity_mm_s,
            Channel::Pf => &self.pressure_flexor_kpa,
            Channel::Pe => &self.pressure_extensor_kpa,
        }
    }

    /// Steps of the sensors of the channels in the order of the state, in their units: those of the samples, or of the ones
    /// before the filter. 0 where none are seen ([`resolution`](pam_numerics::statistics::resolution)).
    #[must_use]
    pub fn resolution(&self) -> [f64; 4] {
        let mut steps = self.low_passed.resolution;
        for ((step, cutoff), c) in steps.iter_mut().zip(self.low_passed.cutoff_hz).zip(Channel::ALL)
        {
            if cutoff.is_none() {
                *step = pam_numerics::statistics::resolution(self.channel(c));
            }
        }
        steps
    }

    /// The measured state `[x, ẋ, P_f, P_e]` of the first sample, from which predictions start.
    #[must_use]
    pub fn initial_state(&self) -> [f64; 4] {
        Channel::ALL.map(|c| self.channel(c)[0])
    }

    /// First and last time, s.
    #[must_use]
    pub fn span_s(&self) -> (f64, f64) {
        (self.time_s[0], self.time_s[self.len() - 1])
    }

    /// The reading from which masses are computed: the sealed one, or the first sample.
    #[must_use]
    pub fn reading_at_rest(&self) -> SealedReading {
        self.sealed.unwrap_or_else(|| {
            let [x, _, pf, pe] = self.initial_state();
            SealedReading { displacement_mm: x, pressure_flexor_kpa: pf, pressure_extensor_kpa: pe }
        })
    }

    /// Checks what every recording must be: at least two samples, columns of equal length, finite
    /// numbers, increasing times, positive pressures and masses.
    ///
    /// # Errors
    /// [`DataError::File`] naming what is wrong and at which sample.
    pub fn validate(&self) -> Result<(), DataError> {
        let fail = |message: String| Err(DataError::file(&self.source, message));
        if self.len() < 2 {
            return fail(format!(
                "recording `{}` has {} sample(s); at least two are needed",
                self.name,
                self.len()
            ));
        }
        let before = self.low_passed.force_mn.as_ref().unwrap_or(&self.force_mn);
        let columns = [
            ("time_s", &self.time_s),
            ("displacement_mm", &self.displacement_mm),
            ("velocity_mm_s", &self.velocity_mm_s),
            ("pressure_flexor_kpa", &self.pressure_flexor_kpa),
            ("pressure_extensor_kpa", &self.pressure_extensor_kpa),
            ("force_n", &self.force_mn),
            ("force_n before the filter", before),
        ];
        for (name, values) in columns {
            if values.len() != self.len() {
                return fail(format!(
                    "`{name}` has {} values, `time_s` has {}",
                    values.len(),
                    self.len()
                ));
            }
            if let Some(i) = values.iter().position(|v| !v.is_finite()) {
                return fail(format!("`{name}` is {} at sample {i}", values[i]));
            }
        }
        if let Some(i) = self.time_s.windows(2).position(|w| w[1] <= w[0]) {
            return fail(format!(
                "time does not increase at sample {}: {} s after {} s (a repeated frame?)",
                i + 1,
                self.time_s[i + 1],
                self.time_s[i]
            ));
        }
        for (name, values) in &columns[3..5] {
            if let Some(i) = values.iter().position(|&v| v <= 0.0) {
                return fail(format!(
                    "`{name}` is {} kPa at sample {i}; pressures are absolute and positive. If these are gauge \
                     pressures, read them as such: --pressure gauge, or reference = \"gauge\" in a rig file",
                    values[i]
                ));
            }
        }
        if let Some(m) = &self.given_masses {
            SealedMasses::new(m.flexor_g, m.extensor_g)
                .map_err(|e| DataError::file(&self.source, e.to_string()))?;
        }
        Ok(())
    }

    /// The samples `range` as a recording of its own.
    #[must_use]
    pub fn slice(&self, range: std::ops::Range<usize>) -> Self {
        self.with_samples(|v| v[range.clone()].to_vec())
    }

    /// Every `stride`-th sample, from the first one on.
    ///
    /// # Panics
    /// If the stride is 0.
    #[must_use]
    pub fn every(&self, stride: usize) -> Self {
        self.with_samples(|v| v.iter().step_by(stride).copied().collect())
    }

    /// The same recording with some of the samples of every channel.
    fn with_samples(&self, cut: impl Fn(&[f64]) -> Vec<f64>) -> Self {
        Self {
            time_s: cut(&self.time_s),
            displacement_mm: cut(&self.displacement_mm),
            velocity_mm_s: cut(&self.velocity_mm_s),
            pressure_flexor_kpa: cut(&self.pressure_flexor_kpa),
            pressure_extensor_kpa: cut(&self.pressure_extensor_kpa),
            force_mn: cut(&self.force_mn),
            low_passed: LowPassed {
                cutoff_hz: self.low_passed.cutoff_hz,
                force_mn: self.low_passed.force_mn.as_deref().map(&cut),
                resolution: self.low_passed.resolution,
            },
            ..self.without_samples()
        }
    }

    /// A recording without samples that keeps what is known of this one.
    #[must_use]
    pub fn without_samples(&self) -> Self {
        Self {
            name: self.name.clone(),
            source: self.source.clone(),
            given_masses: self.given_masses,
            sealed: self.sealed,
            command_psi: self.command_psi,
            rig: self.rig.clone(),
            pressure_in_file: self.pressure_in_file,
            preprocessing: self.preprocessing.clone(),
            notes: self.notes.clone(),
            ..Self::empty(&self.source)
        }
    }

    /// A recording to predict along: at rest at x = 0 under these pressures (flexor, extensor; kPa
    /// absolute) at all times (s), without an external force.
    ///
    /// ```
    /// use pam_data::Recording;
    /// let time_s = (0..100).map(|k| 0.01 * f64::from(k)).collect();
    /// let command = Recording::at_rest("sine", time_s, [412.0, 412.0]).with_force(|t| 100e3 * t.sin());
    /// command.validate()?;
    /// assert_eq!(command.force_mn[50], 100e3 * 0.5_f64.sin());
    /// # Ok::<(), pam_data::DataError>(())
    /// ```
    #[must_use]
    pub fn at_rest(name: &str, time_s: Vec<f64>, pressures_kpa: [f64; 2]) -> Self {
        let constant = |value: f64| vec![value; time_s.len()];
        Self {
            name: name.to_owned(),
            displacement_mm: constant(0.0),
            velocity_mm_s: constant(0.0),
            pressure_flexor_kpa: constant(pressures_kpa[0]),
            pressure_extensor_kpa: constant(pressures_kpa[1]),
            force_mn: constant(0.0),
            time_s,
            ..Self::empty(Path::new(name))
        }
    }

    /// The same under another external force (mN), a function of time (s).
    #[must_use]
    pub fn with_force(mut self, force_mn: impl Fn(f64) -> f64) -> Self {
        self.force_mn = self.time_s.iter().map(|&t| force_mn(t)).collect();
        self
    }

    /// A recording without samples, named after its file.
    #[must_use]
    pub fn empty(source: impl AsRef<Path>) -> Self {
        Self::empty_at(source.as_ref())
    }

    /// One instance, whatever the path is given as.
    fn empty_at(source: &Path) -> Self {
        let name = source.file_stem().map_or_else(
            || source.display().to_string(),
            |stem| stem.to_string_lossy().into_owned(),
        );
        Self {
            command_psi: command_from_name(&name),
            name,
            source: source.to_owned(),
            time_s: Vec::new(),
            displacement_mm: Vec::new(),
            velocity_mm_s: Vec::new(),
            pressure_flexor_kpa: Vec::new(),
            pressure_extensor_kpa: Vec::new(),
            force_mn: Vec::new(),
            given_masses: None,
            sealed: None,
            rig: None,
            pressure_in_file: None,
            low_passed: LowPassed::default(),
            preprocessing: String::new(),
            notes: Vec::new(),
        }
    }
}

/// The commanded gauge pressures (psi) in a name like `nn_3060`.
fn command_from_name(name: &str) -> Option<[f64; 2]> {
    let code = name.strip_prefix("nn_")?;
    let part = |range: std::ops::Range<usize>| code.get(range)?.parse::<u8>().ok().map(f64::from);
    Some([part(0..2)?, part(2..4)?])
}
