//! `pam replan`.

use super::{BoundsOptions, rig};
use crate::arguments::GlobalOptions;
use crate::commands::RunCommand;
use crate::console::{Console, table};
use crate::error::CliError;
use crate::options::ModelOptions;
use crate::output::Output;
use crate::rig_joint::RigJoint;
use crate::run_record::{self, made_by, write_json};
use clap::Args;
use pam_control::execution::{Commands, follow};
use pam_control::motion::{Motion, MotionPoint, MotionSpec, StiffnessProfile};
use pam_control::mpc::{MpcRun, MpcSettings, MpcTask, run_mpc};
use pam_control::report::{MpcReport, mpc_report};
use pam_control::synthesis::{Plan, plan::targets};
use pam_data::atomic::write_atomic;
use pam_report::page::number;
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

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
    /// Time of the load step, s
    #[arg(long, value_name = "S", default_value_t = 4.0, allow_negative_numbers = true)]
    pub load_at: f64,
    /// Change of the target displacement that the table does not know, mm
    #[arg(long, value_name = "MM", default_value_t = 0.0, allow_negative_numbers = true)]
    pub shift: f64,
    /// Time at which the target displacement changes, s
    #[arg(long, value_name = "S", default_value_t = 8.0, allow_negative_numbers = true)]
    pub shift_at: f64,
    /// Parameters of the rig: default, measured (as rough as the published real run), or a TOML file; what that leaves
    /// out has its default
    #[arg(long, value_name = "NAME|FILE", default_value = "default")]
    pub rig: String,
    /// Folder for replan.csv, replan.json, report.html and run.json
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// How long the servo holds the first pressures, s.
const SETTLE_S: f64 = 4.0;

/// A motion that is moved away from some time on, within a tenth of a second.
struct Shifted<'a> {
    motion: &'a dyn Motion,
    shift_mm: f64,
    at_s: f64,
}

impl Motion for Shifted<'_> {
    fn at(&self, time_s: f64) -> MotionPoint {
        let point = self.motion.at(time_s);
        let way = pam_control::motion::MinimumJerk {
            from_mm: 0.0,
            to_mm: self.shift_mm,
            duration_s: 0.1,
            delay_s: self.at_s,
        }
        .at(time_s);
        MotionPoint {
            displacement_mm: point.displacement_mm + way.displacement_mm,
            velocity_mm_s: point.velocity_mm_s + way.velocity_mm_s,
            acceleration_mm_s2: point.acceleration_mm_s2 + way.acceleration_mm_s2,
        }
    }
}

