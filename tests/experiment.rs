//! Foretold limits of detection against those of an independent plant.
//!
//! ```sh
//! cargo build --release -p pam-tests --example experiment
//! target/release/examples/experiment limits        # resumable; into results/experiment
//! ```

use clap::Parser;
use pam_core::units::significant;
use pam_data::atomic::write_atomic;
use pam_experiment::certify::{Case, Outcome};
use pam_tests::experiment::{compared, confusions, foretold, published, run};
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Parser)]
#[command(about = "Foretold limits of detection against those of an independent plant")]
struct Arguments {
    /// What to measure.
    #[arg(value_parser = ["limits"])]
    what: String,
    /// Folder of the results.
    #[arg(long, default_value = "results/experiment")]
    out: PathBuf,
    /// Multiples that are run [default: all].
    #[arg(long, value_delimiter = ',')]
    multiples: Vec<f64>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match limits(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

fn limits(arguments: &Arguments) -> Result<(), String> {
    let saved = published();
    let (plan, detection) = foretold(&saved);
    let path = arguments.out.join("limits.json");
    let mut outcomes: Vec<Outcome> = std::fs::read_to_string(&path)
        .ok()
        .and_then(|text| serde_json::from_str::<serde_json::Value>(&text).ok())
        .and_then(|v| serde_json::from_value(v["outcomes"].clone()).ok())
        .unwrap_or_default();
    let asked =
        |c: &&Case| arguments.multiples.is_empty() || arguments.multiples.contains(&c.multiple);
    let due: Vec<Case> = plan
        .cases
        .iter()
        .filter(asked)
        .filter(|c| outcomes.iter().all(|o| o.case != **c))
        .cloned()
        .collect();
    for some in due.chunks(16) {
        outcomes.extend(run(&saved, some, &|o| {
            let names: Vec<&str> = o.named.iter().map(|n| n.effect.as_str()).collect();
            println!("{:<40} {} {:?} {:.1} s", o.case.id, o.verdict, names, o.wall_s);
        }));
        let compared = compared(&detection, &outcomes);
        let text = json!({
            "effects": compared.len(),
            "limits": compared,
            "within_1.5": compared.iter().filter(|c| (1.0 / 1.5..=1.5).contains(&c.ratio)).count(),
            "confusions_both_foretold_measured": confusions(&detection, &outcomes),
            "outcomes": outcomes,
        });
        write_atomic(&path, format!("{text:#}\n").as_bytes()).map_err(|e| e.to_string())?;
    }
    let all = compared(&detection, &outcomes);
    for c in &all {
        println!(
            "{:<28} {:<22} foretold {:>9}  measured/foretold {:.2}  {:?}",
            c.label,
            c.parameter,
            significant(c.foretold, 3),
            c.ratio,
            c.trials
        );
    }
    let within = all.iter().filter(|c| (1.0 / 1.5..=1.5).contains(&c.ratio)).count();
    println!(
        "{within} of {} within a factor of 1.5; confusions {:?}",
        all.len(),
        confusions(&detection, &outcomes)
    );
    Ok(())
}
