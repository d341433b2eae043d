//! Smooth against LeakyReLU activations: how `docs/experiments.md` comes by its table and figures.
//!
//! ```sh
//! for a in leaky_relu silu gelu softplus tanh; do
//!     pam train --data ideal --out act/$a --set model.activation=$a --set score_every=5
//! done
//! cargo run --release -p pam-bench --features figures --example activations -- act ideal docs
//! ```
//!
//! Each folder of the first argument is a run. The second argument is where the recordings are, the
//! third where the figures go.

use pam_core::{NamedChoice, ParametricForce};
use pam_data::conditions::{TRAINING_PSI, name_of};
use pam_data::{LoadOptions, collect_paths, open_recordings, subjects};
use pam_report::{LineFigure, Role, Scale};
use pam_solvers::{Interpolation, Tableau};
use pam_trajectory::engine::NetworkJoint;
use pam_trajectory::predict::{SolverSettings, StepChoice};
use pam_trajectory::{BatchedEngine, SquaredError, TrajectoryEngine, TrajectoryRequest, Windows};
use std::error::Error;
use std::path::{Path, PathBuf};

/// Recordings that gradients are compared on.
const RECORDINGS: usize = 4;
/// Factor of all weights where gradients are compared.
const PERTURBED: f64 = 1.02;
/// Tolerance of the reference.
const REFERENCE: f64 = 1e-8;

/// One row of `metrics.csv` that was scored: time of training (s), R² of x and v on held-out recordings.
type Scored = (f64, f64, f64);
/// Tolerance, error of the gradient relative to the one at [`REFERENCE`], evaluations of the network.
type AtTolerance = (f64, f64, usize);

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [runs, data, out] = &arguments[..] else {
        return Err("give a folder of runs, one of recordings, and one for the figures".into());
    };
    let mut folders: Vec<PathBuf> = std::fs::read_dir(runs)?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.join("model.safetensors").exists())
        .collect();
    folders.sort();
    let size = (1040, 380);
    let mut scores = LineFigure::new(
        "held-out recordings while training",
        "time of training (s)",
        "1 − R² of v",
        size.0,
        size.1,
    )
    .with_scales(Scale::Linear, Scale::Logarithmic);
    let mut errors = LineFigure::new(
        "gradient of the loss by tolerance, bs3",
        "tolerance",
        "relative error of the gradient",
        size.0,
        size.1,
    )
    .with_scales(Scale::Logarithmic, Scale::Logarithmic)
    .with_marks();
    println!(
        "| activation | time (s) | R² x | R² v | gradient at 1e-3 | 1e-5 | evaluations at 1e-3 | 1e-5 |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for (k, folder) in folders.iter().enumerate() {
        let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let scored = scored(&folder.join("metrics.csv"))?;
        let &(time, x, v) = scored.last().ok_or("train with --set score_every=5")?;
        let curve = scored.iter().map(|s| (s.0, 1.0 - s.2)).collect();
        scores = scores.with(&name, Role::Category(k), curve);
        let by_tolerance = gradient_errors(folder, Path::new(data))?;
        let at = |tolerance: f64| {
            by_tolerance.iter().find(|r| (r.0 / tolerance - 1.0).abs() < 1e-9).expect("a tolerance")
        };
        println!(
            "| {name} | {time:.1} | {x:.4} | {v:.4} | {:.1e} | {:.1e} | {} | {} |",
            at(1e-3).1,
            at(1e-5).1,
            at(1e-3).2,
            at(1e-5).2
        );
        let line = by_tolerance.iter().map(|r| (r.0, r.1)).collect();
        errors = errors.with(&name, Role::Category(k), line);
    }
    std::fs::write(Path::new(out).join("activations-r2.svg"), scores.to_svg())?;
    std::fs::write(Path::new(out).join("activations-gradient.svg"), errors.to_svg())?;
    Ok(())
}

fn scored(path: &Path) -> Result<Vec<Scored>, Box<dyn Error>> {
    let mut reader = csv::Reader::from_path(path)?;
    let header = reader.headers()?.clone();
    let column = |name: &str| {
        header.iter().position(|h| h == name).ok_or_else(|| format!("no column {name}"))
    };
    let [seconds, x, v] = [column("seconds")?, column("held_out_r2_x")?, column("held_out_r2_v")?];
    let (mut time, mut all) = (0.0, Vec::new());
    for row in reader.records() {
        let row = row?;
        time += row[seconds].parse::<f64>()?;
        if !row[x].is_empty() {
            all.push((time, row[x].parse()?, row[v].parse()?));
        }
    }
    Ok(all)
}

/// Gradients at the perturbed weights of a run, by tolerance.
fn gradient_errors(folder: &Path, data: &Path) -> Result<Vec<AtTolerance>, Box<dyn Error>> {
    let saved = pam_data::load_model(folder.join("model.safetensors"))?;
    let pam_core::AnyForce::Network(force) = &saved.model.force else {
        return Err("no network".into());
    };
    // At the trained weights the gradient is what noise leaves of it.
    let weights: Vec<f64> = force.parameters().iter().map(|w| PERTURBED * w).collect();
    let model: NetworkJoint = saved.model.clone().map(|v| v, |_| force.with_parameters(&weights));
    let names: Vec<String> =
        TRAINING_PSI.iter().rev().take(RECORDINGS).map(|c| name_of(*c)).collect();
    let mut recordings = Vec::new();
    for path in collect_paths(&[data.to_owned()])? {
        if names.iter().any(|n| path.file_name().is_some_and(|f| f.to_string_lossy() == **n)) {
            recordings.extend(open_recordings(&path, &LoadOptions::default())?);
        }
    }
    let windows = Windows::of(subjects(recordings, &model)?, None);
    let gradient = |tolerance: f64| -> Result<(Vec<f64>, usize), Box<dyn Error>> {
        let settings = SolverSettings {
            tableau: Tableau::from_name("bs3")?,
            step: StepChoice::Adaptive { rtol: tolerance, atol: tolerance },
            interpolation: Interpolation::from_name("ramp")?,
        };
        let found = BatchedEngine::<f64>::new(settings).value_and_gradient(
            &TrajectoryRequest::new(&model, &windows),
            &SquaredError::published(),
        )?;
        Ok((found.force, found.statistics.evaluations))
    };
    let (reference, _) = gradient(REFERENCE)?;
    let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let mut rows = Vec::new();
    for k in 4..=12 {
        let tolerance = 10.0_f64.powf(-0.5 * f64::from(k));
        let (found, evaluations) = gradient(tolerance)?;
        let error: Vec<f64> = found.iter().zip(&reference).map(|(a, b)| a - b).collect();
        rows.push((tolerance, norm(&error) / norm(&reference), evaluations));
    }
    Ok(rows)
}
