//! Guesses from the names of columns.

use super::super::schema::Zero;
use super::super::units::{self, Quantity};

/// Possible meanings of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    Time,
    Displacement,
    Velocity,
    FirstPressure,
    SecondPressure,
    Force,
}

impl Role {
    /// The order in which roles take columns.
    pub(super) const IN_ORDER: [Self; 6] = [
        Self::Time,
        Self::FirstPressure,
        Self::SecondPressure,
        Self::Velocity,
        Self::Force,
        Self::Displacement,
    ];

    pub(super) fn quantity(self) -> Quantity {
        match self {
            Self::Time => Quantity::Time,
            Self::Displacement => Quantity::Displacement,
            Self::Velocity => Quantity::Velocity,
            Self::FirstPressure | Self::SecondPressure => Quantity::Pressure,
            Self::Force => Quantity::Force,
        }
    }

    pub(super) fn describe(self) -> &'static str {
        match self {
            Self::Time => "the time",
            Self::Displacement => "the displacement or angle",
            Self::Velocity => "the velocity",
            Self::FirstPressure => "the first pressure",
            Self::SecondPressure => "the second pressure",
            Self::Force => "the force, torque or current",
        }
    }

    /// Words of names, in English, German, French and Spanish.
    fn words(self) -> &'static [&'static str] {
        match self {
            Self::Time => {
                &["t", "time", "zeit", "temps", "tiempo", "timestamp", "stamp", "clock", "frame"]
            }
            Self::Displacement => &[
                "x",
                "q",
                "pos",
                "position",
                "disp",
                "displacement",
                "angle",
                "winkel",
                "weg",
                "theta",
                "phi",
                "encoder",
                "enc",
                "joint",
                "stroke",
                "alpha",
            ],
            Self::Velocity => &[
                "v",
                "vel",
                "velocity",
                "speed",
                "dx",
                "xdot",
                "dq",
                "qdot",
                "omega",
                "w",
                "dtheta",
                "thetadot",
                "geschwindigkeit",
                "rate",
            ],
            Self::FirstPressure | Self::SecondPressure => {
                &["p", "pressure", "druck", "pression", "presion", "press", "pam", "pm", "chamber"]
            }
            Self::Force => &[
                "f",
                "force",
                "kraft",
                "load",
                "tension",
                "torque",
                "tau",
                "moment",
                "current",
                "i",
                "strom",
                "fe",
                "fext",
                "drehmoment",
                "loadcell",
                "motor",
            ],
        }
    }
}

/// The name of a column without its unit, and the unit: `p1 [bar]`, `p1 (bar)`, `p1_bar`, `p1/bar`, `p1 bar`.
pub(super) fn split_unit(name: &str) -> (&str, Option<&str>) {
    let name = name.trim();
    for (open, close) in [('[', ']'), ('(', ')'), ('<', '>')] {
        if let Some(body) = name.strip_suffix(close)
            && let Some((stem, unit)) = body.rsplit_once(open)
        {
            return (stem.trim(), Some(unit.trim()));
        }
    }
    let known = |unit: &str| {
        let all = [
            Quantity::Time,
            Quantity::Displacement,
            Quantity::Velocity,
            Quantity::Pressure,
            Quantity::Force,
        ];
        all.iter().any(|q| units::find(*q, unit).is_some())
    };
    // The longest ending that is a unit: `v_deg_s` before `s`.
    let mut ends: Vec<usize> =
        name.char_indices().filter(|(_, c)| "_ /.-".contains(*c)).map(|(at, _)| at).collect();
    ends.dedup();
    for at in ends {
        let (stem, unit) = (&name[..at], &name[at + 1..]);
        if !stem.is_empty() && known(unit) {
            return (stem, Some(unit));
        }
    }
    (name, None)
}

/// Words of a name in lower case, without digits at their ends.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before = ' ';
    for c in name.chars() {
        if !c.is_alphanumeric() {
            words.push(String::new());
        } else {
            if c.is_uppercase() && before.is_lowercase() {
                words.push(String::new());
            }
            words.last_mut().expect("never empty").extend(c.to_lowercase());
        }
        before = c;
    }
    let without_digits = |w: String| w.trim_end_matches(|c: char| c.is_ascii_digit()).to_owned();
    words.into_iter().map(without_digits).filter(|w| !w.is_empty()).collect()
}

/// True if a name, without its unit, says this role.
pub(super) fn named_role(name: &str, role: Role) -> bool {
    let of = |w: &String| {
        role.words().contains(&w.as_str())
            || (role.quantity() == Quantity::Pressure
                && w.starts_with('p')
                && w.len() <= 4
                && w != "pos"
                && w != "phi")
    };
    words(name).iter().any(of)
}

pub(super) fn looks_like_angle(name: &str) -> bool {
    words(name).iter().any(|w| {
        ["angle", "winkel", "theta", "phi", "q", "alpha", "encoder", "enc", "joint"]
            .contains(&w.as_str())
    })
}

fn says(name: &str, sides: &[&str]) -> bool {
    let (stem, _) = split_unit(name);
    words(stem).iter().any(|w| sides.iter().any(|s| w == s || (s.len() > 3 && w.contains(s))))
}

pub(super) fn says_flexor(name: &str) -> bool {
    says(name, &["flexor", "flex", "pf", "agonist", "beuger"]) && !says(name, &["antagonist"])
}

pub(super) fn says_extensor(name: &str) -> bool {
    says(name, &["extensor", "ext", "pe", "antagonist", "strecker"])
}

/// Gauge or absolute, where the name says it.
pub(super) fn stated_reference(name: &str) -> Option<Zero> {
    let lower = name.to_lowercase();
    let has = |ends: &[&str]| ends.iter().any(|e| lower.contains(e));
    if has(&["psig", "barg", "gauge", "_rel", "kpag"]) {
        Some(Zero::Gauge)
    } else if has(&["psia", "bara", "abs", "kpaa"]) {
        Some(Zero::Absolute)
    } else {
        None
    }
}

/// The likely unit of a force by its name.
pub(super) fn force_unit(name: &str) -> (&'static str, String) {
    let has = |list: &[&str]| words(name).iter().any(|w| list.contains(&w.as_str()));
    if has(&["current", "strom", "i", "motor"]) {
        ("A", "a current by its name".into())
    } else if has(&["torque", "tau", "moment", "drehmoment"]) {
        ("N m", "a torque by its name".into())
    } else {
        ("N", "a force by its name".into())
    }
}
