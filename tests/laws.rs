//! Study of the search for laws.
//!
//! ```sh
//! cargo build --release -p pam-tests --features studies --example laws --config 'profile.release.package.pam-tests.opt-level=3'
//! target/release/examples/laws run            # resumable; into results/laws
//! target/release/examples/laws run --only cubic
//! target/release/examples/laws run --list outside --out results/laws/now/outside
//! target/release/examples/laws tables         # criteria and tables, into results/laws
//! target/release/examples/laws compare        # first runs with runs of the present search, into results/laws
//! ```

use clap::{Parser, Subcommand, ValueEnum};
use pam_core::units::significant;
use pam_data::atomic::write_atomic;
use pam_diagnose::DiagnosisSettings;
use pam_experiment::certify::clopper_pearson;
use pam_tests::laws::{self, HiddenLaw, LawOutcome, nulls, run_law, run_null};
use serde_json::json;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// File with the counts.
const SUMMARY: &str = "summary.json";
/// Number of null sets.
const NULLS: usize = 40;
/// Lists of laws, by when they were written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum List {
    /// Those on which the search was developed, with the null sets; seeds from 1 on.
    Developed,
    /// Those that were written after the search; seeds from 101 on.
    Unseen,
    /// Those that were written after it was changed on these; seeds from 201 on.
    Fresh,
    /// Those that were written after it was changed on these; seeds from 301 on.
    Last,
    /// Those that were written without knowledge of the search; seeds from 401 on.
    Outside,
    /// Those that were written without knowledge of it after it was changed on these; seeds from 501 on.
    SecondOutside,
    /// Those that were written without knowledge of it after it was changed on these as well; seeds from 601 on.
    ThirdOutside,
    /// Those that were written without knowledge of it after it was changed on these too; seeds from 701 on.
    FourthOutside,
    /// Those that were written without knowledge of it together with these, and run after it was changed on these; seeds from 801 on.
    FifthOutside,
    /// Those that were written without knowledge of the search or of the earlier lists; seeds from 901 on.
    SixthOutside,
    /// Those that were written without knowledge of the search or of the earlier lists; seeds from 1001 on.
    SeventhOutside,
    /// Those that were written without knowledge of the search or of the earlier lists; seeds from 1101 on.
    EighthOutside,
    /// Those that were written without knowledge of the search or of the earlier lists; seeds from 1201 on.
    NinthOutside,
    /// Those that were written without knowledge of the search or of the earlier lists; seeds from 1301 on.
    TenthOutside,
    /// Those that were written without knowledge of the search or of the earlier lists; seeds from 1401 on.
    EleventhOutside,
    /// Those that were written without knowledge of the search or of the earlier lists; seeds from 1501 on.
    TwelfthOutside,
    /// Those that were written without knowledge of the search or of the earlier lists; seeds from 1601 on.
    ThirteenthOutside,
}

impl List {
    /// Its laws and the first seed of their noise.
    fn laws(self) -> (Vec<HiddenLaw>, u64) {
        match self {
            Self::Developed => (laws::laws(), 1),
            Self::Unseen => (laws::unseen(), 101),
            Self::Fresh => (laws::fresh(), 201),
            Self::Last => (laws::last(), 301),
            Self::Outside => (laws::outside(), 401),
            Self::SecondOutside => (laws::second_outside(), 501),
            Self::ThirdOutside => (laws::third_outside(), 601),
            Self::FourthOutside => (laws::fourth_outside(), 701),
            Self::FifthOutside => (laws::fifth_outside(), 801),
            Self::SixthOutside => (laws::sixth_outside(), 901),
            Self::SeventhOutside => (laws::seventh_outside(), 1001),
            Self::EighthOutside => (laws::eighth_outside(), 1101),
            Self::NinthOutside => (laws::ninth_outside(), 1201),
            Self::TenthOutside => (laws::tenth_outside(), 1301),
            Self::EleventhOutside => (laws::eleventh_outside(), 1401),
            Self::TwelfthOutside => (laws::twelfth_outside(), 1501),
            Self::ThirteenthOutside => (laws::thirteenth_outside(), 1601),
        }
    }

