//! `pam gradient` against differences of predictions, against itself by other ways, and on bad input.

use approx::assert_relative_eq;
use pam_core::units::{ATMOSPHERE_KPA, KPA_PER_PSI};
use pam_core::{AnyForce, JointModel, ParametricForce};
use pam_data::formats::npz::{self, Array};
use pam_data::models::save_model;
use pam_data::{LoadOptions, Recording, SavedModel, load_model, open_recordings};
use pam_solvers::{Interpolation, Tableau};
use pam_tests::{published_weights, run, stdout_of, text};
use pam_trajectory::{SolverSettings, StepChoice, predict};
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

const PAM: &str = env!("CARGO_BIN_EXE_pam-under-test");
const STEPS: [&str; 6] = ["--solver", "rk4", "--step-ms", "5", "--input", "linear"];

/// Two short runs of the published model, and the model with every network number × 1.02 and raw m
/// × 1.05.
struct Bench {
    folder: tempfile::TempDir,
    model: PathBuf,
    runs: Vec<PathBuf>,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let weights = published_weights();
        let mut saved = load_model(&weights).unwrap();
        let runs = [(30.0, 60.0), (45.0, 45.0)]
            .map(|(flexor, extensor)| {
                let out = folder.path().join(format!("run_{flexor}.npz"));
                let kpa = |psi: f64| psi * KPA_PER_PSI + ATMOSPHERE_KPA;
                let pressures = format!("{},{}", kpa(flexor), kpa(extensor));
                let force = ["--force", "sine:A=130,f=1.3", "--duration", "1.5"];
                let mut arguments = vec!["simulate", "--model", text(&weights), "--quiet"];
                arguments.extend(force);
                arguments.extend(["--pressures", &pressures, "--out", text(&out)]);
                assert!(run(PAM, &arguments).status.success());
                out
            })
            .to_vec();
        saved.model = saved.model.map(|v| v, |force| force.map(|w| 1.02 * w));
        saved.model.raw.mass *= 1.05;
        let model = folder.path().join("perturbed.safetensors");
        save_model(&model, &saved).unwrap();
        Self { folder, model, runs }
    }

    fn arguments<'a>(&'a self, out: &'a Path, more: &[&'a str]) -> Vec<&'a str> {
        let mut arguments = vec!["gradient", "--model", text(&self.model), "--out", text(out)];
        arguments.push("--data");
        arguments.extend(self.runs.iter().map(|r| text(r)));
        arguments.extend(more);
        arguments
    }

    /// The arrays that the command writes.
    fn gradient(&self, more: &[&str]) -> BTreeMap<String, Array> {
        let out = self.folder.path().join("gradient.npz");
        let _ = stdout_of(PAM, &self.arguments(&out, &[&STEPS, more].concat()));
        npz::read(&out).unwrap()
    }

    fn saved(&self) -> SavedModel {
        load_model(&self.model).unwrap()
    }

    fn recordings(&self) -> Vec<Recording> {
        self.runs
            .iter()
            .flat_map(|path| open_recordings(path, &LoadOptions::default()).unwrap())
            .collect()
    }
}

/// The paper's loss, written out, of predictions by the ordinary four-state solve.
fn paper_loss(model: &JointModel<f64, AnyForce<f64>>, recordings: &[Recording]) -> f64 {
    let settings = SolverSettings {
        tableau: Tableau::rk4(),
        step: StepChoice::Constant { step_s: 5e-3 },
        interpolation: Interpolation::Linear,
    };
    let one = |r: &Recording| {
        let masses = r.given_masses.expect("simulated runs carry their masses");
        let p = predict(model, r, masses, &settings).unwrap().channels;
        let mean = |a: &[f64], b: &[f64]| {
            a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() / a.len() as f64
        };
        100.0 * (mean(&p.x, &r.displacement_mm) + mean(&p.v, &r.velocity_mm_s))
            + mean(&p.pf, &r.pressure_flexor_kpa)
            + mean(&p.pe, &r.pressure_extensor_kpa)
    };
    recordings.iter().map(one).sum::<f64>() / recordings.len() as f64
}

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn relative(a: &Array, b: &Array) -> f64 {
    assert_eq!(a.shape, b.shape);
    let difference: Vec<f64> = a.values.iter().zip(&b.values).map(|(a, b)| a - b).collect();
    norm(&difference) / norm(&b.values)
}

