//! Choices that configuration files and command lines name.

use crate::error::ModelError;

/// One of a few values, each with a name in files and on the command line.
///
/// Command lines, help texts and error messages take names and descriptions from [`ALL`](Self::ALL).
pub trait NamedChoice: Copy + PartialEq + Send + Sync + 'static {
    /// The kind of choice, for messages: "unknown *interpolation* `spline`".
    const KIND: &'static str;
    /// Name, value and one-line description of every choice.
    const ALL: &'static [(&'static str, Self, &'static str)];

    /// The choice of this name.
    ///
    /// # Errors
    /// [`ModelError::UnknownName`] with the names that exist.
    fn from_name(name: &str) -> Result<Self, ModelError> {
        let found = Self::ALL.iter().find(|(n, ..)| *n == name).map(|(_, choice, _)| *choice);
        found.ok_or_else(|| ModelError::UnknownName {
            kind: Self::KIND,
            name: name.to_owned(),
            known: Self::ALL.iter().map(|(n, ..)| *n).collect::<Vec<_>>().join(", "),
        })
    }

    /// The name that [`from_name`](Self::from_name) understands.
    fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, choice, _)| *choice == self).map_or("", |(name, ..)| name)
    }
}
