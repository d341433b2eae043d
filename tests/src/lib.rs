//! Helpers of the whole-system tests.

pub mod diagnose;
pub mod experiment;
pub mod fuzz;
pub mod laws;
pub mod loops;
pub mod magnitudes;
pub mod nulls;
pub mod pairs;
pub mod plant;
pub mod study;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Output};
use std::time::{Duration, Instant};

/// A file of the published reference data, `data/published` of the workspace.
#[must_use]
pub fn published(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/published").join(name)
}

/// The published weights.
#[must_use]
pub fn published_weights() -> PathBuf {
    published("hybrid_model_puresine_16.eqx")
}

/// A table as CSV.
///
/// # Errors
/// A sentence if a row cannot be written.
pub fn csv_text<R: serde::Serialize>(
    header: &[&str],
    rows: impl IntoIterator<Item = R>,
) -> Result<String, String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(header).map_err(|e| e.to_string())?;
    for row in rows {
        writer.serialize(row).map_err(|e| e.to_string())?;
    }
    let bytes = writer.into_inner().map_err(|e| e.to_string())?;
    String::from_utf8(bytes).map_err(|e| e.to_string())
}

/// Runs a program and returns what it printed.
///
/// # Panics
/// If it cannot be started.
#[must_use]
pub fn run(program: &str, arguments: &[&str]) -> Output {
    Command::new(program).args(arguments).output().expect("the program starts")
}

/// Standard output of a run that must succeed.
///
/// # Panics
/// If it did not.
#[must_use]
pub fn stdout_of(program: &str, arguments: &[&str]) -> String {
    let output = run(program, arguments);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?} failed: {errors}");
    String::from_utf8(output.stdout).expect("output is text")
}

/// How a child ended, if it does within `patience`; `None` if it still runs then.
///
/// # Panics
/// If it cannot be waited for.
#[must_use]
pub fn ended_within(child: &mut Child, patience: Duration) -> Option<ExitStatus> {
    let begun = Instant::now();
    loop {
        if let Some(status) = child.try_wait().expect("the child can be asked") {
            return Some(status);
        }
        if begun.elapsed() > patience {
            return None;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// A path as text for a command line.
///
/// # Panics
/// If it is no valid text.
#[must_use]
pub fn text(path: &Path) -> &str {
    path.to_str().expect("a path of plain text")
}

/// A standard CSV file of `samples` samples at 1 kHz: a slow oscillation with sealed masses.
#[must_use]
pub fn small_csv(samples: usize) -> String {
    let mut out = String::from(
        "# mass_flexor_g = 0.0765\n# mass_extensor_g = 0.0763\n\
         time_s,displacement_mm,velocity_mm_s,pressure_flexor_kpa,pressure_extensor_kpa,force_n\n",
    );
    for k in 0..samples {
        let t = k as f64 * 1e-3;
        let w = 6.0 * t;
        out += &format!(
            "{t},{},{},{},{},{}\n",
            0.3 * w.sin(),
            1.8 * w.cos(),
            412.0 - 4.0 * w.sin(),
            412.0 + 4.0 * w.sin(),
            55.0 * (w + 0.3).sin()
        );
    }
    out
}
