//! The picture of README and book: force over displacement of the published run, with the model's prediction before and after
//! the diagnosis, over the last cycle of the run. The errors in the titles are those of the held-out last third.
//!
//! ```sh
//! results real_run        # or its commands, see results/real_run.json
//! cargo run --release -p pam-bench --features figures --example real_run -- docs/real-run.svg
//! ```

use pam_data::{LoadOptions, Recording, read_recordings};
use pam_report::{LineFigure, Role};
use serde_json::Value;
use std::error::Error;
use std::path::Path;

/// Size of one panel, px.
const PANEL: (u32, u32) = (400, 330);
/// Frequency of the force in the run.
const FREQUENCY_HZ: f64 = 0.101;
/// Every how many samples a point is drawn.
const STRIDE: usize = 20;

fn main() -> Result<(), Box<dyn Error>> {
    let out = std::env::args().nth(1).ok_or("give the file to write")?;
    let diagnosis: Value =
        serde_json::from_str(&std::fs::read_to_string("target/real-run/diagnosis.json")?)?;
    let number = |pointer: &str| diagnosis.pointer(pointer).and_then(Value::as_f64);
    let rmse = |pointer: &str| number(pointer).ok_or("the diagnosis has errors of x");
    let measured = read("data/published/data.mat")?;
    let end_s = measured.time_s.last().copied().ok_or("the run has samples")?;
    let from_s = end_s - 1.0 / FREQUENCY_HZ;
    let panels = [
        (
            "Published model",
            "real-run-published",
            "model",
            Role::Category(0),
            rmse("/error_reduction/x/rmse_before")?,
        ),
        (
            "With the causes found",
            "real-run-extended",
            "extended model",
            Role::Predicted,
            rmse("/error_reduction/x/rmse_after")?,
        ),
    ];
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\">\n",
        2 * PANEL.0,
        PANEL.1
    );
    let predictions =
        panels.each_ref().map(|p| read(&format!("target/{}/predictions/data.csv", p.1)));
    let [model, extended] = predictions;
    let predictions = [model?, extended?];
    let displacements: Vec<f64> = predictions
        .iter()
        .flat_map(|predicted| points(&measured, predicted, from_s))
        .map(|(_, x)| x)
        .collect();
    for (k, (title, _, label, role, rmse_mm)) in panels.into_iter().enumerate() {
        let predicted = &predictions[k];
        let figure = LineFigure::new(
            &format!("{title}: error {rmse_mm:.2} mm"),
            "force (N)",
            "displacement (mm)",
            PANEL.0,
            PANEL.1,
        )
        .with("measured", Role::Measured, points(&measured, &measured, from_s))
        .with(label, role, points(&measured, predicted, from_s))
        .covering(displacements.iter().copied());
        let panel = figure.to_svg();
        let x = k as u32 * PANEL.0;
        svg += &panel.replacen("<svg ", &format!("<svg x=\"{x}\" "), 1);
        svg.push('\n');
    }
    svg += "</svg>\n";
    pam_data::atomic::write_atomic(Path::new(&out), svg.as_bytes())?;
    Ok(())
}

fn read(path: &str) -> Result<Recording, Box<dyn Error>> {
    let mut recordings = read_recordings([path], &LoadOptions::default())?;
    recordings.pop().ok_or_else(|| format!("{path} holds no recording").into())
}

/// Displacement over the measured force, from a time on.
fn points(measured: &Recording, shown: &Recording, from_s: f64) -> Vec<(f64, f64)> {
    let rows = measured.time_s.iter().zip(&measured.force_mn).zip(&shown.displacement_mm);
    rows.filter(|((t, _), _)| **t >= from_s)
        .step_by(STRIDE)
        .map(|((_, force_mn), x)| (force_mn / 1e3, *x))
        .collect()
}
