use super::{Air, Commands, Joint, JointCommand, SAMPLE_S};

/// Motion of a joint under commands, one value per sample.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Followed {
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Wanted displacement, mm.
    pub wanted_mm: Vec<f64>,
    /// Measured displacement, mm.
    pub measured_mm: Vec<f64>,
    /// Commanded pressures, kPa absolute.
    pub commanded_kpa: Vec<[f64; 2]>,
    /// Measured pressures, kPa absolute.
    pub pressures_kpa: Vec<[f64; 2]>,
}

impl Followed {
    /// Root mean square of wanted less measured displacement from a time on, mm.
    #[must_use]
    pub fn rmse_mm(&self, from_s: f64) -> f64 {
        let errors = self
            .time_s
            .iter()
            .zip(self.wanted_mm.iter().zip(&self.measured_mm))
            .filter(|(t, _)| **t >= from_s)
            .map(|(_, (w, m))| (w - m).powi(2));
        let (sum, count) = errors.fold((0.0, 0), |(s, n), e| (s + e, n + 1));
        (sum / f64::from(count.max(1))).sqrt()
    }
}

/// Holds the first pressures for `settle_s`, then follows the commands to their end with the joint's own
/// pressure servo. `force_n` is the external force at a time.
pub fn follow(
    joint: &mut impl Joint,
    commands: &Commands,
    settle_s: f64,
    mut force_n: impl FnMut(f64) -> f64,
) -> Followed {
    let first = Air::Servo(commands.pressures_kpa(0.0));
    for _ in 0..(settle_s / SAMPLE_S).round() as usize {
        joint.tick(&JointCommand { force_n: 0.0, air: first });
    }
    let mut followed = Followed::default();
    for k in 0..=(commands.duration_s() / SAMPLE_S).round() as usize {
        let time_s = k as f64 * SAMPLE_S;
        let pressures = commands.pressures_kpa(time_s);
        let command = JointCommand { force_n: force_n(time_s), air: Air::Servo(pressures) };
        let reading = joint.tick(&command);
        followed.time_s.push(time_s);
        followed.wanted_mm.push(commands.displacement_mm(time_s));
        followed.measured_mm.push(reading.displacement_mm);
        followed.commanded_kpa.push(pressures);
        followed.pressures_kpa.push(reading.pressures_kpa);
    }
    followed
}
