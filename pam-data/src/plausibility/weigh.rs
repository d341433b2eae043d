//! The odds of every reading of the columns of pressure and displacement.

use super::balance::model_error;
use super::gas::{ChamberSlope, expected_slopes};
use super::readings::{DISPLACEMENT_UNITS, PressureUnit};
use super::sample::Sample;
use super::settings::PlausibilitySettings;
use pam_core::units::{ATMOSPHERE_KPA, KPA_PER_PSI};
use pam_core::{ForceModel, JointModel, SealedMasses};
use pam_numerics::statistics::median;
use std::f64::consts::PI;

/// Log odds that one impossible value (a pressure far outside its range, a displacement outside the muscle, a pressure
/// that answers in the wrong direction) costs a reading at most.
const IMPOSSIBLE: f64 = -50.0;
/// Log odds of a pressure that answers in the wrong direction.
const WRONG_DIRECTION: f64 = -20.0;
/// Log odds that one chamber's deviation from the others costs at most: a slack tendon is not a unit.
const ODD_CHAMBER: f64 = -6.0;
/// Log odds that the force of a useful model, and of an excellent one, can add: a fault of the joint can look like other
/// masses of air.
const FORCE_SUPPORT: [f64; 2] = [1.5, 4.0];
/// Relative error of the force below which a model is useful, and excellent.
const FORCE_ERRORS: [f64; 2] = [0.15, 0.03];
/// Log odds that given masses can add.
const MASS_SUPPORT: f64 = 8.0;
/// Relative softness of the bounds of pressure.
const LEVEL_SPREAD: f64 = 0.05;

/// A reading of all columns of pressure and displacement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reading {
    /// Index of the pressures' unit.
    pub(super) pressure: usize,
    /// Index of the displacement's unit.
    pub(super) displacement: usize,
    /// `true` if flexor and extensor, or the sign of x, are reversed.
    pub(super) reversed: bool,
}

impl Reading {
    /// The reading that the format states.
    pub(super) const STATED: Self = Self { pressure: 0, displacement: 0, reversed: false };

    /// Size of the displacement's unit, mm.
    pub(super) fn mm(&self) -> f64 {
        DISPLACEMENT_UNITS[self.displacement].1
    }
}

/// Data by which readings are weighed.
pub(super) struct Weights<'a, F> {
    pub(super) model: &'a JointModel<f64, F>,
    pub(super) units: &'a [PressureUnit],
    pub(super) settings: &'a PlausibilitySettings,
}

