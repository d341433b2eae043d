//! Foretold limits of detection against those of an independent plant.
//!
//! ```sh
//! cargo build --release -p pam-tests --features studies --example experiment
//! target/release/examples/experiment limits        # resumable; into results/experiment
//! target/release/examples/experiment pairs         # resumable
//! target/release/examples/experiment nulls         # resumable
//! target/release/examples/experiment show --case creep-x2-0
//! ```

use clap::Parser;
use pam_core::units::significant;
use pam_data::SavedModel;
use pam_data::atomic::write_atomic;
use pam_experiment::certify::{Case, Outcome, Plan, clopper_pearson};
use pam_experiment::detect::Detection;
use pam_tests::experiment::{agreement, compared, confusions, foretold, found, published, run};
use pam_tests::nulls::{self, NullCase, NullOutcome};
use pam_tests::pairs::{self, PairOutcome, Published};
use rayon::prelude::*;
use serde::de::DeserializeOwned;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Parser)]
#[command(about = "Foretold limits of detection against those of an independent plant")]
struct Arguments {
    /// What to measure.
    #[arg(value_parser = ["limits", "pairs", "nulls", "show"])]
    what: String,
    /// Folder of the results.
    #[arg(long, default_value = "results/experiment")]
    out: PathBuf,
    /// Multiples that are run [default: all].
    #[arg(long, value_delimiter = ',')]
    multiples: Vec<f64>,
    /// Null sets.
    #[arg(long, default_value_t = 210)]
    count: usize,
    /// Diagnose null sets without baseline recordings.
    #[arg(long)]
    bare: bool,
    /// Case to be shown.
    #[arg(long)]
    case: Option<String>,
    /// Pairs to be shown before it ends.
    #[arg(long, default_value_t = 5)]
    shown: usize,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let measured = match arguments.what.as_str() {
        "pairs" => pairs(&arguments),
        "nulls" => nulls(&arguments),
        "show" => show(&arguments),
        _ => limits(&arguments),
    };
    match measured {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

/// The foretold limits of an earlier run in the same folder, or new ones.
fn remembered(arguments: &Arguments, saved: &SavedModel) -> Result<(Plan, Detection), String> {
    let path = arguments.out.join("foretold.json");
    if let Ok(text) = std::fs::read_to_string(&path) {
        return serde_json::from_str(&text).map_err(|e| format!("{}: {e}", path.display()));
    }
    let new = foretold(saved);
    let text = serde_json::to_string_pretty(&new).map_err(|e| e.to_string())?;
    write_atomic(&path, format!("{text}\n").as_bytes()).map_err(|e| e.to_string())?;
    Ok(new)
}

/// The diagnosis of one case of the limits.
fn show(arguments: &Arguments) -> Result<(), String> {
    let saved = published();
    let (plan, _) = remembered(arguments, &saved)?;
    let case = plan.cases.iter().find(|c| Some(&c.id) == arguments.case.as_ref());
    let case = case.ok_or("--case: give the id of a case, such as creep-x2-0")?;
    let found = found(&saved, case).map_err(|e| e.to_string())?;
    println!("{} {:?}: {} {:?}", case.id, case.values, found.verdict, found.reasons);
    for (what, causes) in [("named", &found.causes), ("minor", &found.minor)] {
        for c in causes {
            println!("{what} {} {:?} {:?}", c.effect, c.parameters, c.confusable_with);
        }
    }
    for r in &found.refused {
        println!("refused {} ({:.3}): {}", r.effect, r.inclusion, r.reason);
    }
    Ok(())
}

/// The list under a key of a file of results; empty where there is none.
fn stored<T: DeserializeOwned>(path: &Path, key: &str) -> Vec<T> {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let mut all = serde_json::from_str::<serde_json::Value>(&text).unwrap_or_default();
    serde_json::from_value(all[key].take()).unwrap_or_default()
}

/// Pairs of effects that a design separates and the published excitation does not.
fn pairs(arguments: &Arguments) -> Result<(), String> {
    let path = arguments.out.join("pairs.json");
    let mut seen: Vec<Published> = stored(&path, "published");
    let mut all: Vec<PairOutcome> = stored(&path, "pairs");
    let shown = |all: &[PairOutcome]| all.iter().filter(|o| o.is_shown()).count();
    let write = |seen: &[Published], all: &[PairOutcome]| -> Result<(), String> {
        let text =
            json!({ "tried": all.len(), "shown": shown(all), "pairs": all, "published": seen });
        write_atomic(&path, format!("{text:#}\n").as_bytes()).map_err(|e| e.to_string())?;
        let table = pairs::shown_table(all)?;
        let path = arguments.out.join("pairs.csv");
        write_atomic(&path, table.as_bytes()).map_err(|e| e.to_string())
    };
    if shown(&all) >= arguments.shown {
        return write(&seen, &all);
    }
    let model = pairs::model();
    let foretold = pairs::foretold(&model);
    for multiple in pairs::MULTIPLES {
        let is_known = |label: &str, seen: &[Published]| {
            seen.iter().any(|p| p.effect == label && p.multiple == multiple)
        };
        let limits = &foretold.0.limits;
        let due: Vec<_> = limits.iter().filter(|l| !is_known(&l.label, &seen)).collect();
        seen.par_extend(due.par_iter().filter_map(|own| pairs::published(&model, own, multiple)));
        write(&seen, &all)?;
        for case in seen.clone().iter().filter(|p| p.multiple == multiple) {
            let own = foretold.0.of(&case.effect).ok_or("an effect without a limit")?;
            println!("{} at {multiple} limits: {}", case.effect, case.said.text());
            for other in case.taken_for(&own.effect) {
                let is_over = |o: &PairOutcome| {
                    o.is_about(&own.effect, other)
                        && (o.is_shown() || (o.effect == case.effect && o.multiple == multiple))
                };
                if all.iter().any(is_over) {
                    continue;
                }
                let Some(outcome) = pairs::measured(&model, &foretold, case, other) else {
                    continue;
                };
                println!(
                    "  beside {other}: {:.2} -> {:.2}, {:.2} by {} designs, shown: {}, {:?}",
                    outcome.foretold[0],
                    outcome.foretold[1],
                    outcome.margin,
                    outcome.designs,
                    outcome.is_shown(),
                    outcome.said
                );
                all.push(outcome);
                write(&seen, &all)?;
                if shown(&all) >= arguments.shown {
                    return Ok(());
                }
            }
        }
    }
    Ok(())
}

/// False alarms on null sets of the virtual rig with certified settings.
fn nulls(arguments: &Arguments) -> Result<(), String> {
    let path = arguments.out.join("nulls.json");
    let mut outcomes: Vec<NullOutcome> = stored(&path, "outcomes");
    let cases = nulls::cases(arguments.count, !arguments.bare);
    let certificates: Vec<_> = nulls::OFF
        .iter()
        .map(|off| {
            let model = nulls::model_off_by(*off);
            let (settings, summary) = nulls::certified(&model);
            println!(
                "weights off by {off}: {:?} false alarms, odds {:.3}",
                summary.false_alarms,
                summary.log_odds.exp()
            );
            (model, settings, summary)
        })
        .collect();
    let due: Vec<NullCase> =
        cases.iter().filter(|c| outcomes.iter().all(|o| o.case != **c)).copied().collect();
    for some in due.chunks(14) {
        outcomes.par_extend(some.par_iter().map(|case| {
            let k = nulls::OFF.iter().position(|off| *off == case.off).unwrap_or(0);
            let (model, settings, _) = &certificates[k];
            let o = nulls::diagnosed(model, settings, case);
            println!("{case:?} {} {:?} {:.1} s", o.verdict, o.named, o.wall_s);
            o
        }));
        let shares: Vec<_> = [true, false]
            .map(|baseline| {
                let own = || outcomes.iter().filter(move |o| o.case.baseline == baseline);
                let (all, named) = (own().count(), own().filter(|o| !o.named.is_empty()).count());
                let limits = clopper_pearson(named as u64, all as u64, 0.95);
                json!({ "baseline": baseline, "sets": all, "with_a_name": named, "ci95": limits })
            })
            .into();
        let odds: Vec<_> = certificates
            .iter()
            .zip(nulls::OFF)
            .map(|((_, _, s), off)| {
                let (alarms, sets, ci95) = s.false_alarms;
                json!({ "off": off, "alarms": alarms, "sets": sets, "ci95": ci95, "odds": s.log_odds.exp() })
            })
            .collect();
        let text = json!({ "false_alarms": shares, "certificates": odds, "outcomes": outcomes });
        write_atomic(&path, format!("{text:#}\n").as_bytes()).map_err(|e| e.to_string())?;
    }
    Ok(())
}

fn limits(arguments: &Arguments) -> Result<(), String> {
    let saved = published();
    let (plan, detection) = remembered(arguments, &saved)?;
    let path = arguments.out.join("limits.json");
    let mut outcomes: Vec<Outcome> = stored(&path, "outcomes");
    let asked =
        |c: &&Case| arguments.multiples.is_empty() || arguments.multiples.contains(&c.multiple);
    let due: Vec<Case> = plan
        .cases
        .iter()
        .filter(asked)
        .filter(|c| outcomes.iter().all(|o| o.case != **c))
        .cloned()
        .collect();
    let write = |outcomes: &[Outcome]| -> Result<(), String> {
        let compared = compared(&detection, outcomes);
        let confused = confusions(&detection, outcomes);
        let text = json!({
            "effects": compared.len(),
            "limits": compared,
            "within_1.5": compared.iter().filter(|c| (1.0 / 1.5..=1.5).contains(&c.ratio)).count(),
            "confused_pairs_both_foretold_measured": agreement(&confused),
            "confusions": confused,
            "outcomes": outcomes,
        });
        write_atomic(&path, format!("{text:#}\n").as_bytes()).map_err(|e| e.to_string())
    };
    for some in due.chunks(16) {
        outcomes.extend(run(&saved, some, &|o| {
            let names: Vec<&str> = o.named.iter().map(|n| n.effect.as_str()).collect();
            println!("{:<40} {} {:?} {:.1} s", o.case.id, o.verdict, names, o.wall_s);
        }));
        write(&outcomes)?;
    }
    if due.is_empty() {
        write(&outcomes)?;
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
        agreement(&confusions(&detection, &outcomes))
    );
    Ok(())
}