    /// When and by whom it was written.
    fn written(self) -> &'static str {
        match self {
            Self::Developed => "for the search",
            Self::Unseen => "after the first search",
            Self::Fresh => "after it was changed on these",
            Self::Last => "after it was changed on these as well",
            Self::Outside => "without knowledge of the search",
            Self::SecondOutside => "without knowledge of it, after it was changed on those",
            Self::ThirdOutside => "without knowledge of it, after it was changed on these as well",
            Self::FourthOutside => "without knowledge of it, after it was changed on these too",
            Self::FifthOutside => {
                "without knowledge of it, before it was changed on those, run afterwards"
            }
            Self::SixthOutside => "without knowledge of the search or of the earlier lists",
            Self::SeventhOutside => "without knowledge of the search or of the earlier lists",
            Self::EighthOutside => "without knowledge of the search or of the earlier lists",
            Self::NinthOutside => "without knowledge of the search or of the earlier lists",
            Self::TenthOutside => "without knowledge of the search or of the earlier lists",
            Self::EleventhOutside => "without knowledge of the search or of the earlier lists",
            Self::TwelfthOutside => "without knowledge of the search or of the earlier lists",
            Self::ThirteenthOutside => "without knowledge of the search or of the earlier lists",
        }
    }

    /// Whether its author chose the most plausible laws before any file was opened.
    fn is_plausible(self) -> bool {
        matches!(
            self,
            Self::SixthOutside
                | Self::SeventhOutside
                | Self::EighthOutside
                | Self::NinthOutside
                | Self::TenthOutside
                | Self::EleventhOutside
                | Self::TwelfthOutside
                | Self::ThirteenthOutside
        )
    }

    /// Whether its author did not know the search.
    fn is_blind(self) -> bool {
        self.is_plausible()
            || matches!(
                self,
                Self::Outside
                    | Self::SecondOutside
                    | Self::ThirdOutside
                    | Self::FourthOutside
                    | Self::FifthOutside
            )
    }
}

#[derive(Parser)]
#[command(about = "Study of the search for laws: laws that stand in no list, and null sets")]
struct Arguments {
    #[command(subcommand)]
    command: Action,
}

#[derive(Subcommand)]
enum Action {
    /// Run cases that have no outcome yet.
    Run {
        /// Cases whose id contains this.
        #[arg(long, default_value = "")]
        only: String,
        /// Number of seeds of the noise of the laws.
        #[arg(long, default_value_t = 1)]
        seeds: u64,
        /// Laws that are hidden.
        #[arg(long, value_enum, default_value_t = List::Developed)]
        list: List,
        /// Length of each recording, s.
        #[arg(long, default_value_t = laws::LENGTH_S)]
        length: f64,
        /// Change one setting of the diagnosis, like `remainder.rounds=3`; may be repeated.
        #[arg(long = "set", value_name = "KEY=VALUE")]
        overrides: Vec<String>,
        /// Folder of the outcomes.
        #[arg(long, default_value = "results/laws")]
        out: PathBuf,
    },
    /// Print and write the tables.
    Tables {
        /// Folder of the outcomes.
        #[arg(default_value = "results/laws")]
        folder: PathBuf,
    },
    /// Compare the first run of the lists that the search had not seen (`first/LIST`) with a run of the present search (`now/LIST`).
    Compare {
        /// Folder with both.
        #[arg(default_value = "results/laws")]
        folder: PathBuf,
    },
}

fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Action::Run { only, seeds, list, length, overrides, out } => {
            DiagnosisSettings::parse("", &overrides)
                .map_err(|e| e.to_string())
                .and_then(|settings| run(&only, seeds, (list, length), &settings, &out))
        }
        Action::Tables { folder } => tables(&folder),
        Action::Compare { folder } => compare(&folder),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

