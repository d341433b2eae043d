//! `pam plan`.

use crate::PARTIAL;
use crate::arguments::{GlobalOptions, PlanArguments, PlanMethod};
use crate::console::Console;
use crate::error::CliError;
use crate::options::describe_model;
use crate::run_record::{self, made_by, write_json};
use pam_control::export::{Precision, c_header, network_bytes, table_bytes, table_csv};
use pam_control::motion::{MotionSpec, StiffnessProfile};
use pam_control::report::plan_report;
use pam_control::synthesis::{Outcome, Plan, plan::targets};
use pam_core::AnyForce;
use pam_data::atomic::write_atomic;
use pam_exact::Certificate;
use serde_json::json;
use std::process::ExitCode;
use std::time::Instant;

/// Most stretches of unreachable stiffness that are printed.
const MOST_TOLD: usize = 5;

/// Runs the command.
///
/// # Errors
/// [`CliError`] naming the option, file and line, or the sample that cannot be reached.
pub fn run(
    arguments: &PlanArguments,
    global: &GlobalOptions,
    console: &Console,
) -> Result<ExitCode, CliError> {
    let saved = arguments.model.load()?;
    let settings = arguments.bounds.settings(&saved.model)?;
    let motion = MotionSpec::parse(&arguments.motion)?;
    let stiffness = arguments.stiffness.as_deref().map(StiffnessProfile::parse).transpose()?;
    let targets = targets(&motion, stiffness.as_ref(), arguments.load, arguments.rate)?;
    let start = Instant::now();
    let (plan, certificates) = match arguments.method {
        PlanMethod::Auto => (Plan::new(&saved.model, targets, settings)?, Vec::new()),
        PlanMethod::Exact => Plan::certified(&saved.model, targets, settings)?,
    };
    let seconds = start.elapsed().as_secs_f64();
    let out = &arguments.out;
    write_atomic(&out.join("table.csv"), table_csv(&plan).as_bytes())?;
    write_atomic(&out.join("table.bin"), &table_bytes(&plan))?;
    write_atomic(&out.join("table.h"), c_header(&plan).as_bytes())?;
    if let AnyForce::Network(force) = &saved.model.force {
        match network_bytes(&saved.model, force, Precision::F32) {
            Ok(bytes) => write_atomic(&out.join("network.bin"), &bytes)?,
            Err(e) => console.warn(format!("no network.bin: {e}")),
        }
    }
    let title = format!("Plan: {}", arguments.motion);
    let lead = format!("{} {}", saved.info.name, describe_model(&saved));
    let report = plan_report(&plan, &title, &lead, &made_by());
    write_atomic(&out.join("report.html"), report.as_bytes())?;
    let summary = plan.summary();
    let stretches = unreached(&plan);
    let value = json!({
        "summary": summary,
        "settings": settings,
        "unreached": stretches,
        "certificate": certificate_json(&certificates),
        "made_by": made_by(),
    });
    write_json(&out.join("plan.json"), &value)?;
    let configuration = json!({
        "model": arguments.model.model,
        "motion": arguments.motion,
        "stiffness": arguments.stiffness,
        "load_n": arguments.load,
        "rate_hz": arguments.rate,
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