impl RunCommand for ReplanArguments {
    fn outputs(&self) -> Vec<Output<'_>> {
        vec![Output::Folder("replan", &self.out)]
    }

    fn run(&self, global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        let saved = self.model.load(global.rig()?.as_ref())?;
        let settings = self.bounds.settings(&saved, global)?;
        let rig = rig(&self.rig)?;
        for (option, value) in [
            ("--load", self.load),
            ("--load-at", self.load_at),
            ("--shift", self.shift),
            ("--shift-at", self.shift_at),
        ] {
            if !value.is_finite() {
                return Err(CliError::Usage(format!("{option} {value}: it must be finite")));
            }
        }
        let spec = MotionSpec::parse(&self.motion)?;
        let stiffness = StiffnessProfile::parse(&self.stiffness)?;
        let plan =
            Plan::new(&saved.model, targets(&spec, Some(&stiffness), 0.0, 1000.0)?, settings)?;
        let commands = Commands::from(&plan);
        let total = |time_s: f64| {
            let row = ((time_s * 1000.0).max(0.0) as usize).min(plan.solutions.len() - 1);
            let m = plan.solutions[row].masses;
            m.flexor_g + m.extensor_g
        };
        let first = commands.pressures_kpa(0.0);
        let load = |t: f64| if t >= self.load_at { self.load } else { 0.0 };
        let motion = Shifted { motion: &*spec.motion, shift_mm: self.shift, at_s: self.shift_at };

        let mut joint = RigJoint::new(&rig, global.seed, first)?;
        let followed = follow(&mut joint, &commands, SETTLE_S, load);
        let mut tabled = MpcRun {
            time_s: followed.time_s.clone(),
            wanted_mm: followed.time_s.iter().map(|&t| motion.at(t).displacement_mm).collect(),
            measured_mm: followed.measured_mm.clone(),
            ..MpcRun::default()
        };
        tabled.masses_g =
            plan.solutions.iter().map(|s| [s.masses.flexor_g, s.masses.extensor_g]).collect();
        let mpc_settings = MpcSettings::default();
        let mut joint = RigJoint::new(&rig, global.seed, first)?;
        let mpc = run_mpc(
            &mut joint,
            &saved.model,
            mpc_settings,
            settings.bounds,
            &MpcTask {
                motion: &motion,
                duration_s: spec.duration_s,
                total_g: &total,
                first_kpa: first,
                settle_s: SETTLE_S,
                force_n: &load,
            },
        )?;

        let end = spec.duration_s + 1.0;
        let mut stretches = vec![("whole", [0.0, end])];
        if self.load != 0.0 {
            stretches.push(("before the load", [0.0, self.load_at]));
            stretches.push(("from the load on", [self.load_at, end]));
        }
        if self.shift != 0.0 {
            stretches.push(("from the changed target on", [self.shift_at, end]));
        }
        let rows: Vec<_> = stretches
            .iter()
            .map(|(name, stretch)| {
                let [a, b] = [tabled.rmse_mm(*stretch), mpc.rmse_mm(*stretch)];
                (*name, a, b)
            })
            .collect();
        let quantiles = [0.5, 0.99, 1.0].map(|q| 1e6 * mpc.decision_quantile_s(q));
        let horizon_ms = 1e3 * mpc_settings.horizon.steps as f64 * mpc_settings.horizon.step_s;
        let value = json!({
            "rmse_mm": rows.iter().map(|(name, table, mpc)| json!({
                "stretch": name, "table": table, "replanned": mpc, "ratio": table / mpc,
            })).collect::<Vec<_>>(),
            "decision_us": { "median": quantiles[0], "p99": quantiles[1], "largest": quantiles[2] },
            "horizon_ms": horizon_ms,
            "settings": mpc_settings,
            "made_by": made_by(),
        });
        let out = &self.out;
        write_json(out.join("replan.json"), &value)?;
        let mut text = String::from("time_s,wanted_mm,table_mm,replanned_mm,unexplained_n\n");
        for k in 0..mpc.time_s.len().min(tabled.time_s.len()) {
            text += &format!(
                "{},{},{},{},{}\n",
                mpc.time_s[k],
                mpc.wanted_mm[k],
                tabled.measured_mm[k],
                mpc.measured_mm[k],
                mpc.unexplained_n[k]
            );
        }
        write_atomic(out.join("replan.csv"), text.as_bytes())?;
        let report = MpcReport {
            lead: format!(
                "{}; {}. Horizon {horizon_ms:.0} ms, a decision every millisecond: median {:.0} µs, 99 % within \
             {:.0} µs.",
                saved.info.name,
                disturbances(self),
                quantiles[0],
                quantiles[1]
            ),
            made_by: made_by(),
            rows: rows.iter().map(|(n, a, b)| ((*n).to_owned(), *a, *b)).collect(),
            table: tabled,
            mpc,
        };
        write_atomic(out.join("report.html"), mpc_report(&report).as_bytes())?;
        let configuration = json!({
            "model": self.model.model,
            "motion": self.motion,
            "stiffness": self.stiffness,
            "load_n": self.load,
            "load_at_s": self.load_at,
            "shift_mm": self.shift,
            "shift_at_s": self.shift_at,
            "settings": mpc_settings,
            "rig": rig,
        });
        run_record::write(out, "replan", global.seed, &configuration)?;
        console.json(&value);
        let mut cells = vec![["RMSE (mm)", "table", "MPC", "ratio"].map(str::to_owned).to_vec()];
        for (name, a, b) in &rows {
            cells.push(vec![(*name).into(), number(*a, 4), number(*b, 4), number(a / b, 1)]);
        }
        console.text(table(&cells));
        console.text(format!(
        "\n  a decision: median {:.0} µs, 99 % within {:.0} µs, at most {:.0} µs; horizon {horizon_ms:.0} ms\
         \n\nreport: {}",
        quantiles[0],
        quantiles[1],
        quantiles[2],
        out.join("report.html").display()
    ));
        Ok(ExitCode::SUCCESS)
    }
}

/// Disturbances that the planned table does not contain, in words.
fn disturbances(arguments: &ReplanArguments) -> String {
    let mut all = Vec::new();
    if arguments.load != 0.0 {
        all.push(format!("load of {} N from {} s on", arguments.load, arguments.load_at));
    }
    if arguments.shift != 0.0 {
        all.push(format!("target moved by {} mm at {} s", arguments.shift, arguments.shift_at));
    }
    if all.is_empty() { "nothing disturbs".into() } else { all.join("; ") }
}