fn run(
    only: &str,
    seeds: u64,
    (list, length_s): (List, f64),
    settings: &DiagnosisSettings,
    out: &Path,
) -> Result<(), String> {
    let store = |id: &str, outcome: &dyn Fn() -> LawOutcome| -> Result<(), String> {
        let path = out.join(format!("{id}.json"));
        if !id.contains(only) || path.exists() {
            return Ok(());
        }
        let outcome = outcome();
        println!("{}", line(&outcome));
        let text = serde_json::to_string(&outcome).map_err(|e| e.to_string())?;
        write_atomic(&path, format!("{text}\n").as_bytes()).map_err(|e| e.to_string())
    };
    let (hidden, first) = list.laws();
    for seed in first..first + seeds {
        for law in &hidden {
            store(&format!("{}-{seed}", law.id), &|| run_law(law, seed, length_s, settings))?;
        }
    }
    if list != List::Developed {
        return Ok(());
    }
    for case in nulls(NULLS) {
        store(&case.id, &|| run_null(&case, settings))?;
    }
    Ok(())
}

fn line(o: &LawOutcome) -> String {
    let law = o.law.as_deref().unwrap_or("no law");
    let reached =
        o.reached().map_or(String::new(), |r| format!(", {:.1} % of the law's own", 100.0 * r));
    format!(
        "{:<24} {} -> {}: {law}{reached}; CPU {:.0} + {:.0} s",
        o.id, o.diagnosis, o.verdict, o.cpu_s[0], o.cpu_s[1]
    )
}

/// The outcomes in a folder, in the order of their ids.
fn outcomes(folder: &Path) -> Result<Vec<LawOutcome>, String> {
    let told = |e: std::io::Error| format!("{}: {e}", folder.display());
    let mut paths: Vec<PathBuf> =
        std::fs::read_dir(folder).map_err(told)?.flatten().map(|e| e.path()).collect();
    paths.retain(|p| {
        p.extension().is_some_and(|e| e == "json") && p.file_name().is_some_and(|n| n != SUMMARY)
    });
    paths.sort();
    let read = |p: &PathBuf| -> Result<LawOutcome, String> {
        let text = std::fs::read_to_string(p).map_err(told)?;
        serde_json::from_str(&text).map_err(|e| format!("{}: {e}", p.display()))
    };
    paths.iter().map(read).collect()
}

fn is_called_explained(o: &LawOutcome) -> bool {
    o.verdict == "explained"
}

/// The rows of the cases with a hidden law.
fn cases<'o>(hidden: impl Iterator<Item = &'o LawOutcome>) -> String {
    let mut cases = String::from(
        "hidden law,named with --no-law,verdict with the law,law that is found,its numbers,found,own error reduction (%),CPU of the diagnosis (s),CPU of correction and law (s)\n",
    );
    for o in hidden {
        let numbers: Vec<String> = o
            .parameters
            .iter()
            .map(|(name, values)| {
                let [v, low, high] = values.map(|v| significant(v, 4));
                format!("{name} {v} [{low}; {high}]")
            })
            .collect();
        let _ = writeln!(
            cases,
            "{},{},{},\"{}\",{},{},{:.1},{:.1},{:.1}",
            o.id,
            o.named_before.join(" + "),
            o.verdict,
            o.law.as_ref().map_or_else(|| "–".to_owned(), |l| format!("`{l}`")),
            numbers.join("; "),
            if o.is_found() { "yes" } else { "no" },
            100.0 * o.reached().unwrap_or(0.0),
            o.cpu_s[0],
            o.cpu_s[1]
        );
    }
    cases
}

fn write(path: &Path, text: &str) -> Result<(), String> {
    write_atomic(path, text.as_bytes()).map_err(|e| e.to_string())
}

fn write_json(path: &Path, value: &serde_json::Value) -> Result<(), String> {
    let text = serde_json::to_string_pretty(value).map_err(|e| e.to_string())?;
    println!("{text}");
    write(path, &format!("{text}\n"))
}

