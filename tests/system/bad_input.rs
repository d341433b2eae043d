//! Wrong input gives a clear error that names file, line and column, and exit code 1; wrong usage names the option
//! and gives exit code 2.

use pam_tests::{published, published_weights, run, small_csv, text};
use std::path::{Path, PathBuf};

const PAM: &str = env!("CARGO_BIN_EXE_pam-under-test");
const COLUMNS: &str =
    "time_s,displacement_mm,velocity_mm_s,pressure_flexor_kpa,pressure_extensor_kpa,force_n";

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn file(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, content).unwrap();
        path
    }

    /// Evaluates the published model on a file and returns the error message.
    fn evaluation_error(&self, data: &Path) -> String {
        self.error(&published_weights(), data)
    }

    fn error(&self, model: &Path, data: &Path) -> String {
        let out = self.0.path().join("out");
        let output = run(
            PAM,
            &["evaluate", "--model", text(model), "--data", text(data), "--out", text(&out)],
        );
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{message}");
        assert!(!message.contains("panicked"), "{message}");
        assert!(!out.exists(), "nothing is written: {message}");
        message
    }
}

#[track_caller]
fn assert_says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "`{part}` is missing in: {message}");
    }
}

fn csv(rows: &str) -> String {
    format!("{COLUMNS}\n{rows}")
}

#[test]
fn csv_columns_and_cells() {
    let f = Folder::new();
    let e = |name: &str, content: &str| f.evaluation_error(&f.file(name, content));
    assert_says(
        &e(
            "a.csv",
            "# note\ntime_s,displacement,velocity_mm_s,pressure_flexor_kpa,pressure_extensor_kpa,force_n\n0,0,0,1,1,0\n",
        ),
        &["a.csv:2", "`displacement_mm` is missing", "displacement,", "pam rig-file init"],
    );
    assert_says(
        &e("b.csv", &csv("0,0,0,400,400,0\n0.001,0,oops,400,400,0\n")),
        &["b.csv:3", "`velocity_mm_s`", "`oops`"],
    );
    assert_says(
        &e("c.csv", &csv("0,0,0,400,400,0\n0.001,0,0,NaN,400,0\n")),
        &["c.csv:3", "`pressure_flexor_kpa`", "NaN"],
    );
    assert_says(
        &e("d.csv", &csv("0,0,0,400,400,0\n0.001,0,0,4")),
        &["d.csv:3", "4 cells", "truncated"],
    );
    assert_says(
        &e("e.csv", &csv("0,0,0,400,400,0\n0.001,0,0,400,400,0\n0.001,0,0,400,400,0\n")),
        &["e.csv:4", "`time_s`", "repeated"],
    );
    assert_says(&e("f.csv", &csv("")), &["f.csv", "no data rows"]);
    assert_says(&e("g.csv", ""), &["g.csv", "empty"]);
    assert_says(&e("h.csv", &csv("0,0,0,400,400,0\n")), &["h.csv", "1 sample"]);
    assert_says(
        &e("i.csv", &csv("0,0,0,400,-400,0\n0.001,0,0,400,400,0\n")),
        &["i.csv", "pressure_extensor_kpa", "-400", "absolute"],
    );
}

#[test]
fn masses_must_be_positive_and_complete() {
    let f = Folder::new();
    let with = |header: &str| format!("{header}{}", csv("0,0,0,400,400,0\n0.001,0,0,400,400,0\n"));
    let e = |header: &str| f.evaluation_error(&f.file("m.csv", with(header)));
    assert_says(
        &e("# mass_flexor_g = -0.03\n# mass_extensor_g = 0.03\n"),
        &["m.csv:1", "mass_flexor_g", "positive"],
    );
    assert_says(
        &e("# mass_flexor_g = 0.03\n# mass_extensor_g = many\n"),
        &["m.csv:2", "mass_extensor_g", "many"],
    );
    assert_says(&e("# mass_flexor_g = 0.03\n"), &["m.csv", "give both"]);
}

