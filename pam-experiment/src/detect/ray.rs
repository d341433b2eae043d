//! How an effect grows from nothing.

use crate::error::ExperimentError;
use pam_diagnose::joint::Signatures;
use pam_effects::effects::{AnyEffect, DataScales, ParameterInfo};

/// An effect with values that are kept as given, as in `creep:time_constant_s=2`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GivenValues {
    /// Its id.
    pub effect: String,
    /// Names and values.
    pub values: Vec<(String, f64)>,
}

impl std::str::FromStr for GivenValues {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (effect, rest) = text.split_once(':').unwrap_or((text, ""));
        let values = rest.split(';').map(str::trim).filter(|v| !v.is_empty()).map(|v| {
            let (name, value) =
                v.split_once('=').ok_or_else(|| format!("`{v}` is no name=value"))?;
            let value: f64 = value.trim().parse().map_err(|_| format!("`{value}` is no number"))?;
            Ok((name.trim().to_owned(), value))
        });
        Ok(Self {
            effect: effect.trim().to_owned(),
            values: values.collect::<Result<_, String>>()?,
        })
    }
}

/// How the values of an effect follow its magnitude.
#[derive(Debug, Clone, PartialEq)]
enum Growth {
    /// Places of values that differ from absent by a multiple of the magnitude.
    Adds(Vec<(usize, f64, f64)>),
    /// The place of a value that falls from its limit as the magnitude grows: `strong / m`.
    Falls(usize, f64),
}

/// A way from an absent effect to a large one.
#[derive(Debug, Clone, PartialEq)]
pub struct Ray {
    /// Index of the candidate.
    pub candidate: usize,
    /// Its id.
    pub effect: &'static str,
    /// Name of the value that tells the magnitude.
    pub parameter: &'static str,
    /// Number of the fitted parameters of the effect.
    pub parameters: usize,
    values: Vec<f64>,
    growth: Growth,
    range: [f64; 2],
    place: usize,
}

/// Share of the travel that stands for a length without a starting value.
const LENGTH_SHARE: f64 = 0.4;

/// The ways of a candidate: of one that has a magnitude for each chamber one of each, else one. Scales (lengths, times) keep
/// the middle one of the starting values that a diagnosis tries, unless they are given.
///
/// # Errors
/// [`ExperimentError::Setting`] if a given name is none of the effect's.
pub fn rays(
    signatures: &Signatures<'_>,
    candidate: usize,
    effect: &'static dyn AnyEffect,
    given: &[(String, f64)],
) -> Result<Vec<Ray>, ExperimentError> {
    let info = effect.info();
    for (name, _) in given {
        if !info.value_names().any(|n| n == name) {
            let known: Vec<&str> = info.value_names().collect();
            return Err(ExperimentError::setting(
                format!("effect `{}`", info.id),
                format!("it has no value `{name}`; there are {}", known.join(", ")),
            ));
        }
    }
    let scales = signatures.scales();
    let start = start_of(effect, scales);
    let mut values: Vec<f64> = info
        .parameters
        .iter()
        .enumerate()
        .map(|(k, p)| start.as_ref().map_or_else(|| without_start(p, scales), |s| s[k]))
        .collect();
    values.extend(
        info.switches
            .iter()
            .enumerate()
            .map(|(k, _)| start.as_ref().map_or(0.0, |s| s[info.parameters.len() + k])),
    );
    let is_given = |name: &str| given.iter().find(|g| g.0 == name).map(|g| g.1);
    for (value, name) in values.iter_mut().zip(info.value_names()) {
        *value = is_given(name).unwrap_or(*value);
    }
    let ray = |place: usize, values: Vec<f64>, growth: Growth| Ray {
        candidate,
        effect: info.id,
        parameter: info.parameters[place].name,
        parameters: info.parameters.len(),
        values,
        growth,
        range: info.parameters[place].range,
        place,
    };
    // A threshold: below it the effect is absent, whatever its other values are.
    if let Some(k) = info.parameters.iter().position(|p| p.off.is_none() && !p.logarithmic) {
        let strong = weakest(effect, scales, k).unwrap_or(values[k]);
        return Ok(vec![ray(k, values, Growth::Falls(k, strong))]);
    }
    let grows: Vec<(usize, f64)> = info
        .parameters
        .iter()
        .enumerate()
        .filter_map(|(k, p)| p.off.filter(|_| !p.logarithmic).map(|off| (k, off)))
        .collect();
    let Some(&(first, first_off)) = grows.first() else {
        // Nothing but a scale: a cutoff, a limit.
        let strong = weakest(effect, scales, 0).unwrap_or(values[0]);
        return Ok(vec![ray(0, values, Growth::Falls(0, strong))]);
    };
    let present = |&(k, off): &(usize, f64)| (values[k] - off).abs() > 0.0;
    if grows.len() > 1 && !grows.iter().any(present) {
        // Absent at the start in all chambers: each for itself.
        let of = |&(k, off): &(usize, f64)| {
            let mut own = values.clone();
            grows.iter().for_each(|&(other, off)| own[other] = off);
            ray(k, own, Growth::Adds(vec![(k, off, 1.0)]))
        };
        return Ok(grows.iter().map(of).collect());
    }
    let unit = values[first] - first_off;
    let share = |&(k, off): &(usize, f64)| {
        let share = if unit.abs() > 0.0 { (values[k] - off) / unit } else { 1.0 };
        (k, off, share)
    };
    Ok(vec![ray(first, values.clone(), Growth::Adds(grows.iter().map(share).collect()))])
}