#[test]
fn the_gradient_is_the_slope_of_the_loss() {
    let bench = Bench::new();
    let gradient = bench.gradient(&["--loss", "paper"]);
    let model = bench.saved().model;
    let recordings = bench.recordings();
    let value = gradient["loss"].values[0];
    // The command takes pressures from the gas law; the four-state solve integrates them.
    assert_relative_eq!(value, paper_loss(&model, &recordings), max_relative = 1e-6);

    // Shapes are those of the model file.
    assert_eq!(gradient["grad_weight_0"].shape, [96, 4]);
    assert_eq!(gradient["grad_weight_1"].shape, [96, 96]);
    assert_eq!(gradient["grad_weight_2"].shape, [1, 96]);
    assert_eq!(gradient["grad_bias_1"].shape, [96]);
    assert_eq!(gradient["grad_raw"].shape, [3]);

    // Along each array of the gradient, and along the raw parameters one by one.
    let along = |name: &str, h: f64| {
        let direction = &gradient[&format!("grad_{name}")];
        let size = norm(&direction.values);
        let moved = |h: f64| {
            let mut parts = model.force.to_parts();
            for (tensor, t) in parts.tensors.iter_mut() {
                if tensor == name {
                    for (w, d) in t.values.iter_mut().zip(&direction.values) {
                        *w += h * d / size;
                    }
                }
            }
            let force = AnyForce::from_parts(model.force.kind(), &parts).unwrap();
            paper_loss(&model.map(|v| v, |_| force.clone()), &recordings)
        };
        ((moved(h) - moved(-h)) / (2.0 * h), size)
    };
    for (name, h) in [
        ("weight_0", 1e-5),
        ("weight_1", 1e-4),
        ("weight_2", 1e-4),
        ("bias_0", 1e-4),
        ("bias_1", 1e-2),
        ("bias_2", 1e-1),
    ] {
        let (slope, size) = along(name, h);
        assert_relative_eq!(slope, size, max_relative = 2e-4);
    }
    for (i, h) in [1e-3, 1e3, 1e-4].into_iter().enumerate() {
        let moved = |h: f64| {
            let mut model = model.clone();
            *[&mut model.raw.mass, &mut model.raw.gas_coefficient, &mut model.raw.deformation]
                [i] += h;
            paper_loss(&model, &recordings)
        };
        let slope = (moved(h) - moved(-h)) / (2.0 * h);
        assert_relative_eq!(gradient["grad_raw"].values[i], slope, max_relative = 2e-4);
    }
    assert_eq!(model.force.parameter_len(), 4 * 96 + 96 + 96 * 96 + 96 + 96 + 1);
}

#[test]
fn ways_and_losses_agree() {
    let bench = Bench::new();
    let paper = bench.gradient(&["--method", "adjoint", "--threads", "1"]);
    let both = bench.gradient(&["--threads", "2", "--repeat", "2"]);
    for (name, array) in &paper {
        if name != "value_and_grad_s" {
            assert_eq!(array, &both[name], "{name} is the same bits at 1 and 2 threads");
        }
    }
    let published = bench.gradient(&["--loss", "published"]);
    for name in ["loss", "grad_weight_1", "grad_raw"] {
        for (full, half) in paper[name].values.iter().zip(&published[name].values) {
            assert_relative_eq!(*half, 0.5 * full, max_relative = 1e-12);
        }
    }
    // The tape differentiates the four-state solve, whose pressures are integrated.
    let tape = bench.gradient(&["--method", "tape"]);
    let single = bench.gradient(&["--precision", "f32"]);
    for name in paper.keys().filter(|n| n.starts_with("grad_")) {
        assert!(relative(&paper[name], &tape[name]) < 1e-4, "{name} by tape");
        assert!(relative(&single[name], &paper[name]) < 1e-3, "{name} in single precision");
    }
}

