//! Exact against finite-difference stiffness: how `docs/experiments.md` comes by its figures.
//!
//! ```sh
//! cargo run --release -p pam-bench --features figures --example stiffness -- KINKED SMOOTH docs
//! ```
//!
//! KINKED and SMOOTH are model files with networks. Prints the tables, writes the figures.

use num_dual::Dual64;
use pam_autodiff::finite_difference::{Central, DifferenceScheme, FourPointSmoothed, Richardson};
use pam_autodiff::{stiffness_by_difference_n_mm, stiffness_exact_n_mm};
use pam_core::units::{ATMOSPHERE_KPA, KPA_PER_PSI};
use pam_core::{AnyForce, ForceInput, NetworkForce, Scalar};
use pam_data::{SavedModel, load_model};
use pam_report::figure::{ColourMap, MapPoint, ValuePlane};
use pam_report::{LineFigure, Role, Scale};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use std::error::Error;
use std::path::Path;

/// Step of the source's published stiffness range, mm.
const PUBLISHED_STEP_MM: f64 = 1.0;
/// Points at which errors are averaged.
const POINTS: usize = 2000;

struct Network {
    name: &'static str,
    saved: SavedModel,
    network: NetworkForce<f64>,
    dual: NetworkForce<Dual64>,
}

impl Network {
    fn open(name: &'static str, path: &str) -> Result<Self, Box<dyn Error>> {
        let saved = load_model(Path::new(path))?;
        let AnyForce::Network(network) = &saved.model.force else {
            return Err(format!("{path} holds no network").into());
        };
        let (network, dual) = (network.clone(), network.map(Dual64::constant));
        Ok(Self { name, saved, network, dual })
    }

    fn at(&self, psi: [f64; 2], displacement_mm: f64, velocity_mm_s: f64) -> ForceInput<f64> {
        let kpa = psi.map(|p| p * KPA_PER_PSI + ATMOSPHERE_KPA);
        let masses = self.saved.model.gas_law_masses(0.0, kpa);
        ForceInput {
            displacement_mm,
            velocity_mm_s,
            mass_flexor_g: masses.flexor_g,
            mass_extensor_g: masses.extensor_g,
        }
    }

    fn exact(&self, at: &ForceInput<f64>) -> f64 {
        stiffness_exact_n_mm(&self.dual, at)
    }

    fn difference(&self, at: &ForceInput<f64>, scheme: &dyn DifferenceScheme) -> f64 {
        stiffness_by_difference_n_mm(&self.network, at, scheme)
    }