fn raw(rows: &str) -> String {
    format!(
        "# Fs = 1000 (Hz)\n# frame\tx\tu\tcurrent\tp_res\tpd1\tpm1\tu1\tpd2\tpm2\tu2\tsync\n{rows}"
    )
}

fn raw_row(frame: usize) -> String {
    format!("{frame}\t0.8\t0.0\t0.02\t96\t0\t30.1\t-1\t0\t60.2\t-1\t0\n")
}

#[test]
fn raw_logs() {
    let f = Folder::new();
    let e = |content: &str| f.evaluation_error(&f.file("nn_3060", content));
    let rows = |range: std::ops::Range<usize>| range.map(raw_row).collect::<String>();
    assert_says(
        &e(&raw(&format!("{}{}{}", rows(0..5), raw_row(4), rows(5..9)))),
        &["nn_3060:8", "`frame`", "repeats frame 4"],
    );
    assert_says(
        &e(&raw(&format!(
            "{}{}",
            rows(0..3),
            "3\t0.8\t0.0\tx.y\t96\t0\t30.1\t-1\t0\t60.2\t-1\t0\n"
        ))),
        &["nn_3060:6", "`current`", "`x.y`"],
    );
    assert_says(
        &e(&raw(&format!(
            "{}{}",
            rows(0..3),
            "3\t0.8\t0.0\tnan\t96\t0\t30.1\t-1\t0\t60.2\t-1\t0\n"
        ))),
        &["nn_3060:6", "`current`", "NaN"],
    );
    assert_says(
        &e(&raw(&format!("{}3\t0.8\t0.0", rows(0..3)))),
        &["nn_3060:6", "3 cells", "truncated"],
    );
    assert_says(&e(&raw(&rows(0..50))), &["nn_3060", "50 rows", "search_from_row"]);
    assert_says(
        &e(&raw(&rows(0..9)).replace("current", "amps")),
        &["nn_3060:2", "`current` is missing", "amps"],
    );
    assert_says(&e(&raw("")), &["nn_3060", "no data rows"]);
}

#[test]
fn wrong_and_damaged_binary_files() {
    let f = Folder::new();
    let weights = std::fs::read(published_weights()).unwrap();
    let run_bytes = std::fs::read(published("data.mat")).unwrap();
    let data = published("data.mat");
    // Models in place of data and the other way round.
    assert_says(&f.evaluation_error(&published_weights()), &[".eqx", "a recording was expected"]);
    assert_says(&f.error(&data, &data), &["data.mat", "a model was expected"]);
    assert_says(
        &f.evaluation_error(&published("poly44_all_fits.mat")),
        &["poly44_all_fits.mat", "`x` is missing", "powers"],
    );
    assert_says(
        &f.evaluation_error(&published("koopman_model.npz")),
        &["koopman_model.npz", "`time_s`", "are missing", "X_mean"],
    );
    // Truncated.
    let cut = f.file("cut.eqx", &weights[..weights.len() / 2]);
    assert_says(&f.error(&cut, &data), &["cut.eqx", "record 3", "truncated"]);
    let cut = f.file("short.eqx", &weights[..weights.len() - 300]);
    assert_says(&f.error(&cut, &data), &["short.eqx"]);
    let cut = f.file("cut.mat", &run_bytes[..run_bytes.len() / 2]);
    assert_says(&f.evaluation_error(&cut), &["cut.mat", "truncated"]);
    let model = f.0.path().join("m.safetensors");
    assert!(run(PAM, &["convert", text(&published_weights()), text(&model)]).status.success());
    let bytes = std::fs::read(&model).unwrap();
    let cut = f.file("cut.safetensors", &bytes[..bytes.len() - 100]);
    assert_says(&f.error(&cut, &data), &["cut.safetensors", "truncated"]);
    // Garbage under the right names.
    assert_says(&f.error(&f.file("x.eqx", b"hello"), &data), &["x.eqx", "record 1"]);
    assert_says(&f.evaluation_error(&f.file("x.mat", b"hello")), &["x.mat", "MATLAB"]);
    assert_says(&f.evaluation_error(&f.file("x.npz", b"hello")), &["x.npz", "archive"]);
    assert_says(&f.error(&f.file("x.safetensors", b"hello"), &data), &["x.safetensors"]);
    assert_says(&f.evaluation_error(&f.file("x.bin", b"\x00\x01\x02")), &["x.bin", "not a file"]);
    assert_says(&f.evaluation_error(&f.file("empty", b"")), &["empty", "the file is empty"]);
}