/// Adds an array of strings to an archive, as NumPy writes them: four bytes a code point, padded.
fn add_texts(path: &Path, name: &str, texts: &[&str]) {
    let width = texts.iter().map(|t| t.chars().count()).max().unwrap();
    let mut header =
        format!("{{'descr': '<U{width}', 'fortran_order': False, 'shape': ({},), }}", texts.len());
    while !(10 + header.len() + 1).is_multiple_of(64) {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    for text in texts {
        let padded = text.chars().chain(std::iter::repeat('\0')).take(width);
        bytes.extend(padded.flat_map(|c| (c as u32).to_le_bytes()));
    }
    let file = std::fs::File::options().read(true).write(true).open(path).unwrap();
    let mut archive = zip::ZipWriter::new_append(file).unwrap();
    let options = zip::write::SimpleFileOptions::default();
    archive.start_file(format!("{name}.npy"), options).unwrap();
    archive.write_all(&bytes).unwrap();
    archive.finish().unwrap();
}

#[test]
fn errors_are_measured_against_a_reference() {
    let bench = Bench::new();
    let recordings = bench.recordings();
    let reference = bench.folder.path().join("reference.npz");
    let measure = |arrays: BTreeMap<String, Array>| {
        npz::write(&reference, &arrays).unwrap();
        bench.gradient(&["--reference", text(&reference)])["x_error_mm"].values[0]
    };
    let x: Vec<Vec<f64>> = recordings.iter().map(|r| r.displacement_mm.clone()).collect();
    let together = Array { shape: vec![2, x[0].len() as u64], values: x.concat() };
    let error = measure([("x".to_owned(), together)].into());
    let named = x.iter().enumerate().map(|(i, x)| (format!("x_{i}"), Array::vector(x.clone())));
    assert_eq!(error, measure(named.collect()));
    // Rows by name, in another order, and one too many.
    let rows = [x[1].clone(), vec![9e9; x[0].len()], x[0].clone()];
    let names = [&recordings[1].name, "another", &recordings[0].name];
    let swapped = bench.folder.path().join("swapped.npz");
    let table = Array { shape: vec![3, x[0].len() as u64], values: rows.concat() };
    npz::write(&swapped, &[("x".to_owned(), table)].into()).unwrap();
    add_texts(&swapped, "names", &names);
    assert_eq!(error, bench.gradient(&["--reference", text(&swapped)])["x_error_mm"].values[0]);
    // What it must be: the largest difference of an ordinary prediction.
    let settings = SolverSettings {
        tableau: Tableau::rk4(),
        step: StepChoice::Constant { step_s: 5e-3 },
        interpolation: Interpolation::Linear,
    };
    let largest = recordings
        .iter()
        .flat_map(|r| {
            let p = predict(&bench.saved().model, r, r.given_masses.unwrap(), &settings).unwrap();
            p.channels.x.into_iter().zip(r.displacement_mm.clone()).map(|(a, b)| (a - b).abs())
        })
        .fold(0.0, f64::max);
    assert_relative_eq!(error, largest, max_relative = 1e-9);

    npz::write(&reference, &[("x".to_owned(), Array::vector(vec![0.0; 7]))].into()).unwrap();
    let out = bench.folder.path().join("none.npz");
    let output = run(PAM, &bench.arguments(&out, &["--reference", text(&reference)]));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success() && message.contains("reference.npz"), "{message}");
    assert!(message.contains("[7]") && !out.exists(), "{message}");
}

#[test]
fn the_report_and_json_tell_the_same() {
    let bench = Bench::new();
    let (out, report) =
        (bench.folder.path().join("g.npz"), bench.folder.path().join("report.html"));
    let more = [&STEPS[..], &["--report", text(&report), "--json"]].concat();
    let told: Value = serde_json::from_str(&stdout_of(PAM, &bench.arguments(&out, &more))).unwrap();
    let arrays = npz::read(&out).unwrap();
    assert_eq!(told["loss"].as_f64(), Some(arrays["loss"].values[0]));
    assert_relative_eq!(
        told["gradient_norm"]["weight_1"].as_f64().unwrap(),
        norm(&arrays["grad_weight_1"].values),
        max_relative = 1e-12
    );
    assert_eq!(told["accepted_steps"], 2 * 300);
    let page = std::fs::read_to_string(&report).unwrap();
    assert!(page.contains("weight_1") && page.contains("<svg") && page.contains("run_30"));
}

/// A loss as a curriculum writes it: the squared error with the weights of `paper`, and a Huber loss whose
/// thresholds no error reaches, are `paper`.
#[test]
fn every_loss_can_be_asked_for() {
    let bench = Bench::new();
    let of = |loss: &str| {
        let arrays = bench.gradient(&["--loss", loss]);
        (arrays["loss"].values[0], arrays["grad_weight_0"].values.clone())
    };
    let (paper, gradient) = of("paper");
    assert_eq!(of("squared:weights=100/100/1/1"), (paper, gradient.clone()));
    let far = "huber:form=huber,thresholds=1e9/1e9/1e9/1e9,weights=100/100/1/1";
    assert_eq!(of(far), (paper, gradient));
    let (scaled, _) = of("masked:every=1,of=squared:weights=50/50/0.5/0.5");
    assert_relative_eq!(scaled, 0.5 * paper, max_relative = 1e-12);
}

#[test]
fn wrong_requests_are_told() {
    let bench = Bench::new();
    let out = bench.folder.path().join("none.npz");
    for (more, words) in [
        (&["--loss", "square"][..], "paper, published"),
        (&["--method", "guess"], "adjoint, forward"),
        (&["--solver", "euler"], "tsit5"),
        (&["--solver", "rk4"], "--step-ms"),
        (&["--method", "tape", "--precision", "f32"], "--precision f32"),
        (&["--repeat", "0"], "--repeat"),
        (&["--step-ms", "-1"], "step-ms"),
        (&["--rtol", "1e-300", "--atol", "1e-300"], "no recording could be predicted"),
    ] {
        let output = run(PAM, &bench.arguments(&out, more));
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && message.contains(words), "{more:?}: {message}");
        assert!(!out.exists(), "{more:?} writes nothing");
    }
    let other = bench.folder.path().join("gradient.csv");
    let output = run(PAM, &bench.arguments(&other, &[]));
    assert!(String::from_utf8(output.stderr).unwrap().contains(".npz"));
}
