//! Variables, and the places at which an effect can act.

/// When an expression is evaluated, which decides what it may use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Moment {
    /// Once, from the values of the effect alone.
    Once,
    /// In the balance of forces, where all of the state is known.
    Motion,
    /// Between command and force, before the joint moves.
    Command,
    /// Where a sensor is read.
    Sensing,
}

impl Moment {
    /// In a sentence.
    #[cfg(feature = "files")]
    fn label(self) -> &'static str {
        match self {
            Self::Once => "in a constant of the effect",
            Self::Motion => "here",
            Self::Command => "between command and force",
            Self::Sensing => "at a sensor",
        }
    }
}

/// A place at which an effect can act.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// Name, with the unit of the expression.
    pub name: String,
    /// When the expression is evaluated.
    pub moment: Moment,
    /// One line.
    pub meaning: String,
}

/// A variable, and when it is known.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Variable {
    name: String,
    meaning: String,
    known: &'static [Moment],
    /// Only in [`MemoryLaw::Step`](super::MemoryLaw::Step).
    of_steps: bool,
}

/// The variables and the places of a system.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Language {
    variables: Vec<Variable>,
    /// Where an effect can act.
    pub places: Vec<Place>,
    /// Magnitudes of the data, which starting values and conditions may use.
    pub scales: Vec<String>,
    /// Whether `network(x, v)` is known.
    pub(super) network: bool,
}

use Moment::{Command, Motion, Once, Sensing};

/// Variables of the joint, in the order of their indices.
const JOINT: [(&str, &[Moment], &str); 12] = [
    ("x", &[Motion, Sensing], "displacement, mm"),
    ("v", &[Motion, Sensing], "velocity, mm/s"),
    ("pf", &[Motion, Sensing], "absolute pressure of the flexor, kPa"),
    ("pe", &[Motion, Sensing], "absolute pressure of the extensor, kPa"),
    ("mf", &[Motion], "air in the flexor, g"),
    ("me", &[Motion], "air in the extensor, g"),
    (
        "force",
        &[Motion, Command, Sensing],
        "force of the drive on the joint; the commanded one in `command_n`, the recorded one at a sensor, N",
    ),
    ("network", &[Motion], "restoring force of the base model, N"),
    ("t", &[Motion, Command, Sensing], "time since the excitation began, s"),
    (
        "dt",
        &[Motion, Command, Sensing],
        "time since the beginning of the step, s; in `step` of a memory",
    ),
    ("dx", &[Motion, Sensing], "travel since the beginning of the step, mm; in `step` of a memory"),
    (
        "x0",
        &[Motion, Sensing],
        "displacement at the beginning of the step, mm; in `step` of a memory",
    ),
];

/// Places of the joint.
const PLACES: [(&str, Moment, &str); 18] = [
    ("force_n", Motion, "force on the joint in the direction of +x"),
    ("dry_friction_n", Motion, "level of a dry friction, which sticks at rest"),
    ("force_factor", Motion, "factor of the base model's restoring force"),
    ("air_flexor_g_s", Motion, "air that enters the flexor"),
    ("air_extensor_g_s", Motion, "air that enters the extensor"),
    ("command_n", Command, "real force for the commanded `force`"),
    ("command_delay_s", Once, "delay of the real force behind the recorded one"),
    ("inertia_kg", Once, "mass that moves with the joint"),
    ("gas_exponent", Once, "factor of the exponent n of P Vⁿ = constant"),
    ("deformation_factor", Once, "factor of the deformation coefficient ν of the chambers"),
    ("contraction_limit_mm", Once, "contraction beyond which a chamber keeps its volume"),
    ("pressure_feedback", Once, "not 0: pressures that these change act on the joint"),
    ("position_mm", Sensing, "reading of the displacement"),
    ("velocity_mm_s", Sensing, "reading of the velocity; that of `position_mm` unless given"),
    ("position_delay_s", Once, "delay of displacement and velocity, before `position_mm`"),
    ("pressure_flexor_kpa", Sensing, "reading of the flexor's pressure"),
    ("pressure_extensor_kpa", Sensing, "reading of the extensor's pressure"),
    ("pressure_delay_s", Once, "delay of both pressures, before their readings"),
];

/// Magnitudes of recordings of the joint.
const SCALES: [&str; 6] = [
    "data_force_n",
    "data_peak_force_n",
    "data_travel_mm",
    "data_speed_mm_s",
    "data_stiffness_n_mm",
    "data_gauge_kpa",
];

impl Language {
    /// The language of the joint: variables `x v pf pe mf me force network t`, and `dt dx x0` in the steps of a memory.
    #[must_use]
    pub fn joint() -> Self {
        Self {
            variables: JOINT
                .iter()
                .map(|(name, known, meaning)| Variable {
                    name: (*name).to_owned(),
                    meaning: (*meaning).to_owned(),
                    known,
                    of_steps: matches!(*name, "dt" | "dx" | "x0"),
                })
                .collect(),
            places: PLACES
                .iter()
                .map(|(name, moment, meaning)| Place {
                    name: (*name).to_owned(),
                    moment: *moment,
                    meaning: (*meaning).to_owned(),
                })
                .collect(),
            scales: SCALES.map(str::to_owned).to_vec(),
            network: true,
        }
    }

    /// The language of a vector field: its states, its inputs and `t` are variables, and for each state NAME there is a
    /// place `d_NAME`, whose expression is added to the state's rate.
    #[must_use]
    pub fn field(states: &[&str], inputs: &[&str]) -> Self {
        let variable = |name: &&str| Variable {
            name: (*name).to_owned(),
            meaning: String::new(),
            known: &[Motion],
            of_steps: false,
        };
        let place = |name: &&str| Place {
            name: format!("d_{name}"),
            moment: Motion,
            meaning: format!("added to the rate of {name}"),
        };
        Self {
            variables: states.iter().chain(inputs).chain(&["t"]).map(variable).collect(),
            places: states.iter().map(place).collect(),
            scales: Vec::new(),
            network: false,
        }
    }

    /// Names of the variables and what they are.
    pub fn variables(&self) -> impl Iterator<Item = (&str, &str)> {
        self.variables.iter().map(|v| (v.name.as_str(), v.meaning.as_str()))
    }

    /// Why a variable may not be used; `None` if it may.
    #[cfg(feature = "files")]
    pub(super) fn refuses(&self, variable: usize, moment: Moment, in_step: bool) -> Option<String> {
        let Variable { name, known, of_steps, .. } = &self.variables[variable];
        if *of_steps && !in_step {
            return Some(format!("`{name}` is known in the `step` of a memory only"));
        }
        if known.contains(&moment) {
            return None;
        }
        let usable = self.variables.iter().filter(|v| v.known.contains(&moment) && !v.of_steps);
        let usable: Vec<&str> = usable.map(|v| v.name.as_str()).collect();
        Some(format!(
            "`{name}` is not known {}; there are {}",
            moment.label(),
            match usable.as_slice() {
                [] => "the parameters alone".to_owned(),
                names => names.join(", "),
            }
        ))
    }
}
