//! The coordinate of an effect's parameter.

use pam_effects::ActiveEffect;

/// How a parameter of an effect is moved: `coordinate · unit` is its value, or its logarithm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectCoordinate {
    /// Values that it may have.
    pub range: [f64; 2],
    /// Whether its logarithm is moved.
    pub logarithmic: bool,
    /// The value from which training starts.
    pub start: f64,
    /// The change of value or logarithm that one unit of the coordinate is.
    pub unit: f64,
}

impl EffectCoordinate {
    /// Coordinates of the parameters of effects in turn, in units of one where none are given.
    #[must_use]
    pub fn all_of(effects: &[ActiveEffect], units: &[f64]) -> Vec<Self> {
        let parameters = effects
            .iter()
            .flat_map(|active| active.effect.info().parameters.iter().zip(active.parameters()));
        parameters
            .enumerate()
            .map(|(k, (info, &start))| Self {
                range: info.range,
                logarithmic: info.logarithmic,
                start,
                unit: units.get(k).copied().unwrap_or(1.0),
            })
            .collect()
    }

    /// The largest change of value or logarithm that is taken for one unit, however little it changes
    /// predictions: a factor of e, or a tenth of the range.
    #[must_use]
    pub fn largest_unit(&self) -> f64 {
        if self.logarithmic { 1.0 } else { 0.1 * (self.range[1] - self.range[0]) }
    }

    /// The coordinate of a value.
    #[must_use]
    pub fn at(&self, value: f64) -> f64 {
        let moved = if self.logarithmic { value.max(f64::MIN_POSITIVE).ln() } else { value };
        moved / self.unit
    }

    /// The value at a coordinate, inside its range.
    #[must_use]
    pub fn value(&self, at: f64) -> f64 {
        let moved = at * self.unit;
        let value = if self.logarithmic { moved.exp() } else { moved };
        value.clamp(self.range[0], self.range[1])
    }

    /// The derivative by the coordinate from that by the value; zero where a descent would leave the
    /// range.
    #[must_use]
    pub fn pull_back(&self, at: f64, by_value: f64) -> f64 {
        let value = self.value(at);
        let slope = by_value * self.unit * if self.logarithmic { value } else { 1.0 };
        let outward =
            (value <= self.range[0] && slope > 0.0) || (value >= self.range[1] && slope < 0.0);
        if outward { 0.0 } else { slope }
    }
}