    fn published(&self, at: &ForceInput<f64>) -> f64 {
        self.difference(at, &FourPointSmoothed { h: PUBLISHED_STEP_MM })
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [kinked, smooth, out] = &arguments[..] else {
        return Err("give a kinked model, a smooth one, and a folder for the figures".into());
    };
    let subjects = [Network::open("LeakyReLU", kinked)?, Network::open("smooth", smooth)?];
    let write = |name: &str, svg: String| {
        std::fs::write(Path::new(out).join(format!("stiffness-{name}.svg")), svg)
    };
    write("line", along_x(&subjects))?;
    write("step", against_step(&subjects))?;
    for subject in &subjects {
        let [exact, published] = maps(subject);
        let file = if subject.name == "smooth" { "smooth" } else { "kinked" };
        write(&format!("map-{file}-exact"), exact)?;
        write(&format!("map-{file}-1mm"), published)?;
    }
    Ok(())
}

/// K over the displacement at 45/45 psi.
fn along_x(subjects: &[Network]) -> String {
    let mut figure = LineFigure::new(
        "stiffness over the displacement, 45/45 psi, standstill",
        "x (mm)",
        "K (N/mm)",
        1040,
        380,
    );
    println!(
        "| network | mean of \\|ΔK\\| from 0.01 mm to the next, exact | h = 1 mm | largest, exact | h = 1 mm |"
    );
    println!("|---|---|---|---|---|");
    for (k, subject) in subjects.iter().enumerate() {
        let xs: Vec<f64> = (-250..=250).map(|i| 0.01 * f64::from(i)).collect();
        let line = |f: &dyn Fn(&ForceInput<f64>) -> f64| -> Vec<f64> {
            xs.iter().map(|&x| f(&subject.at([45.0, 45.0], x, 0.0))).collect()
        };
        let (exact, published) = (line(&|at| subject.exact(at)), line(&|at| subject.published(at)));
        let jumps = |v: &[f64]| {
            let d: Vec<f64> = v.windows(2).map(|p| (p[1] - p[0]).abs()).collect();
            (d.iter().sum::<f64>() / d.len() as f64, d.iter().copied().fold(0.0, f64::max))
        };
        let ((me, le), (mp, lp)) = (jumps(&exact), jumps(&published));
        println!("| {} | {me:.3} | {mp:.3} | {le:.2} | {lp:.2} |", subject.name);
        for (what, values, role) in [
            ("exact", exact, Role::Category(2 * k)),
            ("h = 1 mm", published, Role::Category(2 * k + 1)),
        ] {
            let points = xs.iter().copied().zip(values).collect();
            figure = figure.with(&format!("{}, {what}", subject.name), role, points);
        }
    }
    figure.to_svg()
}

/// Difference from the exact derivative against the step, over random operating points.
fn against_step(subjects: &[Network]) -> String {
    let mut figure = LineFigure::new(
        "difference from the exact stiffness against the step",
        "h (mm)",
        "RMS difference (N/mm)",
        1040,
        420,
    )
    .with_scales(Scale::Logarithmic, Scale::Logarithmic);
    type Make = fn(f64) -> Box<dyn DifferenceScheme>;
    let schemes: [(&str, Make); 3] = [
        ("central", |h| Box::new(Central { h })),
        ("published", |h| Box::new(FourPointSmoothed { h })),
        ("Richardson", |h| Box::new(Richardson { h, ..Richardson::default() })),
    ];
    println!("\n| network | scheme | 1 mm | 0.1 mm | 1e-3 mm | 1e-5 mm | smallest, at h |");
    println!("|---|---|---|---|---|---|---|");
    for (k, subject) in subjects.iter().enumerate() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let points: Vec<ForceInput<f64>> = (0..POINTS)
            .map(|_| {
                let mut draw = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
                let psi = [draw(10.0, 80.0), draw(10.0, 80.0)];
                subject.at(psi, draw(-2.0, 2.0), draw(-10.0, 10.0))
            })
            .collect();
        let exact: Vec<f64> = points.iter().map(|at| subject.exact(at)).collect();
        for (s, (name, make)) in schemes.iter().enumerate() {
            let rms = |h: f64| {
                let scheme = make(h);
                let square = |(at, e): (&ForceInput<f64>, &f64)| {
                    (subject.difference(at, scheme.as_ref()) - e).powi(2)
                };
                (points.iter().zip(&exact).map(square).sum::<f64>() / POINTS as f64).sqrt()
            };
            let line: Vec<(f64, f64)> =
                (-32..=2).map(|i| 10.0_f64.powf(f64::from(i) / 4.0)).map(|h| (h, rms(h))).collect();
            let best = line.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1)).expect("points");
            println!(
                "| {} | {name} | {:.2} | {:.3} | {:.2e} | {:.1e} | {:.1e}, {:.0e} mm |",
                subject.name,
                rms(1.0),
                rms(0.1),
                rms(1e-3),
                rms(1e-5),
                best.1,
                best.0
            );
            let label = format!("{}, {name}", subject.name);
            figure = figure.with(&label, Role::Category(schemes.len() * k + s), line);
        }
    }
    figure.to_svg()
}

/// K at x = 0 and standstill over the plane of pressures, exact and by the published difference.
fn maps(subject: &Network) -> [String; 2] {
    let mut points: [Vec<MapPoint>; 2] = Default::default();
    let (mut square, mut worst) = (0.0, 0.0_f64);
    let grid: Vec<f64> = (0..15).map(|i| 10.0 + 5.0 * f64::from(i)).collect();
    for &f in &grid {
        for &e in &grid {
            let at = subject.at([f, e], 0.0, 0.0);
            let values = [subject.exact(&at), subject.published(&at)];
            square += (values[1] - values[0]).powi(2);
            worst = worst.max((values[1] - values[0]).abs());
            for (points, value) in points.iter_mut().zip(values) {
                points.push(MapPoint { x: f, y: e, value, ringed: false });
            }
        }
    }
    let range = |p: &[MapPoint]| {
        let values = p.iter().map(|p| p.value);
        (values.clone().fold(f64::MAX, f64::min), values.fold(f64::MIN, f64::max))
    };
    println!(
        "\n{}: K at x = 0 over the 225 conditions: exact {:.1?} N/mm, h = 1 mm {:.1?}; difference RMS \
         {:.2}, largest {worst:.2} N/mm",
        subject.name,
        range(&points[0]),
        range(&points[1]),
        (square / 225.0_f64).sqrt()
    );
    let titles = ["exact derivative", "difference, h = 1 mm"];
    let mut titles = titles.into_iter();
    points.map(|points| {
        ColourMap {
            plane: ValuePlane {
                title: format!("{}: {}", subject.name, titles.next().unwrap_or_default()),
                x_label: "flexor pressure (psi)".into(),
                y_label: "extensor pressure (psi)".into(),
                value_label: "K (N/mm)".into(),
                limits: (100.0, 200.0),
                size: (500, 420),
            },
            points,
            ring_label: String::new(),
        }
        .to_svg()
    })
}
