//! Arguments of the commands that plan, carry out and identify.

use crate::options::ModelOptions;
use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum};
use pam_control::experiments::tracking::{SERIES, SHAPES};
use std::path::PathBuf;

/// Within which masses a plan stays.
#[derive(Debug, Clone, Args)]
pub struct BoundsOptions {
    /// Least and most air in a muscle, g [default: what 10 and 80 psi gauge hold at x = 0]. What lies
    /// outside the default is flagged as extrapolation
    #[arg(
        long,
        value_name = "LEAST,MOST",
        value_delimiter = ',',
        num_args = 1,
        allow_hyphen_values = true
    )]
    pub mass_bounds: Option<Vec<f64>>,
    /// Step h of the stiffness estimate, mm
    #[arg(long, value_name = "MM", default_value_t = 1.0, allow_negative_numbers = true)]
    pub stiffness_step: f64,
}

/// How masses are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PlanMethod {
    /// Newton's method, and the curve of consistent masses where that fails
    Auto,
    /// All polygons of the masses, with a certificate
    Exact,
}

/// Arguments of `pam plan`.
#[derive(Debug, Args)]
pub struct PlanArguments {
    /// The model.
    #[command(flatten)]
    pub model: ModelOptions,
    /// sine:A=1,f=0.1, triangle:A=1,f=0.1, minimum-jerk:from=0,to=1,T=0.5, hold:x=0 (mm, Hz, s; x0 and
    /// duration can be added), or a CSV file with time_s, displacement_mm and, if wanted, velocity_mm_s,
    /// acceleration_mm_s2, stiffness_n_mm, force_n
    #[arg(long, value_name = "SPEC|FILE.csv")]
    pub motion: String,
    /// 150, sine:mean=150,A=10,f=0.1, or steps:140/150/160,hold=50 (N/mm, Hz, s)
    #[arg(long, value_name = "SPEC", allow_negative_numbers = true)]
    pub stiffness: Option<String>,
    /// External force that is expected, N
    #[arg(long, value_name = "N", default_value_t = 0.0, allow_negative_numbers = true)]
    pub load: f64,
    /// Samples per second
    #[arg(long, value_name = "HZ", default_value_t = 1000.0, allow_negative_numbers = true)]
    pub rate: f64,
    /// auto follows the curve of consistent masses, microseconds per sample; exact goes through all
    /// polygons of the masses (leaky_relu or relu), milliseconds per sample, and proves the optimum
    #[arg(long, value_enum, default_value = "auto", value_name = "NAME")]
    pub method: PlanMethod,
    /// The bounds.
    #[command(flatten)]
    pub bounds: BoundsOptions,
    /// Folder for table.csv, table.bin, table.h, network.bin, plan.json, report.html and run.json
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// Arguments of `pam stiffness`.
#[derive(Debug, Args)]
pub struct StiffnessArguments {
    /// The model.
    #[command(flatten)]
    pub model: ModelOptions,
    /// The bounds.
    #[command(flatten)]
    pub bounds: BoundsOptions,
    /// Largest displacement, mm
    #[arg(long, value_name = "MM", default_value_t = 3.0, allow_negative_numbers = true)]
    pub reach: f64,
    /// Velocities, mm/s
    #[arg(long, value_name = "V,…", value_delimiter = ',', default_values_t = [-5.0, 0.0, 5.0], allow_hyphen_values = true)]
    pub velocities: Vec<f64>,
    /// Folder for map.csv, range.csv, stiffness.json, report.html and run.json
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// Arguments of `pam track`.
#[derive(Debug, Args)]
pub struct TrackArguments {
    /// The model that plans.
    #[command(flatten)]
    pub model: ModelOptions,
    /// The bounds.
    #[command(flatten)]
    pub bounds: BoundsOptions,
    /// Parameters of the rig, a TOML file
    #[arg(long, value_name = "FILE")]
    pub rig: Option<PathBuf>,
    /// Only tests of these shapes
    #[arg(long, value_delimiter = ',', value_name = "NAME,…", value_parser = PossibleValuesParser::new(SHAPES))]
    pub shapes: Vec<String>,
    /// Only tests of these series
    #[arg(long, value_delimiter = ',', value_name = "NAME,…", value_parser = PossibleValuesParser::new(SERIES))]
    pub series: Vec<String>,
    /// Folder for tracking.csv, tracking.json, report.html and run.json
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// Schedules of `pam identify`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum IdentifySchedule {
    /// 126 to 176 N/mm at rest
    Staircase,
    /// 140, 150, 160 N/mm on a sine of 1 mm at 0.1 Hz
    Cycle,
    /// The cycle with the learned model's and the equilibrium-point model's commands
    Compare,
}

/// Arguments of `pam identify`.
#[derive(Debug, Args)]
pub struct IdentifyArguments {
    /// The model that plans, and whose mass is taken.
    #[command(flatten)]
    pub model: ModelOptions,
    /// Schedule on the virtual rig
    #[arg(
        long,
        value_enum,
        default_value = "staircase",
        value_name = "NAME",
        conflicts_with = "data"
    )]
    pub schedule: IdentifySchedule,
    /// Identify from recordings instead: every pulse of force in them that follows 50 ms without
    #[arg(long, num_args = 1.., value_name = "PATH")]
    pub data: Vec<PathBuf>,
    /// Recordings to which the equilibrium-point model is fitted [default: the 29 training conditions on
    /// the rig]
    #[arg(long, num_args = 1.., value_name = "PATH")]
    pub recordings: Vec<PathBuf>,
    /// The bounds.
    #[command(flatten)]
    pub bounds: BoundsOptions,
    /// Parameters of the rig, a TOML file
    #[arg(long, value_name = "FILE")]
    pub rig: Option<PathBuf>,
    /// Force of the pulses, N
    #[arg(long, value_name = "N", default_value_t = 90.0, allow_negative_numbers = true)]
    pub pulse_force: f64,
    /// Time from the start of a pulse that counts, ms
    #[arg(long, value_name = "MS", default_value_t = 150.0, allow_negative_numbers = true)]
    pub window: f64,
    /// How often a cycle is repeated, each time with another seed
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u32).range(1..))]
    pub repeats: u32,
    /// Folder for pulses.csv, identify.json, report.html and run.json
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// Arguments of `pam replan`.
#[derive(Debug, Args)]
pub struct ReplanArguments {
    /// The model.
    #[command(flatten)]
    pub model: ModelOptions,
    /// The bounds.
    #[command(flatten)]
    pub bounds: BoundsOptions,
    /// The motion, as for `pam plan`
    #[arg(long, value_name = "SPEC|FILE.csv", default_value = "sine:A=0.5,f=0.1,duration=12")]
    pub motion: String,
    /// The stiffness, as for `pam plan`
    #[arg(long, value_name = "SPEC", default_value = "150", allow_negative_numbers = true)]
    pub stiffness: String,
    /// Load step, N
    #[arg(long, value_name = "N", default_value_t = 40.0, allow_negative_numbers = true)]
    pub load: f64,
    /// When the load steps, s
    #[arg(long, value_name = "S", default_value_t = 4.0, allow_negative_numbers = true)]
    pub load_at: f64,
    /// Change of the wanted displacement that the table does not know, mm
    #[arg(long, value_name = "MM", default_value_t = 0.0, allow_negative_numbers = true)]
    pub shift: f64,
    /// When the wanted displacement changes, s
    #[arg(long, value_name = "S", default_value_t = 8.0, allow_negative_numbers = true)]
    pub shift_at: f64,
    /// Parameters of the rig, a TOML file
    #[arg(long, value_name = "FILE")]
    pub rig: Option<PathBuf>,
    /// Folder for replan.csv, replan.json, report.html and run.json
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}
