//! A first rig file, guessed from the names and numbers of a recording.
//!
//! Names decide what a column is, numbers what names leave open: which time unit makes sampling steps possible, which
//! pressure falls as x rises, which sign lets the joint yield to the force. Each guess has a reason and says whether it
//! must be confirmed. What no file can tell, the sizes of the rig, is left to the reader.

mod names;
mod numbers;
mod toml_text;

use super::schema::{Column, ColumnKey, Columns, Drive, FileLayout, PressureColumn, RigFile};
use super::units::{self, Quantity, Through};
use crate::error::DataError;
use crate::recording::median_step_s;
use crate::table::Table;
use names::{Role, named_role, split_unit};
use numbers::Numbers;
use std::path::Path;

/// One guess.
#[derive(Debug, Clone, PartialEq)]
pub struct Guess {
    /// Key of the rig file, `columns.time`.
    pub key: String,
    /// Why.
    pub reason: String,
    /// True if the reason may be wrong and the value is to be confirmed.
    pub to_confirm: bool,
}

/// A first rig file with the reasons of its values.
#[derive(Debug, Clone, PartialEq)]
pub struct GuessedRig {
    /// The rig file, complete but for [`missing`](Self::missing).
    pub rig: RigFile,
    /// A guess for each value.
    pub guesses: Vec<Guess>,
    /// Keys that must be added by hand, with what they are.
    pub missing: Vec<(String, String)>,
    /// Columns of the file that nothing was taken from.
    pub unused: Vec<String>,
}

/// A column that has a role.
struct Assigned<'a> {
    name: &'a str,
    unit: Option<&'static units::Unit>,
    values: Vec<f64>,
}

impl RigFile {
    /// Guesses the rig file of a recording by looking at it.
    ///
    /// # Errors
    /// [`DataError`] if the file holds no table, or no columns can be taken for displacement, two pressures and a force;
    /// it names what was found.
    pub fn guess(path: impl AsRef<Path>) -> Result<GuessedRig, DataError> {
        Self::guess_at(path.as_ref())
    }

    /// One instance, whatever the path is given as.
    fn guess_at(path: &Path) -> Result<GuessedRig, DataError> {
        let table = Table::open(path, &FileLayout::default())?;
        let mut guesser = Guesser { path, table: &table, guesses: Vec::new(), missing: Vec::new() };
        guesser.rig()
    }
}

struct Guesser<'a> {
    path: &'a Path,
    table: &'a Table,
    guesses: Vec<Guess>,
    missing: Vec<(String, String)>,
}

impl<'a> Guesser<'a> {
    fn say(&mut self, key: &str, reason: impl Into<String>, to_confirm: bool) {
        self.guesses.push(Guess { key: key.into(), reason: reason.into(), to_confirm });
    }

