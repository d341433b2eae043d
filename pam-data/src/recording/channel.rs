//! The measured channels of the state.

/// A measured channel of the state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Channel {
    /// Displacement x, mm.
    X,
    /// Velocity ẋ, mm/s.
    V,
    /// Flexor pressure, kPa absolute.
    Pf,
    /// Extensor pressure, kPa absolute.
    Pe,
}

impl Channel {
    /// All channels in the order of the state.
    pub const ALL: [Self; 4] = [Self::X, Self::V, Self::Pf, Self::Pe];

    /// Short name, as in result files.
    #[must_use]
    pub fn key(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::V => "v",
            Self::Pf => "pf",
            Self::Pe => "pe",
        }
    }

    /// Name and unit for figures.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::X => "displacement x (mm)",
            Self::V => "velocity v (mm/s)",
            Self::Pf => "flexor pressure (kPa abs)",
            Self::Pe => "extensor pressure (kPa abs)",
        }
    }

    /// Unit.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::X => "mm",
            Self::V => "mm/s",
            Self::Pf | Self::Pe => "kPa",
        }
    }
}
