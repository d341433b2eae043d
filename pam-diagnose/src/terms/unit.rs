//! Units of coefficients.

/// A unit as powers of N, mm, s, kPa and g; or one that is not known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unit(Option<[i8; 5]>);

/// The base units, as suffixes of names and as they are written.
const BASES: [(&str, &str); 5] = [("n", "N"), ("mm", "mm"), ("s", "s"), ("kpa", "kPa"), ("g", "g")];

impl Unit {
    /// No unit.
    pub const ONE: Self = Self(Some([0; 5]));
    /// Newton.
    pub const N: Self = Self(Some([1, 0, 0, 0, 0]));
    /// Millimetre.
    pub const MM: Self = Self(Some([0, 1, 0, 0, 0]));
    /// Second.
    pub const S: Self = Self(Some([0, 0, 1, 0, 0]));
    /// Kilopascal.
    pub const KPA: Self = Self(Some([0, 0, 0, 1, 0]));
    /// Gram.
    pub const G: Self = Self(Some([0, 0, 0, 0, 1]));
    /// A unit that is not known.
    pub const UNKNOWN: Self = Self(None);

    /// The product with a power of another unit.
    #[must_use]
    pub fn times(self, other: Self, power: i8) -> Self {
        let both = self.0.zip(other.0);
        Self(both.map(|(a, b)| std::array::from_fn(|k| a[k] + power * b[k])))
    }

    /// Whether the unit is not known.
    #[must_use]
    pub fn is_unknown(self) -> bool {
        self.0.is_none()
    }

    /// The end of a parameter's name with a leading `_`; empty without a unit or with one that is not known.
    #[must_use]
    pub fn suffix(self) -> String {
        let part = |sign: i8| {
            self.part(sign, "_", |k, power| {
                let base = BASES[k].0;
                if power == 1 { base.to_owned() } else { format!("{base}{power}") }
            })
        };
        match (part(1), part(-1)) {
            (above, below) if below.is_empty() && above.is_empty() => String::new(),
            (above, below) if below.is_empty() => format!("_{above}"),
            (above, below) if above.is_empty() => format!("_per_{below}"),
            (above, below) => format!("_{above}_per_{below}"),
        }
    }

    /// As it is written, `N s²/mm²`; empty without a unit or with one that is not known.
    #[must_use]
    pub fn text(self) -> String {
        let part = |sign: i8| {
            self.part(sign, " ", |k, power| {
                let raised = match power {
                    1 => "",
                    2 => "²",
                    3 => "³",
                    4 => "⁴",
                    5 => "⁵",
                    _ => "ⁿ",
                };
                format!("{}{raised}", BASES[k].1)
            })
        };
        match (part(1), part(-1)) {
            (above, below) if below.is_empty() => above,
            (above, below) => {
                let above = if above.is_empty() { "1".to_owned() } else { above };
                if below.contains(' ') {
                    format!("{above}/({below})")
                } else {
                    format!("{above}/{below}")
                }
            }
        }
    }

    fn part(self, sign: i8, between: &str, write: impl Fn(usize, i8) -> String) -> String {
        let powers = self.0.unwrap_or_default();
        let own = powers.iter().enumerate().filter(|(_, p)| **p * sign > 0);
        own.map(|(k, p)| write(k, p.abs())).collect::<Vec<_>>().join(between)
    }
}
