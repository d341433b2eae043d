//! Names of signals and parameters in sentences.

/// Suffixes of names that are units, and how they are written.
const UNITS: [(&str, &str); 24] = [
    ("mm_s2", "mm/s²"),
    ("mm_s", "mm/s"),
    ("m_s2", "m/s²"),
    ("m_s", "m/s"),
    ("rad_s2", "rad/s²"),
    ("rad_s", "rad/s"),
    ("per_s", "1/s"),
    ("um", "µm"),
    ("mm", "mm"),
    ("m", "m"),
    ("rad", "rad"),
    ("deg", "°"),
    ("hz", "Hz"),
    ("s", "s"),
    ("nm", "N m"),
    ("mn", "mN"),
    ("n", "N"),
    ("kpa", "kPa"),
    ("pa", "Pa"),
    ("kg", "kg"),
    ("g", "g"),
    ("v", "V"),
    ("a", "A"),
    ("k", "K"),
];

/// A name for sentences and its unit: `motor_speed_mm_s` is the "motor speed" in "mm/s". Without a known suffix the unit is
/// a dash.
pub(super) fn label(name: &str) -> (String, String) {
    for (suffix, unit) in UNITS {
        if let Some(rest) = name.strip_suffix(suffix).and_then(|r| r.strip_suffix('_')) {
            return (rest.replace('_', " "), unit.to_owned());
        }
    }
    (name.replace('_', " "), "–".to_owned())
}
