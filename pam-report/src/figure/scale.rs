//! Linear and logarithmic axes.

use super::path::UNITS;
use super::style::{padded_range, tick_label};

/// How numbers are laid along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scale {
    /// Equal distances for equal differences.
    #[default]
    Linear,
    /// Equal distances for equal ratios; numbers that are not positive are left out.
    Logarithmic,
}

impl Scale {
    /// Where a number lies on the axis; NaN if it has no place.
    pub(super) fn place(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Logarithmic if value > 0.0 => value.log10(),
            Self::Logarithmic => f64::NAN,
        }
    }

    /// The axis that shows these places, with about `count` marks.
    pub(super) fn axis(self, places: impl Iterator<Item = f64>, margin: f64, count: usize) -> Axis {
        let (low, high) = padded_range(places, margin);
        self.between(low, high, count)
    }

    /// The axis between two places, with about `count` marks.
    pub(super) fn between(self, mut low: f64, mut high: f64, count: usize) -> Axis {
        if self == Self::Logarithmic && high - low < 0.4 {
            // A narrow band would have no round number in it.
            let middle = 0.5 * (low + high);
            (low, high) = (middle - 0.2, middle + 0.2);
        }
        let marks = match self {
            Self::Linear => linear_marks(low, high, count),
            Self::Logarithmic => logarithmic_marks(low, high, count),
        };
        Axis { low, high, marks }
    }

    /// The text at a place.
    pub(super) fn label(self, place: f64, span: f64) -> String {
        match self {
            Self::Linear => tick_label(place, span),
            Self::Logarithmic => power_label(place),
        }
    }
}

/// The places that an axis covers, with its marks.
#[derive(Debug, Clone)]
pub(super) struct Axis {
    pub(super) low: f64,
    pub(super) high: f64,
    marks: Vec<f64>,
}

impl Axis {
    /// How much it covers.
    pub(super) fn span(&self) -> f64 {
        self.high - self.low
    }

    /// Where its marks stand.
    pub(super) fn marks(&self) -> &[f64] {
        &self.marks
    }

    /// A place in [`UNITS`] from the low end; places far outside are brought nearer.
    pub(super) fn unit(&self, place: f64) -> i64 {
        let share = (place - self.low) / self.span();
        (share.clamp(-10.0, 11.0) * UNITS as f64).round() as i64
    }

    /// A place in [`UNITS`] from the high end: heights of a drawing run down.
    pub(super) fn unit_down(&self, place: f64) -> i64 {
        UNITS - self.unit(place)
    }
}

/// Round numbers at distances of 1, 2 or 5 times a power of ten.
fn linear_marks(low: f64, high: f64, count: usize) -> Vec<f64> {
    let rough = (high - low) / count.max(1) as f64;
    let power = 10_f64.powf(rough.log10().floor());
    let distance = [1.0, 2.0, 5.0, 10.0]
        .map(|factor| factor * power)
        .into_iter()
        .find(|d| *d >= 0.999 * rough)
        .unwrap_or(rough);
    let first = (low / distance).ceil() as i64;
    let last = (high / distance).floor() as i64;
    (first..=last).map(|k| k as f64 * distance).collect()
}

/// Powers of ten, at most about `count`; with 2 and 5 times them where there are few.
fn logarithmic_marks(low: f64, high: f64, count: usize) -> Vec<f64> {
    let decades = high.floor() as i64 - low.ceil() as i64 + 1;
    if decades >= 3 {
        let every = decades.div_euclid(count.max(1) as i64) + 1;
        let first = low.ceil() as i64;
        let aligned = first + (-first).rem_euclid(every);
        return (aligned..=high.floor() as i64).step_by(every as usize).map(|k| k as f64).collect();
    }
    (low.floor() as i64..=high.ceil() as i64)
        .flat_map(|k| [1.0_f64, 2.0, 5.0].map(|factor| k as f64 + factor.log10()))
        .filter(|place| (low..=high).contains(place))
        .collect()
}

/// `10^place`, written out where that is short.
fn power_label(place: f64) -> String {
    let exponent = (place + 1e-9).floor() as i32;
    let factor = 10_f64.powf(place - f64::from(exponent)).round();
    if (-3..=4).contains(&exponent) {
        return format!("{}", factor * 10_f64.powi(exponent)).chars().take(7).collect();
    }
    let digits = exponent.to_string().chars().map(superscript).collect::<String>();
    if factor == 1.0 { format!("10{digits}") } else { format!("{factor}·10{digits}") }
}

fn superscript(digit: char) -> char {
    match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '0' | '4'..='9' => {
            char::from_u32(u32::from('⁰') + digit as u32 - u32::from('0')).unwrap_or(digit)
        }
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_round_numbers() {
        assert_eq!(linear_marks(-0.1, 1.05, 5), [0.0, 0.5, 1.0]);
        assert_eq!(logarithmic_marks(-8.2, -3.9, 8), [-8.0, -7.0, -6.0, -5.0, -4.0]);
        assert_eq!(logarithmic_marks(-12.5, 3.0, 4), [-10.0, -5.0, 0.0]);
        let few: Vec<String> =
            logarithmic_marks(-0.4, 1.1, 8).into_iter().map(power_label).collect();
        assert_eq!(few, ["0.5", "1", "2", "5", "10"]);
        assert_eq!(["10⁻⁸", "0.001", "1000", "10⁵"], [-8.0, -3.0, 3.0, 5.0].map(power_label));
        assert_eq!(power_label(2e-7_f64.log10()), "2·10⁻⁷");
    }

    #[test]
    fn what_has_no_logarithm_has_no_place() {
        assert!(Scale::Logarithmic.place(0.0).is_nan() && Scale::Logarithmic.place(-1.0).is_nan());
        assert_eq!(Scale::Linear.place(-1.0), -1.0);
        let axis = Scale::Logarithmic.axis([2.0; 3].into_iter(), 0.1, 5);
        assert!(axis.low < 2.0 && axis.high > 2.0 && !axis.marks.is_empty());
    }
}
