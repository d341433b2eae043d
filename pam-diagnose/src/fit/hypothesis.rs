//! What is fitted.

use pam_effects::effects::{AnyEffect, EffectScalar, ParameterInfo};
use pam_effects::simulation::Nuisances;

/// Uncertain numbers that all recordings share.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Common {
    /// Logarithm of the factor on the model's mass.
    pub log_mass: f64,
    /// Logarithm of the factor on the model's deformation coefficient.
    pub log_deformation: f64,
    /// By how many of its samples the recorded force acts earlier than if each value held until the next: 0 is a
    /// force that is held, ½ a smooth one that was sampled. Half a sample at most, either way.
    pub lead_samples: f64,
}

impl Common {
    /// Number of values.
    pub const LEN: usize = 3;
    /// Values that the simulation is differentiated by; the lead behind them follows from the course in time.
    pub(super) const SIMULATED: usize = 2;
    /// Place of the lead among the values.
    pub(super) const LEAD: usize = Self::SIMULATED;
    /// The largest lead and lag. What goes beyond is a delay, and has to be named as one.
    const MOST_SAMPLES: f64 = 0.5;

    /// The values in order.
    #[must_use]
    pub fn values(&self) -> [f64; Self::LEN] {
        [self.log_mass, self.log_deformation, self.lead_samples]
    }

    /// From values in order, the lead kept inside its range.
    #[must_use]
    pub fn from_values(v: &[f64]) -> Self {
        let lead_samples = v[Self::LEAD].clamp(-Self::MOST_SAMPLES, Self::MOST_SAMPLES);
        Self { log_mass: v[0], log_deformation: v[1], lead_samples }
    }

    /// What is left to the end of the lead's range, if a change leads beyond it.
    pub(super) fn lead_left(&self, change: f64) -> Option<f64> {
        let end = Self::MOST_SAMPLES.copysign(change);
        ((self.lead_samples + change).abs() > Self::MOST_SAMPLES).then_some(end - self.lead_samples)
    }
}

/// Uncertain numbers of one recording, as deviations from what was measured.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Local {
    /// Displacement at the start, mm.
    pub start_mm: f64,
    /// Velocity at the start, mm/s.
    pub start_mm_s: f64,
    /// Logarithms of the factors on the sealed masses.
    pub log_air: [f64; 2],
    /// Offsets of the pressures, which start from one noisy sample, kPa.
    pub offset_kpa: [f64; 2],
}

impl Local {
    /// Number of values.
    pub const LEN: usize = 6;
    /// Values that enter the simulation; the offsets behind them are added to its result.
    pub const SIMULATED: usize = 4;

    /// The values in order.
    #[must_use]
    pub fn values(&self) -> [f64; Self::LEN] {
        let (m, p) = (self.log_air, self.offset_kpa);
        [self.start_mm, self.start_mm_s, m[0], m[1], p[0], p[1]]
    }

    /// From values in order.
    #[must_use]
    pub fn from_values(v: &[f64]) -> Self {
        Self { start_mm: v[0], start_mm_s: v[1], log_air: [v[2], v[3]], offset_kpa: [v[4], v[5]] }
    }
}

/// Effects with their values, and the uncertain numbers.
#[derive(Debug, Clone)]
pub struct Hypothesis<'e> {
    /// Effects; the first [`fixed`](Self::fixed) of them are not fitted.
    pub effects: Vec<&'e dyn AnyEffect>,
    /// Number of leading effects that stay as they are.
    pub fixed: usize,
    /// Parameters and switches of each effect in turn.
    pub values: Vec<f64>,
    /// Uncertain numbers of the model and of how its force is read.
    pub common: Common,
    /// Uncertain numbers of each trial.
    pub locals: Vec<Local>,
}

impl<'e> Hypothesis<'e> {
    /// The base model with effects that are not fitted, for a number of trials.
    #[must_use]
    pub fn base(fixed: &[(&'e dyn AnyEffect, Vec<f64>)], trials: usize) -> Self {
        Self {
            effects: fixed.iter().map(|f| f.0).collect(),
            fixed: fixed.len(),
            values: fixed.iter().flat_map(|f| f.1.iter().copied()).collect(),
            common: Common::default(),
            locals: vec![Local::default(); trials],
        }
    }

    /// The same with one more effect to be fitted.
    #[must_use]
    pub fn with(&self, effect: &'e dyn AnyEffect, values: &[f64]) -> Self {
        let mut more = self.clone();
        more.effects.push(effect);
        more.values.extend_from_slice(values);
        more
    }

    /// The same without the fitted effect at this place.
    #[must_use]
    pub fn without(&self, place: usize) -> Self {
        let mut less = self.clone();
        let at = self.fixed + place;
        let range = self.value_range(at);
        less.effects.remove(at);
        less.values.drain(range);
        less
    }

    /// Where the values of effect `at` lie.
    #[must_use]
    pub fn value_range(&self, at: usize) -> std::ops::Range<usize> {
        let first: usize = self.effects[..at].iter().map(|e| e.info().value_len()).sum();
        first..first + self.effects[at].info().value_len()
    }

    /// The effects that are fitted, with their values.
    pub fn fitted(&self) -> impl Iterator<Item = (&'e dyn AnyEffect, &[f64])> {
        (self.fixed..self.effects.len())
            .map(|at| (self.effects[at], &self.values[self.value_range(at)]))
    }

    /// Ids of the fitted effects.
    #[must_use]
    pub fn ids(&self) -> Vec<&'static str> {
        self.effects[self.fixed..].iter().map(|e| e.info().id).collect()
    }

    /// The fitted parameters: index into the values, and what is known of them.
    #[must_use]
    pub fn parameters(&self) -> Vec<(usize, ParameterInfo)> {
        (self.fixed..self.effects.len())
            .flat_map(|at| {
                let first = self.value_range(at).start;
                let infos = self.effects[at].info().parameters;
                infos.iter().enumerate().map(move |(i, &info)| (first + i, info))
            })
            .collect()
    }

    /// Number of fitted parameters of effects.
    #[must_use]
    pub fn parameter_len(&self) -> usize {
        self.effects[self.fixed..].iter().map(|e| e.info().parameters.len()).sum()
    }

    /// The uncertain numbers of a trial over any scalar.
    #[must_use]
    pub fn nuisances<S: EffectScalar>(&self, trial: usize) -> Nuisances<S> {
        let local = self.locals[trial];
        let c = S::constant;
        Nuisances {
            log_mass: c(self.common.log_mass),
            log_deformation: c(self.common.log_deformation),
            lead_samples: self.common.lead_samples,
            start_mm: c(local.start_mm),
            start_mm_s: c(local.start_mm_s),
            log_air: local.log_air.map(c),
        }
    }
}

/// A value in the coordinate in which it is fitted.
pub(crate) fn coordinate(value: f64, info: ParameterInfo) -> f64 {
    if info.logarithmic { value.max(1e-300).ln() } else { value }
}

/// The inverse of [`coordinate`], kept inside the parameter's range.
pub(crate) fn from_coordinate(at: f64, info: ParameterInfo) -> f64 {
    let value = if info.logarithmic { at.exp() } else { at };
    value.clamp(info.range[0], info.range[1])
}
