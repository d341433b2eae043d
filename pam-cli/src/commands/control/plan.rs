//! `pam plan`.

use super::BoundsOptions;
use crate::PARTIAL;
use crate::arguments::GlobalOptions;
use crate::commands::RunCommand;
use crate::console::Console;
use crate::error::CliError;
use crate::options::{ModelOptions, describe_model};
use crate::output::Output;
use crate::run_record::{self, made_by, write_json};
use clap::{Args, ValueEnum};
use pam_control::export::{Precision, c_header, network_bytes, table_bytes, table_csv};
use pam_control::motion::{MotionSpec, StiffnessProfile};
use pam_control::report::plan_report;
use pam_control::synthesis::{Outcome, Plan, plan::targets};
use pam_core::AnyForce;
use pam_data::atomic::write_atomic;
use pam_exact::Certificate;
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

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
    /// Expected external force, N
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

/// Most stretches of unreachable stiffness that are printed.
const MOST_TOLD: usize = 5;

impl RunCommand for PlanArguments {
    fn outputs(&self) -> Vec<Output<'_>> {
        vec![Output::Folder("plan", &self.out)]
    }

    fn run(&self, global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        let saved = self.model.load(global.rig()?.as_ref())?;
        let settings = self.bounds.settings(&saved, global)?;
        let motion = MotionSpec::parse(&self.motion)?;
        let stiffness = self.stiffness.as_deref().map(StiffnessProfile::parse).transpose()?;
        if stiffness.is_none() && motion.table.is_none() {
            return Err(CliError::Usage(format!(
                "--stiffness is missing: --motion {} has no column `stiffness_n_mm`",
                self.motion
            )));
        }
        let targets = targets(&motion, stiffness.as_ref(), self.load, self.rate)?;
        let start = Instant::now();
        let (plan, certificates) = match self.method {
            PlanMethod::Auto => (Plan::new(&saved.model, targets, settings)?, Vec::new()),
            PlanMethod::Exact => Plan::certified(&saved.model, targets, settings)?,
        };
        let seconds = start.elapsed().as_secs_f64();
        let out = &self.out;
        write_atomic(out.join("table.csv"), table_csv(&plan).as_bytes())?;
        write_atomic(out.join("table.bin"), &table_bytes(&plan))?;
        write_atomic(out.join("table.h"), c_header(&plan).as_bytes())?;
        if let AnyForce::Network(force) = &saved.model.force {
            match network_bytes(&saved.model, force, Precision::F32) {
                Ok(bytes) => write_atomic(out.join("network.bin"), &bytes)?,
                Err(e) => console.warn(format!("no network.bin: {e}")),
            }
        }
        let title = format!("Plan: {}", self.motion);
        let lead = format!("{} {}", saved.info.name, describe_model(&saved));
        let report = plan_report(&plan, &title, &lead, &made_by());
        write_atomic(out.join("report.html"), report.as_bytes())?;
        let summary = plan.summary();
        let stretches = unreached(&plan);
        let value = json!({
            "summary": summary,
            "settings": settings,
            "unreached": stretches,
            "certificate": certificate_json(&certificates),
            "made_by": made_by(),
        });
        write_json(out.join("plan.json"), &value)?;
        let configuration = json!({
            "model": self.model.model,
            "motion": self.motion,
            "stiffness": self.stiffness,
            "load_n": self.load,
            "rate_hz": self.rate,
            "settings": settings,
        });
        run_record::write(out, "plan", global.seed, &configuration)?;
        // Times vary from run to run: they are printed, not written.
        let mut told = value;
        told["microseconds_a_sample"] = json!(1e6 * seconds / summary.samples as f64);
        console.json(&told);
        console.text(format!(
        "{} samples in {:.3} s ({:.1} µs each): residual at most {:.1e} mN, stiffness {:.1} to {:.1} N/mm,\n\
         air {:.4} to {:.4} g, pressures {:.0} to {:.0} kPa -> {}",
        summary.samples,
        seconds,
        1e6 * seconds / summary.samples as f64,
        summary.largest_residual_mn,
        summary.stiffness_n_mm[0],
        summary.stiffness_n_mm[1],
        summary.mass_g[0],
        summary.mass_g[1],
        summary.pressure_kpa[0],
        summary.pressure_kpa[1],
        out.display()
    ));
        if !certificates.is_empty() {
            let complete = certificates.iter().filter(|c| c.is_complete()).count();
            console.text(format!(
            "certificate: {complete} of {} samples are the global optimum (the polygons of the masses \
             fill the bounds)",
            certificates.len()
        ));
        }
        if summary.extrapolated > 0 {
            console.warn(format!(
            "{} samples hold air outside the {:.4} to {:.4} g of the training conditions: the model \
             extrapolates there (column `extrapolated`)",
            summary.extrapolated, plan.trained.least_g, plan.trained.most_g
        ));
        }
        if summary.nearest_stiffness == 0 {
            return Ok(ExitCode::SUCCESS);
        }
        console.warn(format!(
        "{} of {} samples cannot have the wanted stiffness with this motion; they hold the nearest one, at \
         most {:.2} N/mm off (column `stiffness_reached`)",
        summary.nearest_stiffness, summary.samples, summary.largest_stiffness_error_n_mm
    ));
        for s in stretches.iter().take(MOST_TOLD) {
            console.warn(format!(
                "  t = {:.3} to {:.3} s: wanted {:.1}, reachable {:.1} to {:.1} N/mm at its start",
                s.from_s, s.to_s, s.wanted_n_mm, s.reachable_n_mm[0], s.reachable_n_mm[1]
            ));
        }
        Ok(ExitCode::from(PARTIAL))
    }
}

/// Certificates of an exact plan; null for others.
fn certificate_json(certificates: &[Certificate]) -> serde_json::Value {
    if certificates.is_empty() {
        return serde_json::Value::Null;
    }
    let count = certificates.len() as f64;
    let mean = |of: fn(&Certificate) -> usize| {
        certificates.iter().map(|c| of(c) as f64).sum::<f64>() / count
    };
    json!({
        "complete": certificates.iter().filter(|c| c.is_complete()).count(),
        "samples": certificates.len(),
        "largest_missing_area": certificates.iter().map(|c| c.uncovered_share.abs()).fold(0.0, f64::max),
        "mean_polygons": mean(|c| c.regions),
        "mean_segments": mean(|c| c.segments),
        "mean_pieces": mean(|c| c.pieces),
    })
}

/// A stretch of samples whose stiffness cannot be reached.
#[derive(Debug, serde::Serialize)]
struct Stretch {
    from_s: f64,
    to_s: f64,
    wanted_n_mm: f64,
    reachable_n_mm: [f64; 2],
}

fn unreached(plan: &Plan) -> Vec<Stretch> {
    let mut stretches: Vec<Stretch> = Vec::new();
    let mut open = false;
    for (t, s) in plan.targets.iter().zip(&plan.solutions) {
        match (s.outcome, open, stretches.last_mut()) {
            (Outcome::Reached, ..) => open = false,
            (_, true, Some(last)) => last.to_s = t.time_s,
            _ => {
                open = true;
                stretches.push(Stretch {
                    from_s: t.time_s,
                    to_s: t.time_s,
                    wanted_n_mm: t.stiffness_n_mm,
                    reachable_n_mm: s.reachable_n_mm.unwrap_or([f64::NAN; 2]),
                });
            }
        }
    }
    stretches
}
