use pam_core::ModelError;

/// How a gradient is obtained.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum GradientChoice {
    /// Exact adjoint of the accepted steps.
    Adjoint,
    /// Closed-form pieces of a network of rectifiers, and their transposes.
    Exact,
    /// Tangents of the accepted steps, one for each number.
    Forward,
    /// Continuous adjoint, the state solved back with it.
    Backsolve,
    /// Continuous adjoint along the interpolated forward solution.
    Interpolating,
    /// Continuous adjoint, the parameters' part by quadrature.
    Quadrature,
    /// A reverse-mode tape through the accepted steps.
    Tape,
    /// Dual numbers through the accepted steps.
    Dual,
    /// Central differences of the solve with its steps held.
    FiniteDifference,
}

impl GradientChoice {
    /// Every choice with its name in files and on the command line.
    pub const ALL: &'static [(&'static str, Self)] = &[
        ("adjoint", Self::Adjoint),
        ("forward", Self::Forward),
        ("backsolve", Self::Backsolve),
        ("interpolating", Self::Interpolating),
        ("quadrature", Self::Quadrature),
        ("tape", Self::Tape),
        ("dual", Self::Dual),
        ("fd", Self::FiniteDifference),
        ("exact", Self::Exact),
    ];

    /// The choice of this name.
    ///
    /// # Errors
    /// [`ModelError::UnknownName`] with the names that exist.
    pub fn from_name(name: &str) -> Result<Self, ModelError> {
        Self::ALL.iter().find(|(n, _)| *n == name).map(|(_, choice)| *choice).ok_or_else(|| {
            let known: Vec<&str> = Self::ALL.iter().map(|(n, _)| *n).collect();
            ModelError::UnknownName {
                kind: "gradient method",
                name: name.to_owned(),
                known: known.join(", "),
            }
        })
    }

    /// The name that [`from_name`](Self::from_name) understands.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, choice)| *choice == self).map_or("", |(name, _)| name)
    }
}
