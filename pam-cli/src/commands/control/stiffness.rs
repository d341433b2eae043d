//! `pam stiffness`.

use super::BoundsOptions;
use crate::arguments::GlobalOptions;
use crate::commands::RunCommand;
use crate::console::{Console, table};
use crate::error::CliError;
use crate::options::{ModelOptions, describe_model};
use crate::output::Output;
use crate::run_record::{self, made_by, write_json};
use clap::Args;
use pam_control::report::stiffness_report;
use pam_control::stiffness::{ExactMap, Grid, map, profile, reachable};
use pam_core::SealedMasses;
use pam_data::atomic::write_atomic;
use serde_json::json;
use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

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

/// Masses of each muscle in the map.
const MASSES: usize = 13;
/// Displacements in the map, and in the range.
const PLACES: usize = 13;
const RANGE_PLACES: usize = 61;
/// Pressure in both muscles of profiles and polygons: the ends and the middle of the published range.
const PRESSURES_KPA: [f64; 3] = [170.27, 411.59, 652.91];
/// The maps of polygons reach at least to this velocity: that of the published excitation.
const LEAST_VELOCITY_MM_S: f64 = 20.0;
/// Points of a profile: close enough for kinks.
const PROFILE_POINTS: usize = 1201;

impl RunCommand for StiffnessArguments {
    fn outputs(&self) -> Vec<Output<'_>> {
        vec![Output::Folder("stiffness", &self.out)]
    }

    fn run(&self, global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        let saved = self.model.load(global.rig()?.as_ref())?;
        let settings = self.bounds.settings(&saved, global)?;
        let reach = self.reach;
        if !(reach.is_finite() && reach > 0.0) {
            return Err(CliError::Usage(format!(
                "--reach {reach}: it must be positive and finite"
            )));
        }
        let places = |n: usize| {
            (0..n).map(|k| reach * (2.0 * k as f64 / (n - 1) as f64 - 1.0)).collect::<Vec<_>>()
        };
        let bounds = settings.bounds;
        let mass = |k: usize| bounds.least_g + bounds.width_g() * k as f64 / (MASSES - 1) as f64;
        let pair = |flexor_g: f64, extensor_g: f64| SealedMasses { flexor_g, extensor_g };
        let masses = (0..MASSES).flat_map(|i| (0..MASSES).map(move |j| pair(mass(i), mass(j))));
        let velocities_mm_s = self.velocities.clone();
        let grid =
            Grid { displacements_mm: places(PLACES), velocities_mm_s, masses: masses.collect() };
        let h = settings.stiffness_step_mm;
        let ranges = reachable(&saved.model, &places(RANGE_PLACES), &self.velocities, settings)?;
        let points = map(&saved.model, &grid, h);
        let sealed = |kpa: f64| saved.model.gas_law_masses(0.0, [kpa; 2]);
        let fastest = self.velocities.iter().fold(LEAST_VELOCITY_MM_S, |m, v| m.max(v.abs()));
        let polygons: Vec<ExactMap> = PRESSURES_KPA
            .into_iter()
            .filter_map(|kpa| {
                let name = format!("{kpa:.0} kPa in both muscles at x = 0");
                ExactMap::new(&saved.model, name, sealed(kpa), [reach, fastest])
            })
            .collect();
        let profiles: Vec<_> = PRESSURES_KPA
            .into_iter()
            .map(|kpa| {
                let masses = sealed(kpa);
                let points = profile(&saved.model, masses, 0.0, [-reach, reach], PROFILE_POINTS, h);
                (format!("{kpa:.0} kPa in both muscles at x = 0, at rest, h = {h} mm"), points)
            })
            .collect();
        let out = &self.out;
        let mut text = String::from(
            "displacement_mm,velocity_mm_s,mass_flexor_g,mass_extensor_g,force_n,exact_n_mm,damping_kg_s,\
         forward_n_mm,central_n_mm,four_point_n_mm,richardson_n_mm\n",
        );
        for p in &points {
            let _ = writeln!(
                text,
                "{},{},{},{},{},{},{},{},{},{},{}",
                p.displacement_mm,
                p.velocity_mm_s,
                p.mass_flexor_g,
                p.mass_extensor_g,
                p.force_n,
                p.exact_n_mm,
                p.damping_kg_s,
                p.forward_n_mm,
                p.central_n_mm,
                p.four_point_n_mm,
                p.richardson_n_mm
            );
        }
        write_atomic(out.join("map.csv"), text.as_bytes())?;
        let mut text = String::from("displacement_mm,velocity_mm_s,least_n_mm,largest_n_mm\n");
        for r in &ranges {
            let [low, high] = r
                .stiffness_n_mm
                .map_or([String::new(), String::new()], |s| s.map(|v| v.to_string()));
            let _ = writeln!(text, "{},{},{low},{high}", r.displacement_mm, r.velocity_mm_s);
        }
        write_atomic(out.join("range.csv"), text.as_bytes())?;
        if !polygons.is_empty() {
            write_atomic(out.join("polygons.csv"), polygons_csv(&polygons).as_bytes())?;
        }
        let lead = format!("{} {}", saved.info.name, describe_model(&saved));
        let report = stiffness_report(&points, &profiles, &ranges, &polygons, &lead, &made_by());
        write_atomic(out.join("report.html"), report.as_bytes())?;
        let value = json!({ "reachable": ranges, "settings": settings, "made_by": made_by() });
        write_json(out.join("stiffness.json"), &value)?;
        let configuration = json!({
            "model": self.model.model,
            "reach_mm": reach,
            "velocities_mm_s": self.velocities,
            "settings": settings,
        });
        run_record::write(out, "stiffness", global.seed, &configuration)?;
        console.json(&value);
        let mut rows = vec![
            ["x (mm)", "v (mm/s)", "least (N/mm)", "largest (N/mm)"].map(str::to_owned).to_vec(),
        ];
        for r in ranges.iter().filter(|r| (r.displacement_mm / reach * 6.0).fract().abs() < 1e-9) {
            let cells = r
                .stiffness_n_mm
                .map_or(["–".into(), "–".into()], |s| s.map(|v| format!("{v:.1}")));
            let [low, high] = cells;
            rows.push(vec![
                format!("{:.2}", r.displacement_mm),
                format!("{}", r.velocity_mm_s),
                low,
                high,
            ]);
        }
        console.text(table(&rows));
        console.text(format!("\nreport: {}", out.join("report.html").display()));
        Ok(ExitCode::SUCCESS)
    }
}

/// One line a polygon; its corners as `x v` in mm and mm/s, one after the other.
fn polygons_csv(maps: &[ExactMap]) -> String {
    let mut text = String::from(
        "mass_flexor_g,mass_extensor_g,stiffness_n_mm,damping_kg_s,force_at_origin_n,area,corners\n",
    );
    for map in maps {
        for p in &map.partition.regions {
            let corners: Vec<String> = p.vertices.iter().map(|[x, v]| format!("{x} {v}")).collect();
            let _ = writeln!(
                text,
                "{},{},{},{},{},{},{}",
                map.masses.flexor_g,
                map.masses.extensor_g,
                1e-3 * p.force[1],
                p.force[2] + map.auxiliary_damping_kg_s,
                1e-3 * p.force[0],
                p.area,
                corners.join("; ")
            );
        }
    }
    text
}