/// A safetensors file that is no model of this joint.
fn safetensors(meta: &str, shape: &str, values: &[f64]) -> Vec<u8> {
    let header = format!(
        "{{\"__metadata__\":{{{meta}}},\"weight_0\":{{\"dtype\":\"F64\",\"shape\":{shape},\"data_offsets\":[0,{}]}}}}",
        8 * values.len()
    );
    let mut out = (header.len() as u64).to_le_bytes().to_vec();
    out.extend(header.bytes());
    out.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    out
}

#[test]
fn models_whose_inputs_do_not_match() {
    let f = Folder::new();
    let data = published("data.mat");
    let foreign = f.file("foreign.safetensors", safetensors("\"format\":\"pt\"", "[1]", &[1.0]));
    assert_says(
        &f.error(&foreign, &data),
        &["foreign.safetensors", "not a model of this framework"],
    );
    let meta = "\"format\":\"pam-model\",\"format_version\":\"1\",\"force\":\"mlp\",\
        \"inputs\":\"displacement_mm,velocity_mm_s\",\"output\":\"restoring_force_mn\"";
    let two = f.file("two.safetensors", safetensors(meta, "[1,2]", &[1.0, 2.0]));
    assert_says(&f.error(&two, &data), &["two.safetensors", "inputs", "mass_flexor_g"]);
    // Published format with a first layer of three inputs.
    let mut records = Vec::new();
    for (shape, len) in
        [("(2, 3)", 6), ("(2,)", 2), ("(1, 2)", 2), ("(1,)", 1), ("(3,)", 3), ("()", 1), ("()", 1)]
    {
        records.extend(npy(shape, len));
    }
    let three = f.file("three.eqx", records);
    assert_says(&f.error(&three, &data), &["three.eqx", "maps 3", "4 inputs"]);
}

/// A `.npy` record of ones.
fn npy(shape: &str, len: usize) -> Vec<u8> {
    let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}");
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut out = b"\x93NUMPY\x01\x00".to_vec();
    out.extend((header.len() as u16).to_le_bytes());
    out.extend(header.bytes());
    out.extend(std::iter::repeat_n(1.0_f64.to_le_bytes(), len).flatten());
    out
}

#[test]
fn npz_columns() {
    let f = Folder::new();
    let path = f.0.path().join("run.npz");
    let source = f.file("run.csv", small_csv(50));
    assert!(run(PAM, &["convert", text(&source), text(&path)]).status.success());
    let bytes = std::fs::read(&path).unwrap();
    let cut = f.file("cut.npz", &bytes[..bytes.len() / 2]);
    assert_says(&f.evaluation_error(&cut), &["cut.npz", "truncated"]);
}