    fn rig(&mut self) -> Result<GuessedRig, DataError> {
        let names = self.table.names();
        // Columns of text stay out.
        let is_numeric = self.table.numeric();
        let numeric: Vec<usize> = (0..names.len()).filter(|&k| is_numeric[k]).collect();
        let mut taken: Vec<usize> = Vec::new();
        let mut roles: Vec<(Role, usize)> = Vec::new();
        for role in Role::IN_ORDER {
            let of_role =
                |k: &&usize| !taken.contains(k) && named_role(split_unit(&names[**k]).0, role);
            let mut candidates: Vec<usize> = numeric.iter().filter(of_role).copied().collect();
            // A name with a unit of the quantity is better than one without.
            candidates.sort_by_key(|&k| {
                units::find(role.quantity(), split_unit(&names[k]).1.unwrap_or("")).is_none()
            });
            if let Some(&first) = candidates.first() {
                taken.push(first);
                roles.push((role, first));
            }
        }
        let read = |role: Role| -> Option<Assigned<'a>> {
            let k = roles.iter().find(|r| r.0 == role)?.1;
            let values = self.table.columns(&[k]).ok()?.pop()?;
            let unit = split_unit(&names[k]).1.and_then(|u| units::find(role.quantity(), u));
            Some(Assigned { name: &names[k], unit, values })
        };
        let needed = [Role::Displacement, Role::FirstPressure, Role::SecondPressure, Role::Force];
        let absent: Vec<&str> =
            needed.iter().filter(|r| read(**r).is_none()).map(|r| r.describe()).collect();
        let (Some(x), Some(first), Some(second), Some(force)) = (
            read(Role::Displacement),
            read(Role::FirstPressure),
            read(Role::SecondPressure),
            read(Role::Force),
        ) else {
            return Err(DataError::file(
                self.path,
                format!(
                    "no column could be taken for {}; the file has [{}]. Write the rig file by hand (docs/own-rig.md)",
                    absent.join(", "),
                    names.join(", ")
                ),
            ));
        };
        let (time, velocity) = (read(Role::Time), read(Role::Velocity));
        let unused =
            (0..names.len()).filter(|k| !taken.contains(k)).map(|k| names[k].clone()).collect();
        let rig = self.described(time, x, velocity, [first, second], force);
        Ok(GuessedRig {
            rig,
            guesses: std::mem::take(&mut self.guesses),
            missing: std::mem::take(&mut self.missing),
            unused,
        })
    }

    /// The rig file of the columns with roles.
    fn described(
        &mut self,
        time: Option<Assigned<'_>>,
        x: Assigned<'_>,
        velocity: Option<Assigned<'_>>,
        pressures: [Assigned<'_>; 2],
        force: Assigned<'_>,
    ) -> RigFile {
        let mut file = FileLayout::default();
        if let Table::Delimited(table) = self.table {
            file.separator = Some(table.separator_name());
            file.decimal = Some(table.decimal_name().into());
            file.header = Some(table.header_line().is_some());
        }
        let time_column = time.as_ref().map(|t| self.time(t, &mut file));
        if time_column.is_none() {
            self.missing.push((
                "file.rate_hz".into(),
                "samples per second: no column looks like a time".into(),
            ));
        }
        let numbers =
            Numbers::new(&x.values, [&pressures[0].values, &pressures[1].values], &force.values);

        let x_unit = self.unit_of("columns.displacement", &x, || {
            let (low, high) = numbers::range(&x.values);
            if names::looks_like_angle(x.name) {
                let unit = if high - low > 4.0 { "deg" } else { "rad" };
                (unit, format!("an angle over {:.3}", high - low))
            } else {
                let unit = if high - low < 0.2 { "m" } else { "mm" };
                (unit, format!("a displacement over {:.4}", high - low))
            }
        });
        let displacement = column(&x, x_unit, 1.0);
        self.say("columns.displacement.sign", "positive is where the flexor shortens", true);

        let velocity = velocity.map(|v| {
            let unit = self.unit_of("columns.velocity", &v, || {
                let unit = match x_unit {
                    "deg" => "deg/s",
                    "rad" => "rad/s",
                    "m" => "m/s",
                    _ => "mm/s",
                };
                (unit, "the unit of the displacement per second".into())
            });
            column(&v, unit, 1.0)
        });
        if velocity.is_none() {
            self.say(
                "columns.velocity",
                "no column of velocities: it is derived from the displacement",
                false,
            );
        }

        // The flexor's pressure falls as x rises.
        let swap = match numbers.first_falls() {
            Some(falls) => {
                let names_say = names::says_extensor(pressures[0].name)
                    || names::says_flexor(pressures[1].name);
                let names_known = names_say
                    || names::says_flexor(pressures[0].name)
                    || names::says_extensor(pressures[1].name);
                let flexor = &pressures[usize::from(!falls)];
                self.say(
                    "columns.pressure_flexor",
                    format!(
                        "`{}` falls as `{}` rises{}",
                        flexor.name,
                        x.name,
                        if names_known && names_say == falls {
                            "; its name says the other muscle: is the sign of the displacement right?"
                        } else {
                            ""
                        }
                    ),
                    names_known && names_say == falls,
                );
                !falls
            }
            None => {
                self.say(
                    "columns.pressure_flexor",
                    "neither pressure follows the displacement",
                    true,
                );
                false
            }
        };
        let [first, second] = pressures;
        let (flexor, extensor) = if swap { (second, first) } else { (first, second) };
        let flexor = self.pressure("columns.pressure_flexor", &flexor, &numbers, usize::from(swap));
        let extensor =
            self.pressure("columns.pressure_extensor", &extensor, &numbers, usize::from(!swap));

        let force_unit = self.unit_of("columns.force", &force, || names::force_unit(force.name));
        let sign = match numbers.yields() {
            Some(true) => {
                self.say("columns.force.sign", "the joint yields to it", false);
                1.0
            }
            Some(false) => {
                self.say("columns.force.sign", "with sign 1 the joint would move against it", true);
                -1.0
            }
            None => {
                self.say("columns.force.sign", "the motion does not tell it", true);
                1.0
            }
        };
        let force = column(&force, force_unit, sign);
        self.sizes(x_unit, force_unit, velocity.as_ref().map(|v| v.unit.as_str()));
        RigFile {
            name: self
                .path
                .file_stem()
                .map_or_else(String::new, |s| s.to_string_lossy().into_owned()),
            file,
            columns: Some(Columns {
                time: time_column,
                displacement,
                velocity,
                pressure_flexor: flexor,
                pressure_extensor: extensor,
                force,
            }),
            drive: Drive::default(),
            ..RigFile::default()
        }
    }

    fn time(&mut self, time: &Assigned<'_>, file: &mut FileLayout) -> Column {
        let step = median_step_s(&time.values);
        let unit = self.unit_of("columns.time", time, || {
            if step == 1.0
                && time.values.iter().all(|t| t.fract() == 0.0)
                && time.values.len() > 2000
            {
                return (
                    "ms",
                    "steps of exactly 1: milliseconds at 1 kHz, or counted samples".into(),
                );
            }
            match [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)]
                .into_iter()
                .find(|(_, scale)| step * scale <= LONGEST_STEP_S)
            {
                Some((unit, scale)) => (
                    unit,
                    format!("steps of {step} are {:.1} samples per second", 1.0 / (step * scale)),
                ),
                None => ("s", format!("steps of {step}")),
            }
        });
        if unit == "samples" {
            file.rate_hz = None;
            self.missing
                .push(("file.rate_hz".into(), "samples per second of the counted samples".into()));
        }
        column(time, unit, 1.0)
    }

    fn pressure(
        &mut self,
        key: &str,
        pressure: &Assigned<'_>,
        numbers: &Numbers,
        place: usize,
    ) -> PressureColumn {
        let unit = self.unit_of(key, pressure, || numbers::pressure_unit(&pressure.values));
        let kpa = units::find(Quantity::Pressure, unit).map_or(1.0, |u| u.factor);
        let (reference, reason, to_confirm) = match names::stated_reference(pressure.name) {
            Some(zero) => (zero, "its name says so".to_owned(), false),
            None => numbers.reference(place, kpa),
        };
        self.say(&format!("{key}.reference"), reason, to_confirm);
        PressureColumn {
            column: ColumnKey::Name(pressure.name.to_owned()),
            unit: unit.into(),
            reference,
            scale: 1.0,
            offset: 0.0,
        }
    }

    /// The unit in the name, or one that is guessed.
    fn unit_of(
        &mut self,
        key: &str,
        column: &Assigned<'_>,
        guess: impl FnOnce() -> (&'static str, String),
    ) -> &'static str {
        let key = format!("{key}.unit");
        if let Some(unit) = column.unit {
            self.say(&key, format!("in the name `{}`", column.name), false);
            return unit.name;
        }
        let (unit, reason) = guess();
        self.say(&key, reason, true);
        unit
    }

    /// Values that the file does not contain.
    fn sizes(&mut self, x_unit: &str, force_unit: &str, v_unit: Option<&str>) {
        let through = |quantity, unit| units::find(quantity, unit).map(|u| u.through);
        let all = [
            through(Quantity::Displacement, x_unit),
            through(Quantity::Force, force_unit),
            v_unit.and_then(|u| through(Quantity::Velocity, u)),
        ];
        let mut missing = |key: &str, what: &str| self.missing.push((key.into(), what.into()));
        if all.iter().flatten().any(|t| matches!(t, Through::Pulley | Through::Motor)) {
            missing("drive.pulley_radius_mm", "radius of the pulley on which the tendon runs, mm");
        }
        if all.iter().flatten().any(|t| matches!(t, Through::Motor)) {
            missing("drive.torque_constant_nm_per_a", "torque constant of the motor, N m/A");
            missing("drive.gear_ratio", "gear ratio between motor and pulley");
        }
        missing("muscles.radius_mm", "radius of the muscles at x = 0, mm");
        missing("muscles.length_mm", "length of the muscles at x = 0, mm");
        missing("muscles.braid_angle_deg", "angle of the braid to the axis, degrees");
        missing("joint.mass_kg", "reflected mass at the tendon, kg (or joint.inertia_kg_m2)");
    }
}

/// Longest sampling step that is taken for seconds, s.
const LONGEST_STEP_S: f64 = 0.2;

fn column(assigned: &Assigned<'_>, unit: &str, sign: f64) -> Column {
    Column {
        column: ColumnKey::Name(assigned.name.to_owned()),
        unit: unit.into(),
        sign,
        scale: 1.0,
        offset: 0.0,
    }
}
