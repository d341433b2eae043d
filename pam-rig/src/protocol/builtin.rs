//! Protocols that come with the rig.

use super::Protocol;
use crate::error::RigError;
use std::path::Path;

/// Names and texts.
const TEXTS: [(&str, &str); 4] = [
    ("paper", include_str!("../../protocols/paper.toml")),
    ("validation", include_str!("../../protocols/validation.toml")),
    ("pulses", include_str!("../../protocols/pulses.toml")),
    ("tracking", include_str!("../../protocols/tracking.toml")),
];

impl Protocol {
    /// Names of the protocols that come with the rig.
    pub const BUILT_IN: [&'static str; 4] = [TEXTS[0].0, TEXTS[1].0, TEXTS[2].0, TEXTS[3].0];

    /// The TOML text of a built-in protocol, as a template for your own.
    #[must_use]
    pub fn built_in_text(name: &str) -> Option<&'static str> {
        TEXTS.iter().find(|(n, _)| *n == name).map(|(_, text)| *text)
    }

    /// The training excitation of the published rig at the 29 training conditions.
    #[must_use]
    pub fn paper() -> Self {
        Self::built_in("paper").expect("a protocol that comes with the rig")
    }

    /// A protocol that comes with the rig.
    ///
    /// # Errors
    /// [`RigError::Protocol`] that lists the names.
    pub fn built_in(name: &str) -> Result<Self, RigError> {
        let text = Self::built_in_text(name).ok_or_else(|| RigError::Protocol {
            name: name.to_owned(),
            message: format!(
                "neither a file nor one of the protocols that come with the rig: {}",
                Self::BUILT_IN.join(", ")
            ),
        })?;
        Self::parse(text, Path::new(name))
    }

    /// A protocol by the name of a built-in one or the path of a file.
    ///
    /// # Errors
    /// [`RigError`] naming file, line and field.
    pub fn open(name: &str) -> Result<Self, RigError> {
        let path = Path::new(name);
        if Self::built_in_text(name).is_none() && (path.exists() || name.ends_with(".toml")) {
            Self::read(path)
        } else {
            Self::built_in(name)
        }
    }
}