#[test]
fn unreadable_paths_and_wrong_options() {
    let f = Folder::new();
    assert_says(&f.evaluation_error(Path::new("/nowhere/run.csv")), &["/nowhere/run.csv"]);
    let empty = f.0.path().join("nothing");
    std::fs::create_dir(&empty).unwrap();
    assert_says(&f.evaluation_error(&empty), &["nothing", "holds no recording"]);
    let data = published("data.mat");
    assert_says(&f.error(Path::new("/nowhere/m.eqx"), &data), &["/nowhere/m.eqx"]);
    let weights = published_weights();
    let with = |extra: &[&str]| {
        let out = f.0.path().join("out");
        let mut arguments =
            vec!["evaluate", "--model", text(&weights), "--data", text(&data), "--out", text(&out)];
        arguments.extend_from_slice(extra);
        let output = run(PAM, &arguments);
        assert!(!output.status.success());
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert_says(&with(&["--method", "rk9"]), &["rk9", "tsit5"]);
    assert_says(&with(&["--method", "rk4"]), &["rk4", "--step-ms"]);
    assert_says(&with(&["--step-ms", "-1"]), &["step-ms"]);
    assert_says(&with(&["--rtol", "0"]), &["rtol", "positive"]);
    assert_says(&with(&["--loader", "cutof_hz=3"]), &["cutof_hz", "cutoff_hz"]);
    assert_says(&with(&["--masses", "surfaces"]), &["data.mat", "surface"]);
    assert_says(&with(&["--activation", "swoosh"]), &["swoosh", "leaky_relu"]);
    let simulate = |extra: &[&str]| {
        let out = f.0.path().join("s.csv");
        let mut arguments = vec!["simulate", "--model", "spring-damper", "--out", text(&out)];
        arguments.extend_from_slice(extra);
        let output = run(PAM, &arguments);
        assert!(!output.status.success() && !out.exists());
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert_says(&simulate(&["--force", "square:A=1"]), &["square:A=1", "sine"]);
    assert_says(&simulate(&["--force", "sine:A=1"]), &["`f` is missing"]);
    assert_says(&simulate(&["--force", "sine:A=1,f=1,g=2"]), &["`g`"]);
    assert_says(&simulate(&["--force", "constant:A=1", "--duration", "0"]), &["duration"]);
    assert_says(&simulate(&["--force", "constant:A=1", "--air-masses", "0,0.1"]), &["positive"]);
    assert_says(&simulate(&["--force", "constant:A=1", "--pressures", "-3,400"]), &["positive"]);
    assert_says(&simulate(&[]), &["--force"]);
}

/// Wrong command lines, and a part of the error message.
const WRONG_USAGE: &[(&[&str], &str)] = &[
    (&["evaluat"], "evaluat"),
    (&["evaluate"], "--data"),
    (&["bench", "gradients"], "bench"),
    (&["--threads", "0", "doctor"], "at least one thread"),
    (&["evaluate", "--data", "x.csv", "--out", "o", "--method", "rk9"], "tsit5, "),
    (&["evaluate", "--data", "x.csv", "--out", "o", "--method", "rk4"], "--step-ms"),
    (
        &["evaluate", "--data", "x.csv", "--out", "o", "--method", "exact", "--rtol", "1e-3"],
        "--rtol",
    ),
    (&["evaluate", "--data", "x.csv", "--out", "o", "--step-ms", "-1"], "--step-ms"),
    (&["evaluate", "--data", "x.csv", "--out", "o", "--rtol", "0"], "--rtol"),
    (
        &["evaluate", "--data", "x.csv", "--out", "o", "--input", "spline"],
        "zoh, linear, ramp, cubic",
    ),
    (&["evaluate", "--data", "x.csv", "--out", "o", "--activation", "swoosh"], "leaky_relu"),
    (&["inspect", "x.csv", "--masses", "scales"], "auto, gas-law, surfaces"),
    (&["inspect", "x.csv", "--mat-pressure", "psi"], "auto, absolute, gauge"),
    (&["inspect", "x.csv", "--loader", "cutof_hz=3"], "cutoff_hz"),
    (&["simulate", "--out", "o.csv"], "--force"),
    (&["simulate", "--out", "o.csv", "--force", "square:A=1"], "sine"),
    (&["simulate", "--out", "o.csv", "--force", "constant:A=1", "--duration", "0"], "--duration"),
    (&["simulate", "--out", "o.csv", "--force", "constant:A=1", "--air-masses", "0,1"], "positive"),
    (&["simulate", "--out", "o.csv", "--force", "constant:A=1", "--pressures", "4"], "--pressures"),
    (&["gradient", "--data", "x.csv", "--out", "o.csv"], ".npz"),
    (&["gradient", "--data", "x.csv", "--out", "o.npz", "--loss", "hinge"], "huber, masked"),
    (
        &["gradient", "--data", "x.csv", "--out", "o.npz", "--loss", "squared:weights=1/1"],
        "length 4",
    ),
    (&["gradient", "--data", "x.csv", "--out", "o.npz", "--method", "guess"], "adjoint, forward"),
    (&["gradient", "--data", "x.csv", "--out", "o.npz", "--solver", "euler"], "tsit5"),
    (&["gradient", "--data", "x.csv", "--out", "o.npz", "--precision", "f16"], "f32, f64"),
    (
        &[
            "gradient",
            "--data",
            "x.csv",
            "--out",
            "o.npz",
            "--method",
            "exact",
            "--precision",
            "f32",
        ],
        "exact",
    ),
    (&["train", "recomended", "--data", "x.csv", "--out", "o"], "recommended, paper"),
    (&["train", "--print", "--set", "rates=1"], "unknown field `rates`"),
    (&["train", "--data", "x.csv", "--out", "o", "--resume"], "no run was begun"),
    (&["train", "--data", "x.csv", "--out", "o", "--checkpoint-s=-1"], "--checkpoint-s"),
    (
        &["diagnose", "--data", "x.csv", "--out", "o", "--effects", "warp"],
        "there is no effect `warp`",
    ),
    (&["diagnose", "--data", "x.csv", "--out", "o", "--max-effects", "0"], "at least 1"),
    (&["diagnose", "--data", "x.csv", "--out", "o", "--set", "search.beam=4"], "beam"),
    (&["plan", "--motion", "spiral:A=1", "--out", "o"], "spiral"),
    (&["plan", "--motion", "hold:x=0", "--stiffness", "-3", "--out", "o"], "positive"),
    (&["plan", "--motion", "hold:x=0", "--method", "newton", "--out", "o"], "auto, exact"),
    (&["stiffness", "--out", "o", "--reach", "-1"], "--reach"),
    (&["stiffness", "--out", "o", "--mass-bounds", "0.1"], "--mass-bounds"),
    (&["stiffness", "--out", "o", "--mass-bounds", "0.2,0.1"], "mass"),
    (&["track", "--out", "o", "--shapes", "square"], "sine, triangle"),
    (&["track", "--out", "o", "--series", "load"], "amplitude, frequency, stiffness"),
    (&["identify", "--out", "o", "--pulse-force", "0"], "--pulse-force"),
    (&["identify", "--out", "o", "--schedule", "ramp"], "staircase, cycle, compare"),
    (&["replan", "--out", "o", "--load", "inf"], "--load"),
    (&["rig", "record", "--out", "o", "--protocol", "papers"], "paper, validation"),
    (&["rig", "record", "--out", "o", "--conditions", "30-60"], "train, grid, symmetric"),
    (&["rig", "record", "--out", "o", "--effect", "coulomb"], "coulomb_friction"),
    (&["rig", "record", "--out", "o", "--ideal", "encoders"], "encoder, pressure-lag"),
    (&["rig", "protocol", "papers"], "paper, validation"),
    (&["ablate", "activation", "--out", "o"], "activations, stiffness"),
    (&["ablate", "activations", "--out", "o", "--shard", "3/2"], "shard"),
    (&["ablate", "activations", "--list", "--seeds", "1,1"], "--seeds"),
    (&["compare"], "CONFIG.toml"),
    (&["completions", "cmd"], "bash"),
];

#[test]
fn wrong_usage_ends_with_2_and_names_the_option() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, part) in WRONG_USAGE {
        let output = std::process::Command::new(PAM)
            .args(*arguments)
            .current_dir(folder.path())
            .output()
            .unwrap();
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.contains(part), "{arguments:?}: {message}");
        let left = std::fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(left, 0, "{arguments:?} writes nothing");
    }
}

#[test]
fn unwritable_output_is_an_error() {
    let f = Folder::new();
    let blocker = f.file("file", b"x");
    let out = blocker.join("out");
    let (weights, data) = (published_weights(), published("data.mat"));
    let arguments =
        ["evaluate", "--model", text(&weights), "--data", text(&data), "--out", text(&out)];
    let output = run(PAM, &arguments);
    assert_eq!(output.status.code(), Some(1));
    assert_says(&String::from_utf8_lossy(&output.stderr), &["file/out"]);
}