/// The middle one of the starting values that do not follow from the residual.
fn start_of(effect: &dyn AnyEffect, scales: &DataScales) -> Option<Vec<f64>> {
    let scales = DataScales { samples: Vec::new(), ..scales.clone() };
    let starts = effect.starts(&scales);
    starts.get(starts.len() / 2).cloned()
}

/// The weakest of the starting values of a scale or threshold.
fn weakest(effect: &dyn AnyEffect, scales: &DataScales, place: usize) -> Option<f64> {
    effect.starts(scales).into_iter().filter_map(|s| s.get(place).copied()).reduce(f64::max)
}

fn without_start(p: &ParameterInfo, scales: &DataScales) -> f64 {
    match p.off {
        Some(off) => off,
        None if p.name.ends_with("_mm") => LENGTH_SHARE * scales.travel_mm,
        None => (p.range[0].max(f64::MIN_POSITIVE) * p.range[1]).sqrt(),
    }
}

impl Ray {
    /// The values of the effect at a magnitude: that of its parameter beyond absent, or of one that falls a reciprocal.
    #[must_use]
    pub fn values(&self, magnitude: f64) -> Vec<f64> {
        let mut values = self.values.clone();
        match &self.growth {
            Growth::Adds(places) => {
                for &(k, off, share) in places {
                    values[k] = off + share * magnitude;
                }
            }
            Growth::Falls(k, strong) => values[*k] = strong / magnitude.max(f64::MIN_POSITIVE),
        }
        values
    }

    /// The value of its parameter at a magnitude.
    #[must_use]
    pub fn value(&self, magnitude: f64) -> f64 {
        self.values(magnitude)[self.place]
    }

    /// How far its parameter is from absent at a magnitude, over a half-width of each fitted parameter; infinite where that is zero.
    pub(crate) fn over(&self, half_widths: &[f64], magnitude: f64) -> f64 {
        let half_width = half_widths.get(self.place).copied().unwrap_or_default();
        (self.value(magnitude) - self.value(0.0)).abs() / half_width
    }

    /// Whether its parameter is inside its physical range at a magnitude.
    #[must_use]
    pub fn admits(&self, magnitude: f64) -> bool {
        (self.range[0]..=self.range[1]).contains(&self.value(magnitude))
    }

    /// The magnitude at the weak end of the range of a value that falls; 0 for others.
    fn weakest(&self) -> f64 {
        match self.growth {
            Growth::Falls(_, strong) => strong / self.range[1],
            Growth::Adds(_) => 0.0,
        }
    }

    /// The magnitude at the strong end of the range.
    fn strongest(&self) -> f64 {
        match &self.growth {
            Growth::Falls(_, strong) => strong / self.range[0],
            Growth::Adds(places) => {
                let (_, off, share) = places[0];
                ((self.range[0] - off) / share).max((self.range[1] - off) / share)
            }
        }
    }

    /// The magnitude, or the nearest one inside the range.
    pub(crate) fn within_range(&self, magnitude: f64) -> f64 {
        magnitude.min(self.strongest()).max(self.weakest())
    }

    /// Whether a magnitude is at the weak end of the range.
    pub(crate) fn is_weakest(&self, magnitude: f64) -> bool {
        magnitude <= self.weakest() * (1.0 + 1e-9)
    }

    /// The magnitude, or the one at the weak end of the range.
    pub(crate) fn not_below_weakest(&self, magnitude: f64) -> f64 {
        magnitude.max(self.weakest())
    }

    /// Whether a magnitude is beyond the strong end of the range.
    pub(crate) fn is_beyond(&self, magnitude: f64) -> bool {
        !self.admits(magnitude) && magnitude > self.weakest()
    }

    /// A magnitude to begin with.
    pub(crate) fn first_magnitude(&self) -> f64 {
        match &self.growth {
            Growth::Falls(..) => 1.0,
            Growth::Adds(places) => {
                let (k, off, _) = places[0];
                let own = (self.values[k] - off).abs();
                if own > 0.0 { own } else { 1e-3 * (self.range[1] - off).abs().min(1e3) }
            }
        }
    }

    /// Names and values of the scales and switches that are kept along the way.
    #[must_use]
    pub fn kept(&self, effect: &dyn AnyEffect) -> Vec<(&'static str, f64)> {
        let changes = |k: usize| match &self.growth {
            Growth::Adds(places) => places.iter().any(|p| p.0 == k),
            Growth::Falls(place, _) => k == *place,
        };
        let all = effect.info().value_names().zip(&self.values).enumerate();
        all.filter(|(k, _)| !changes(*k)).map(|(_, (name, value))| (name, *value)).collect()
    }

    /// The label: the id, and the parameter where the effect has several ways.
    #[must_use]
    pub fn label(&self) -> String {
        let side = self.parameter.split('_').next().unwrap_or_default();
        if matches!(side, "flexor" | "extensor") {
            format!("{} ({side})", self.effect)
        } else {
            self.effect.to_owned()
        }
    }
}