fn tables(folder: &Path) -> Result<(), String> {
    let all = outcomes(folder)?;
    let (hidden, nulls): (Vec<_>, Vec<_>) = all.iter().partition(|o| o.hidden);
    let laws = nulls.iter().filter(|o| o.law.is_some() || o.outcome == "correction").count();
    let slowest =
        |of: &dyn Fn(&LawOutcome) -> f64| hidden.iter().map(|o| of(o)).fold(0.0, f64::max);
    let cases = cases(hidden.iter().copied());
    println!("{cases}");
    write(&folder.join("cases.csv"), &cases)?;
    let summary = json!({
        "hidden": hidden.len(),
        "found": hidden.iter().filter(|o| o.is_found()).count(),
        "with_memory": hidden.iter().filter(|o| o.is_found() && o.remembers).count(),
        "called_explained": hidden.iter().filter(|o| is_called_explained(o)).count(),
        "nulls": nulls.len(),
        "nulls_with_law": laws,
        "slowest_s": slowest(&|o| o.cpu_s[1]),
        "slowest_wall_s": slowest(&|o| o.wall_s),
        "slowest_diagnosis_s": slowest(&|o| o.cpu_s[0]),
        "least_share": hidden.iter().filter_map(|o| o.reached()).fold(f64::INFINITY, f64::min),
    });
    write_json(&folder.join(SUMMARY), &summary)
}

/// Compares the first run of each list that the search had not seen with that of the present search.
fn compare(folder: &Path) -> Result<(), String> {
    let mut rows = String::from(
        "laws,hidden,found in the first run,called explained in it,found now,called explained now\n",
    );
    let mut now = Vec::new();
    // Counts of laws and of those that were found.
    let (mut unusual, mut plausible) = ([0_u64; 2], [0_u64; 2]);
    for list in List::value_variants().iter().filter(|list| **list != List::Developed) {
        let name = list.to_possible_value().map_or_else(String::new, |v| v.get_name().to_owned());
        let [first, last] = [folder.join("first").join(&name), folder.join("now").join(&name)];
        let (first, last) = (outcomes(&first)?, outcomes(&last)?);
        let found = |all: &[LawOutcome]| all.iter().filter(|o| o.is_found()).count();
        let explained = |all: &[LawOutcome]| all.iter().filter(|o| is_called_explained(o)).count();
        let counts = [found(&first), explained(&first), found(&last), explained(&last)];
        let counts = counts.map(|n| n.to_string()).join(",");
        let _ = writeln!(rows, "\"{}\",{},{counts}", list.written(), first.len());
        let counts = match list {
            _ if list.is_plausible() => Some(&mut plausible),
            _ if list.is_blind() => Some(&mut unusual),
            _ => None,
        };
        if let Some([hidden, of_these]) = counts {
            *hidden += first.len() as u64;
            *of_these += found(&first) as u64;
        }
        now.extend(last);
    }
    println!("{rows}");
    let tables = folder.join("now");
    write(&tables.join("lists.csv"), &rows)?;
    write(&tables.join("cases.csv"), &cases(now.iter()))?;
    let rate = |[hidden, found]: [u64; 2]| {
        let [low, high] = clopper_pearson(found, hidden, 0.95);
        let share = found as f64 / hidden as f64;
        json!({ "hidden": hidden, "found": found, "share": share, "low": low, "high": high })
    };
    let slowest = |of: fn(&LawOutcome) -> f64| now.iter().map(of).fold(0.0, f64::max);
    let summary = json!({
        "unusual": rate(unusual),
        "plausible": rate(plausible),
        "now_hidden": now.len(),
        "now_found": now.iter().filter(|o| o.is_found()).count(),
        "now_called_explained": now.iter().filter(|o| is_called_explained(o)).count(),
        "now_slowest_s": slowest(|o| o.cpu_s[1]),
        "now_slowest_wall_s": slowest(|o| o.wall_s),
    });
    write_json(&tables.join("lists.json"), &summary)
}
