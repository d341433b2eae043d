//! Units of columns, and their factors to the units of a [`Recording`](crate::Recording).

use super::schema::Drive;
use pam_core::units::{KPA_PER_PSI, MN_PER_N};
use std::f64::consts::{PI, TAU};

/// The quantity of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Time.
    Time,
    /// Displacement x of the tendon, or the angle of its pulley.
    Displacement,
    /// Velocity ẋ of the tendon, or the angular velocity of its pulley.
    Velocity,
    /// Pressure of a muscle.
    Pressure,
    /// Force on the tendon, torque on its pulley, or current of the motor that makes it.
    Force,
}

impl Quantity {
    /// Its name in sentences.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Displacement => "displacement",
            Self::Velocity => "velocity",
            Self::Pressure => "pressure",
            Self::Force => "force",
        }
    }
}

/// Quantity that a unit needs in addition to its factor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Through {
    /// Nothing.
    Factor,
    /// The radius of the pulley: angles and angular velocities times it, torques over it.
    Pulley,
    /// Torque constant, gear ratio and pulley radius: currents.
    Motor,
    /// The sampling rate: counted samples.
    Rate,
}

/// A unit of a column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Its name in files.
    pub name: &'static str,
    /// Other spellings.
    pub aliases: &'static [&'static str],
    /// Its quantity.
    pub quantity: Quantity,
    /// One of it in s, mm, mm/s, kPa or mN; in rad, rad/s, N·m or A if it goes through pulley or motor.
    pub factor: f64,
    /// Quantity that the conversion also needs.
    pub through: Through,
    /// Its name in sentences, if a column in it is often taken for one in the unit of a recording: the plausibility check
    /// then looks for it.
    pub mistaken: Option<&'static str>,
}

impl Unit {
    /// One of it in s, mm, mm/s, kPa or mN on a rig with this drive, whose samples are `rate_hz` a second.
    ///
    /// # Errors
    /// A sentence naming the key of a rig file that the unit needs.
    pub fn size(&self, drive: &Drive, rate_hz: Option<f64>) -> Result<f64, String> {
        let need = |value: Option<f64>, key: &str| {
            value.ok_or_else(|| {
                format!("the unit {} of the {} needs `{key}`", self.name, self.quantity.name())
            })
        };
        let pulley = || need(drive.pulley_radius_mm, "drive.pulley_radius_mm");
        Ok(match (self.through, self.quantity) {
            (Through::Factor, _) => self.factor,
            (Through::Rate, _) => self.factor / need(rate_hz, "file.rate_hz")?,
            (Through::Pulley, Quantity::Force) => MN_PER_NM_PER_MM * self.factor / pulley()?,
            (Through::Pulley, _) => self.factor * pulley()?,
            (Through::Motor, _) => {
                let constant =
                    need(drive.torque_constant_nm_per_a, "drive.torque_constant_nm_per_a")?;
                let gear = need(drive.gear_ratio, "drive.gear_ratio")?;
                MN_PER_NM_PER_MM * self.factor * constant * gear / pulley()?
            }
        })
    }
}

/// 1 N·m/mm in mN.
const MN_PER_NM_PER_MM: f64 = 1e6;

const MM_PER_INCH: f64 = 25.4;
const N_PER_KGF: f64 = 9.806_65;
const N_PER_LBF: f64 = 4.448_221_615_260_5;

const fn unit(
    quantity: Quantity,
    through: Through,
    name: &'static str,
    factor: f64,
    aliases: &'static [&'static str],
) -> Unit {
    Unit { name, aliases, quantity, factor, through, mistaken: None }
}

/// A unit that the plausibility check looks for, with its name in sentences.
const fn often(words: &'static str, unit: Unit) -> Unit {
    Unit { mistaken: Some(words), ..unit }
}

