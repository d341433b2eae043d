//! Functions of one variable.

/// A function `f(u)` of a variable, some with a scale `w > 0` of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Function {
    /// `u`.
    Linear,
    /// `|u|`.
    Absolute,
    /// `u²`.
    Square,
    /// `u³`.
    Cube,
    /// `u |u|`.
    SignedSquare,
    /// `max(u, 0)`.
    Positive,
    /// `max(−u, 0)`.
    Negative,
    /// `max(u − w, 0)`.
    Above,
    /// `max(−u − w, 0)`.
    Below,
    /// `max(|u| − w, 0)`.
    Outside,
    /// `w³ (sinh(u/w) − u/w)`: `u³/6` where it begins, and exponential beyond `w`.
    Stiffening,
    /// `tanh(u/w)`.
    Saturated,
    /// `exp(−|u|/w)`.
    Decaying,
    /// `exp(−u/w)`, for variables that are never negative, such as the time.
    Fading,
    /// `1/(1 + (u/w)²)`: a bell.
    Peaked,
    /// `exp(−(u/w)²)`: a bell without flanks.
    Gaussian,
    /// `|u|^p` of the number of units, with a fitted exponent in the place of the scale.
    Power,
    /// `sign(u) |u|^p` of the number of units, with a fitted exponent in the place of the scale.
    SignedPower,
    /// `sin(2π u/w)`.
    Sine,
    /// `cos(2π u/w)`.
    Cosine,
}

impl Function {
    /// All of them.
    pub const ALL: [Self; 20] = [
        Self::Linear,
        Self::Absolute,
        Self::Square,
        Self::Cube,
        Self::SignedSquare,
        Self::Positive,
        Self::Negative,
        Self::Above,
        Self::Below,
        Self::Outside,
        Self::Stiffening,
        Self::Saturated,
        Self::Decaying,
        Self::Fading,
        Self::Peaked,
        Self::Gaussian,
        Self::Power,
        Self::SignedPower,
        Self::Sine,
        Self::Cosine,
    ];

    /// Whether it is a sine or a cosine.
    #[must_use]
    pub fn is_wave(self) -> bool {
        matches!(self, Self::Sine | Self::Cosine)
    }

    /// Whether its scale is an exponent.
    #[must_use]
    pub fn has_exponent(self) -> bool {
        matches!(self, Self::Power | Self::SignedPower)
    }

    /// Whether it has a scale, or an exponent in its place.
    #[must_use]
    pub fn has_scale(self) -> bool {
        matches!(
            self,
            Self::Above
                | Self::Below
                | Self::Outside
                | Self::Stiffening
                | Self::Saturated
                | Self::Decaying
                | Self::Fading
                | Self::Peaked
                | Self::Gaussian
                | Self::Power
                | Self::SignedPower
                | Self::Sine
                | Self::Cosine
        )
    }

    /// Power of the unit of its argument that its value has.
    #[must_use]
    pub fn power(self) -> i8 {
        match self {
            Self::Linear
            | Self::Absolute
            | Self::Positive
            | Self::Negative
            | Self::Above
            | Self::Below
            | Self::Outside => 1,
            Self::Square | Self::SignedSquare => 2,
            Self::Cube | Self::Stiffening => 3,
            Self::Saturated
            | Self::Decaying
            | Self::Fading
            | Self::Peaked
            | Self::Gaussian
            | Self::Power
            | Self::SignedPower
            | Self::Sine
            | Self::Cosine => 0,
        }
    }

    /// The value.
    #[must_use]
    pub fn value(self, u: f64, scale: f64) -> f64 {
        match self {
            Self::Linear => u,
            Self::Absolute => u.abs(),
            Self::Square => u * u,
            Self::Cube => u * u * u,
            Self::SignedSquare => u * u.abs(),
            Self::Positive => u.max(0.0),
            Self::Negative => (-u).max(0.0),
            Self::Above => (u - scale).max(0.0),
            Self::Below => (-u - scale).max(0.0),
            Self::Outside => (u.abs() - scale).max(0.0),
            Self::Stiffening => scale.powi(3) * ((u / scale).sinh() - u / scale),
            Self::Saturated => (u / scale).tanh(),
            Self::Decaying => (-u.abs() / scale).exp(),
            Self::Fading => (-u / scale).exp(),
            Self::Peaked => (1.0 + (u / scale).powi(2)).recip(),
            Self::Gaussian => (-(u / scale).powi(2)).exp(),
            Self::Power => u.abs().powf(scale),
            Self::SignedPower if u == 0.0 => 0.0,
            Self::SignedPower => u.signum() * u.abs().powf(scale),
            Self::Sine => (std::f64::consts::TAU * u / scale).sin(),
            Self::Cosine => (std::f64::consts::TAU * u / scale).cos(),
        }
    }

    /// As an expression of `u` and the scale, both expressions; `u` must be a name or in brackets.
    #[must_use]
    pub fn text(self, u: &str, scale: &str) -> String {
        match self {
            Self::Linear => u.to_owned(),
            Self::Absolute => format!("abs({u})"),
            Self::Square => format!("{u}^2"),
            Self::Cube => format!("{u}^3"),
            Self::SignedSquare => format!("{u} * abs({u})"),
            Self::Positive => format!("max({u}, 0)"),
            Self::Negative => format!("max(-{u}, 0)"),
            Self::Above => format!("max({u} - {scale}, 0)"),
            Self::Below => format!("max(-{u} - {scale}, 0)"),
            Self::Outside => format!("max(abs({u}) - {scale}, 0)"),
            Self::Stiffening => format!("{scale}^3 * (sinh({u} / {scale}) - {u} / {scale})"),
            Self::Saturated => format!("tanh({u} / {scale})"),
            Self::Decaying => format!("exp(-abs({u}) / {scale})"),
            Self::Fading => format!("exp(-{u} / {scale})"),
            Self::Peaked => format!("1 / (1 + ({u} / {scale})^2)"),
            Self::Gaussian => format!("exp(-({u} / {scale})^2)"),
            Self::Power => format!("abs({u})^{scale}"),
            Self::SignedPower => format!("sign({u}) * abs({u})^{scale}"),
            Self::Sine => format!("sin(2 * pi * {u} / {scale})"),
            Self::Cosine => format!("cos(2 * pi * {u} / {scale})"),
        }
    }

    /// Length of its description, nats: minus the logarithm of how often it is expected.
    #[must_use]
    pub fn description_length(self) -> f64 {
        match self {
            Self::Linear => 1.0,
            Self::Absolute | Self::Square | Self::SignedSquare | Self::Cube => 2.0,
            Self::Saturated | Self::Positive => 2.5,
            Self::Negative
            | Self::Above
            | Self::Below
            | Self::Outside
            | Self::Stiffening
            | Self::Decaying
            | Self::Fading
            | Self::Peaked
            | Self::Gaussian
            | Self::Power
            | Self::SignedPower => 3.0,
            Self::Sine | Self::Cosine => 3.5,
        }
    }
}
