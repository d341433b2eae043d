use super::{Air, Commands, Joint, JointCommand, SAMPLE_S};
use serde::Serialize;

/// The shape of a perturbation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PulseShape {
    /// Force, N.
    pub force_n: f64,
    /// Length, s (150 ms in Wang and Realmuto 2026, section IV-C).
    pub width_s: f64,
    /// Time from its start on in which the response counts, s; the valves stay shut so long.
    pub window_s: f64,
    /// Time before it from which the motion at its start is estimated, s.
    pub before_s: f64,
}

impl Default for PulseShape {
    fn default() -> Self {
        Self { force_n: 90.0, width_s: 0.15, window_s: 0.15, before_s: 0.06 }
    }
}

/// A perturbation on its way.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Pulse {
    /// When it starts, s.
    pub time_s: f64,
    /// Along +x (1) or against it (−1).
    pub direction: f64,
    /// Where in the motion.
    pub place: &'static str,
}

/// Measurement around a perturbation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PulseRecord {
    /// The perturbation.
    pub pulse: Pulse,
    /// Wanted stiffness at its start, N/mm.
    pub commanded_n_mm: f64,
    /// Measured displacements from `before_s` before its start, one a millisecond, mm.
    pub displacement_mm: Vec<f64>,
    /// Forces along +x in the same samples, N.
    pub force_n: Vec<f64>,
    /// Measured pressures at the start, kPa absolute.
    pub pressures_kpa: [f64; 2],
    /// Index of the start.
    pub start: usize,
}

impl PulseRecord {
    /// Largest displacement from that at the start, mm.
    #[must_use]
    pub fn peak_mm(&self) -> f64 {
        let from = self.displacement_mm[self.start];
        self.displacement_mm[self.start..].iter().fold(0.0, |m, x| m.max((x - from).abs()))
    }
}

/// Follows the commands and perturbs the joint at the given times, which must increase. During a
/// perturbation the valves are shut; the table's clock runs on.
pub fn perturb(
    joint: &mut impl Joint,
    commands: &Commands,
    settle_s: f64,
    pulses: &[Pulse],
    shape: &PulseShape,
) -> Vec<PulseRecord> {
    let first = Air::Servo(commands.pressures_kpa(0.0));
    for _ in 0..(settle_s / SAMPLE_S).round() as usize {
        joint.tick(&JointCommand { force_n: 0.0, air: first });
    }
    let samples = |s: f64| (s / SAMPLE_S).round() as usize;
    let (before, width, window) =
        (samples(shape.before_s), samples(shape.width_s), samples(shape.window_s));
    let mut records: Vec<PulseRecord> = pulses
        .iter()
        .map(|&pulse| PulseRecord {
            pulse,
            commanded_n_mm: commands.stiffness_n_mm(pulse.time_s),
            displacement_mm: Vec::with_capacity(before + window),
            force_n: Vec::with_capacity(before + window),
            pressures_kpa: [f64::NAN; 2],
            start: before,
        })
        .collect();
    for k in 0..=samples(commands.duration_s()) {
        let time_s = k as f64 * SAMPLE_S;
        let mut force_n = 0.0;
        let mut air = Air::Servo(commands.pressures_kpa(time_s));
        for pulse in pulses {
            let start = samples(pulse.time_s);
            if (start..start + window).contains(&k) {
                air = Air::Sealed;
                if k < start + width {
                    force_n = pulse.direction * shape.force_n;
                }
            }
        }
        let reading = joint.tick(&JointCommand { force_n, air });
        for record in &mut records {
            let start = samples(record.pulse.time_s);
            if (start.saturating_sub(before)..start + window).contains(&k) {
                record.displacement_mm.push(reading.displacement_mm);
                record.force_n.push(force_n);
                if k == start {
                    record.pressures_kpa = reading.pressures_kpa;
                    record.start = record.displacement_mm.len() - 1;
                }
            }
        }
    }
    records.retain(|r| r.displacement_mm.len() > r.start + window / 2);
    records
}