impl<F: ForceModel<f64>> Weights<'_, F> {
    /// All readings.
    pub(super) fn readings(&self) -> impl Iterator<Item = Reading> + use<'_, F> {
        (0..self.units.len()).flat_map(|pressure| {
            (0..DISPLACEMENT_UNITS.len()).flat_map(move |displacement| {
                [false, true].map(|reversed| Reading { pressure, displacement, reversed })
            })
        })
    }

    /// Log odds of a reading by prior, levels and gas law, up to a constant that is the same for all.
    fn gas_score(&self, samples: &[&Sample<'_>], reading: Reading) -> f64 {
        let unit = &self.units[reading.pressure];
        let s = self.settings;
        let mut sum = unit.prior;
        sum += if reading.displacement == 0 { 0.0 } else { s.unit_prior };
        sum += if reading.reversed { s.unit_prior } else { 0.0 };
        sum += samples.iter().map(|sample| self.levels(sample, reading)).sum::<f64>();
        sum + self.gas(samples, reading)
    }

    /// Log odds of a reading, up to a constant, with what force and masses say.
    pub(super) fn score(&self, samples: &[&Sample<'_>], reading: Reading) -> f64 {
        self.gas_score(samples, reading) + self.support(samples, reading)
    }

    /// The best reading of recordings that share one, and its log odds against the stated one.
    pub(super) fn best(&self, samples: &[&Sample<'_>]) -> (Reading, f64) {
        let scored: Vec<(Reading, f64)> =
            self.readings().map(|r| (r, self.gas_score(samples, r))).collect();
        let highest = scored.iter().fold(f64::NEG_INFINITY, |a, b| a.max(b.1));
        // Force and masses are asked only where they can decide; they cost most of the time.
        let open = scored.into_iter().filter(|(_, score)| *score > highest - 16.0);
        let stated = self.score(samples, Reading::STATED);
        open.map(|(r, score)| (r, score + self.support(samples, r) - stated))
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or((Reading::STATED, 0.0))
    }

    /// Log odds of a recording's values themselves: pressures and displacement within what a muscle does, pressures
    /// near the commanded ones.
    fn levels(&self, sample: &Sample<'_>, reading: Reading) -> f64 {
        let s = self.settings;
        let unit = &self.units[reading.pressure];
        let mut sum = 0.0;
        for value in &sample.pressures {
            let kpa = unit.reading.kpa(*value);
            sum += outside(kpa, s.lowest_kpa, s.highest_kpa);
        }
        let commanded = |order: [usize; 2]| -> f64 {
            let Some(command) = sample.recording.command_psi else { return 0.0 };
            let cost = |i: usize| {
                let kpa = unit.reading.kpa(sample.pressures[order[i]]);
                let psi = (kpa - ATMOSPHERE_KPA) / KPA_PER_PSI;
                // 1.5 psi and 8 % cover the servo's deadband, air that cooled, and biased sensors.
                let z = (psi - command[i]) / (1.5 + 0.08 * command[i]);
                -(0.5 * z * z).min(-IMPOSSIBLE)
            };
            cost(0) + cost(1)
        };
        sum += if reading.reversed {
            commanded([0, 1]).max(commanded([1, 0]))
        } else {
            commanded([0, 1])
        };
        let limit = self.model.geometry.displacement_limit_mm(self.model.physical().deformation);
        sum + outside(sample.largest_x * reading.mm(), 0.0, limit)
    }

    /// Log ratios of measured over isothermal change of pressure, one per chamber that follows the motion; the number of
    /// chambers that answer in the wrong direction.
    pub(super) fn log_ratios(
        &self,
        samples: &[&Sample<'_>],
        reading: Reading,
    ) -> (Vec<[f64; 2]>, usize) {
        let mm = reading.mm();
        let mut ratios = Vec::new();
        let mut wrong = 0;
        for sample in samples {
            // Swapped muscles at x answer as muscles in their places at −x.
            let x = sample.middle_x * mm;
            let expected = expected_slopes(self.model, if reading.reversed { -x } else { x });
            let slopes = &sample.slopes[reading.pressure];
            // A delay of more than a quarter of a period reverses the sign of the slope, which then reveals nothing.
            let longest = sample.rate_per_s * self.settings.longest_delay_s;
            let is_turned = |s: &ChamberSlope| {
                s.phase > self.settings.largest_phase_rad && PI - s.phase <= longest
            };
            if slopes.iter().flatten().any(is_turned) {
                continue;
            }
            // Pressures that move together say that columns are mixed up, and nothing of units.
            if let [Some(flexor), Some(extensor)] = slopes
                && flexor.ratio * extensor.ratio > 0.0
                && flexor.r2.min(extensor.r2) >= self.settings.least_r2
            {
                wrong += 1;
                continue;
            }
            for (slope, expected) in slopes.iter().zip(expected) {
                let Some(slope) = slope.filter(|c| c.r2 >= self.settings.least_r2) else {
                    continue;
                };
                let ratio = slope.ratio / (mm * expected);
                if (ratio < 0.0) != reading.reversed {
                    wrong += 1;
                }
                ratios.push([
                    log_ratio(ratio.abs(), slope.phase.min(longest)),
                    0.5 * (1.0 - slope.r2),
                ]);
            }
        }
        (ratios, wrong)
    }

    /// Log odds of the gas law: a common ratio near 1, and chambers that agree.
    fn gas(&self, samples: &[&Sample<'_>], reading: Reading) -> f64 {
        let s = self.settings;
        let (ratios, wrong) = self.log_ratios(samples, reading);
        if ratios.is_empty() {
            return 0.0;
        }
        let common = median(&ratios.iter().map(|r| r[0]).collect::<Vec<_>>());
        let density = |spread: f64| (-0.5 * (common / spread).powi(2)).exp() / spread;
        let fastest = samples.iter().fold(0.0, |a: f64, sample| a.max(sample.rate_per_s));
        let spread = s.gas_spread.hypot(warming(fastest, s));
        let at_one = (1.0 - s.faulty_gas_share) / spread + s.faulty_gas_share / s.faulty_gas_spread;
        let sound = (1.0 - s.faulty_gas_share) * density(spread);
        let faulty = s.faulty_gas_share * density(s.faulty_gas_spread);
        let level = ((sound + faulty) / at_one).ln().max(IMPOSSIBLE);
        let odd: f64 = ratios
            .iter()
            .map(|[ratio, error]| {
                let spread = s.chamber_spread.hypot(*error);
                (-0.5 * ((ratio - common) / spread).powi(2)).max(ODD_CHAMBER)
            })
            .sum();
        level + odd + wrong as f64 * WRONG_DIRECTION
    }

    /// Log odds, from force and given masses, of gauge pressures against absolute ones in the same unit; 0 for others. Masses
    /// can only speak for it: if they were computed from the same pressures they agree with them whatever their unit.
    fn support(&self, samples: &[&Sample<'_>], reading: Reading) -> f64 {
        let unit = &self.units[reading.pressure];
        let absolute =
            |u: &PressureUnit| u.unit == unit.unit && u.in_file == unit.in_file && !u.gauge;
        // The first unit is the stated one.
        let stated = unit.is_gauge_kpa().then_some(0);
        let twin = self.units.iter().position(absolute).or(stated);
        let Some(twin) = twin.filter(|_| unit.gauge) else {
            return 0.0;
        };
        let twin = Reading { pressure: twin, ..reading };
        let (mut force, mut masses): (f64, f64) = (0.0, 0.0);
        let mut best = f64::INFINITY;
        let every = samples.len().div_ceil(self.settings.asked_recordings).max(1);
        for sample in samples.iter().step_by(every) {
            let error = |reading| model_error(self, sample, reading);
            if let (Some(stated), Some(other)) = (error(twin), error(reading)) {
                best = best.min(stated).min(other);
                // Twenty independent pieces of a recording.
                if stated.min(other) < FORCE_ERRORS[0] {
                    force += 20.0 * (stated / other).ln();
                }
            }
            if let (Some(stated), Some(other)) =
                (self.mass_ratios(sample, twin), self.mass_ratios(sample, reading))
            {
                let off = |r: [f64; 2]| r.iter().map(|v| (v.ln() / 0.1).powi(2)).sum::<f64>();
                masses += 0.5 * (off(stated) - off(other));
            }
        }
        let most = FORCE_SUPPORT[usize::from(best < FORCE_ERRORS[1])];
        force.clamp(-most, most) + masses.clamp(0.0, MASS_SUPPORT)
    }

    /// Given masses over those of the gas law, flexor and extensor.
    pub(super) fn mass_ratios(&self, sample: &Sample<'_>, reading: Reading) -> Option<[f64; 2]> {
        let given = sample.given?;
        let law = self.gas_masses(sample, reading)?;
        Some([given.flexor_g / law.flexor_g, given.extensor_g / law.extensor_g])
    }

    /// Masses of the gas law under a reading; `None` if it makes them impossible.
    pub(super) fn gas_masses(&self, sample: &Sample<'_>, reading: Reading) -> Option<SealedMasses> {
        let rest = sample.recording.reading_at_rest();
        let unit = &self.units[reading.pressure].reading;
        let kpa = [rest.pressure_flexor_kpa, rest.pressure_extensor_kpa].map(|p| unit.kpa(p));
        let m = self.model.gas_law_masses(rest.displacement_mm * reading.mm(), kpa);
        SealedMasses::new(m.flexor_g, m.extensor_g).ok()
    }
}

/// Logarithm of the change of pressure relative to the gas law. A pressure that lags by the phase `late` (rad) leaves it uncertain:
/// [`chamber_slope`](super::gas::chamber_slope) is exact for a first-order lag and overestimates the slope by `1/cos φ` for a pure delay.
/// The value nearest to zero between the two is taken.
fn log_ratio(ratio: f64, late: f64) -> f64 {
    let behind_delay = (ratio * late.cos()).ln();
    ratio.ln().min(behind_delay.max(0.0))
}

/// Log odds of a value that should lie between two bounds, which are a little soft.
fn outside(value: f64, low: f64, high: f64) -> f64 {
    let z = if value <= 0.0 && low > 0.0 {
        return IMPOSSIBLE;
    } else if value < low {
        (low / value).ln() / LEVEL_SPREAD
    } else if value > high {
        (value / high).ln() / LEVEL_SPREAD
    } else {
        0.0
    };
    (-0.5 * z * z).max(IMPOSSIBLE)
}

/// How much warming air may raise the change of pressure: nothing in slow motion, `warming_spread` in motion that is fast
/// against the time in which the air takes the temperature of the wall, `(ωτ)²/(1 + (ωτ)²)` between.
fn warming(rate_per_s: f64, s: &PlausibilitySettings) -> f64 {
    let squared = (rate_per_s * s.warming_time_s).powi(2);
    s.warming_spread * squared / (1.0 + squared)
}
