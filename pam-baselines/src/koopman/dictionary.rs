//! Dictionaries of the lifted state.

use serde::{Deserialize, Serialize};

/// Functions of the standardised state `x̃ = [x, ẋ, P_f, P_e]` that are one and the state first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Dictionary {
    /// `[1, x̃]`: 5 terms, the published model's.
    Linear,
    /// `[1, x̃, all products of two, P_f − P_e, P_f + P_e]`: 17 terms (Wang and Realmuto 2026,
    /// supplement A). The last two depend on the state linearly; the ridge shares their weights out.
    SecondOrder,
    /// All products of up to three: 35 terms.
    ThirdOrder,
}

impl Dictionary {
    /// All dictionaries.
    pub const ALL: [Self; 3] = [Self::Linear, Self::SecondOrder, Self::ThirdOrder];

    /// Number of terms.
    #[must_use]
    pub fn len(self) -> usize {
        match self {
            Self::Linear => 5,
            Self::SecondOrder => 17,
            Self::ThirdOrder => 35,
        }
    }

    /// Never: a dictionary has at least the constant.
    #[must_use]
    pub fn is_empty(self) -> bool {
        false
    }

    /// The dictionary with this many terms.
    #[must_use]
    pub fn of_len(len: usize) -> Option<Self> {
        Self::ALL.into_iter().find(|d| d.len() == len)
    }

    /// Name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::SecondOrder => "2nd order",
            Self::ThirdOrder => "3rd order",
        }
    }

    /// Writes ψ(x̃) to the first [`len`](Self::len) places.
    pub fn lift(self, x: &[f64; 4], out: &mut [f64]) {
        out[0] = 1.0;
        out[1..5].copy_from_slice(x);
        if self == Self::Linear {
            return;
        }
        let mut at = 5;
        for i in 0..4 {
            for j in i..4 {
                out[at] = x[i] * x[j];
                at += 1;
            }
        }
        match self {
            Self::Linear => {}
            Self::SecondOrder => {
                out[at] = x[2] - x[3];
                out[at + 1] = x[2] + x[3];
            }
            Self::ThirdOrder => {
                for i in 0..4 {
                    for j in i..4 {
                        for k in j..4 {
                            out[at] = x[i] * x[j] * x[k];
                            at += 1;
                        }
                    }
                }
            }
        }
    }
}
