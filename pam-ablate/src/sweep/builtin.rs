//! Sweeps that come with the crate.

use super::Sweep;

const TEXTS: [(&str, &str); 5] = [
    ("activations", include_str!("../../sweeps/activations.toml")),
    ("stiffness", include_str!("../../sweeps/stiffness.toml")),
    ("gradients", include_str!("../../sweeps/gradients.toml")),
    ("curricula", include_str!("../../sweeps/curricula.toml")),
    ("data-size", include_str!("../../sweeps/data-size.toml")),
];

impl Sweep {
    /// Names of the sweeps that come with the crate.
    pub const BUILT_IN: [&'static str; 5] =
        [TEXTS[0].0, TEXTS[1].0, TEXTS[2].0, TEXTS[3].0, TEXTS[4].0];

    /// The TOML text of a sweep that comes with the crate.
    #[must_use]
    pub fn built_in_text(name: &str) -> Option<&'static str> {
        TEXTS.iter().find(|(n, _)| *n == name).map(|(_, text)| *text)
    }
}