/// All units. Exact by definition but for psi, whose factor is that of the published loader (Bureau international des
/// poids et mesures, *SI Brochure*, 9th edition; NIST Special Publication 811, appendix B).
pub static ALL: &[Unit] = {
    use Quantity::{Displacement, Force, Pressure, Time, Velocity};
    use Through::{Factor, Motor, Pulley, Rate};
    &[
        unit(Time, Factor, "s", 1.0, &["sec", "second", "seconds"]),
        unit(Time, Factor, "ms", 1e-3, &["msec", "millis", "milliseconds"]),
        unit(Time, Factor, "us", 1e-6, &["µs", "μs", "usec", "micros", "microseconds"]),
        unit(Time, Factor, "ns", 1e-9, &["nsec", "nanoseconds"]),
        unit(Time, Factor, "min", 60.0, &["minutes"]),
        unit(Time, Factor, "h", 3600.0, &["hours"]),
        unit(Time, Rate, "samples", 1.0, &["frames", "frame", "sample", "ticks"]),
        often("mm", unit(Displacement, Factor, "mm", 1.0, &["millimeter", "millimetre"])),
        often("m", unit(Displacement, Factor, "m", 1e3, &["meter", "metre"])),
        often("cm", unit(Displacement, Factor, "cm", 10.0, &[])),
        often("µm", unit(Displacement, Factor, "um", 1e-3, &["µm", "μm", "micron"])),
        often("inches", unit(Displacement, Factor, "in", MM_PER_INCH, &["inch"])),
        often(
            "degrees of the pulley",
            unit(Displacement, Pulley, "deg", PI / 180.0, &["°", "degree", "degrees"]),
        ),
        often(
            "radians of the pulley",
            unit(Displacement, Pulley, "rad", 1.0, &["radian", "radians"]),
        ),
        unit(Displacement, Pulley, "mrad", 1e-3, &[]),
        unit(Displacement, Pulley, "rev", TAU, &["revolution", "revolutions", "turn", "turns"]),
        unit(Displacement, Pulley, "arcmin", PI / 10_800.0, &[]),
        unit(Velocity, Factor, "mm/s", 1.0, &["mm/sec", "mmps", "mm_s", "mm_per_s"]),
        often("m/s", unit(Velocity, Factor, "m/s", 1e3, &["m/sec", "mps", "m_s", "m_per_s"])),
        often("cm/s", unit(Velocity, Factor, "cm/s", 10.0, &["cm_s", "cm_per_s"])),
        unit(Velocity, Factor, "in/s", MM_PER_INCH, &["in_s", "ips"]),
        often(
            "deg/s of the pulley",
            unit(Velocity, Pulley, "deg/s", PI / 180.0, &["°/s", "dps", "deg_s", "deg_per_s"]),
        ),
        often("rad/s of the pulley", unit(Velocity, Pulley, "rad/s", 1.0, &["rad_s", "rad_per_s"])),
        unit(Velocity, Pulley, "rpm", TAU / 60.0, &["rev/min", "1/min"]),
        unit(Velocity, Pulley, "rev/s", TAU, &["rev_s", "1/s"]),
        often("kPa", unit(Pressure, Factor, "kPa", 1.0, &[])),
        often("Pa", unit(Pressure, Factor, "Pa", 1e-3, &["pascal"])),
        often("hPa (mbar)", unit(Pressure, Factor, "hPa", 0.1, &[])),
        often("MPa", unit(Pressure, Factor, "MPa", 1e3, &[])),
        often("bar", unit(Pressure, Factor, "bar", 100.0, &["bara", "barg"])),
        unit(Pressure, Factor, "mbar", 0.1, &[]),
        often("psi", unit(Pressure, Factor, "psi", KPA_PER_PSI, &["psia", "psig", "lbf/in2"])),
        unit(Pressure, Factor, "atm", 101.325, &[]),
        unit(Pressure, Factor, "at", N_PER_KGF * 10.0, &["kgf/cm2", "kgf/cm²", "kg/cm2"]),
        unit(Pressure, Factor, "mmHg", 0.133_322_387_415, &[]),
        unit(Pressure, Factor, "torr", 101.325 / 760.0, &["Torr"]),
        unit(Pressure, Factor, "inHg", 3.386_388_640_341, &[]),
        unit(Force, Factor, "N", MN_PER_N, &["newton", "newtons"]),
        often("kN", unit(Force, Factor, "kN", 1e3 * MN_PER_N, &[])),
        often("mN", unit(Force, Factor, "mN", 1.0, &[])),
        often("kgf", unit(Force, Factor, "kgf", N_PER_KGF * MN_PER_N, &["kp"])),
        unit(Force, Factor, "gf", 1e-3 * N_PER_KGF * MN_PER_N, &[]),
        often("lbf", unit(Force, Factor, "lbf", N_PER_LBF * MN_PER_N, &["lb"])),
        often(
            "N·m at the pulley",
            unit(Force, Pulley, "N m", 1.0, &["Nm", "N*m", "N·m", "N.m", "newton-meter"]),
        ),
        unit(Force, Pulley, "mN m", 1e-3, &["mNm", "mN*m", "mN·m", "mN.m"]),
        unit(Force, Pulley, "N cm", 1e-2, &["Ncm", "N*cm", "N·cm"]),
        often("N·mm at the pulley", unit(Force, Pulley, "N mm", 1e-3, &["Nmm", "N*mm", "N·mm"])),
        unit(
            Force,
            Pulley,
            "lbf in",
            1e-3 * MM_PER_INCH * N_PER_LBF,
            &["lbf*in", "in-lb", "lb-in"],
        ),
        unit(
            Force,
            Pulley,
            "lbf ft",
            12e-3 * MM_PER_INCH * N_PER_LBF,
            &["lbf*ft", "ft-lb", "lb-ft"],
        ),
        unit(Force, Pulley, "kgf cm", 1e-2 * N_PER_KGF, &["kgf*cm", "kgcm"]),
        often("amperes of the motor", unit(Force, Motor, "A", 1.0, &["amp", "ampere", "amps"])),
        unit(Force, Motor, "mA", 1e-3, &[]),
    ]
};

/// The unit of a quantity with this name. Case matters where two units differ by it (mN and MN, mPa and MPa); else it
/// does not.
#[must_use]
pub fn find(quantity: Quantity, name: &str) -> Option<&'static Unit> {
    let name = name.trim();
    let names = |u: &Unit| [u.name].into_iter().chain(u.aliases.iter().copied());
    let of_quantity = || ALL.iter().filter(|u| u.quantity == quantity);
    let exact = of_quantity().find(|u| names(u).any(|n| n == name));
    exact.or_else(|| {
        let mut alike = of_quantity()
            .filter(|u| names(u).any(|n| n.len() > 1 && n.to_lowercase() == name.to_lowercase()));
        let first = alike.next();
        if alike.next().is_some() { None } else { first }
    })
}

/// Names of the units of a quantity.
#[must_use]
pub fn names_of(quantity: Quantity) -> Vec<&'static str> {
    ALL.iter().filter(|u| u.quantity == quantity).map(|u| u.name).collect()
}

/// The units of a quantity that the plausibility check looks for, with their names in sentences and their sizes in the unit
/// of a recording (mm, mm/s, kPa, mN) on the published rig; that unit itself comes first, if it is among them.
pub(crate) fn mistaken(quantity: Quantity) -> Vec<(&'static str, f64)> {
    let drive = Drive::published();
    ALL.iter()
        .filter(|u| u.quantity == quantity)
        .filter_map(|u| Some((u.mistaken?, u.size(&drive, None).ok()?)))
        .collect()
}
