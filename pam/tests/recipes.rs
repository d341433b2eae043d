//! The recipes of `CONTRIBUTING.md`, carried out: every example's type becomes a file of its crate, with two
//! lines elsewhere. The names are then known in the library and on the command line, and the tests of the
//! crates that got a file pass.
//!
//! This compiles all crates once more, so it runs on request only. `.ci/run` runs the first of the two tests:
//! `cargo test --release --workspace --test recipes -- --ignored each_recipe`. The other one compiles and runs all tests
//! of the crates that got a file: `… -- --ignored the_tests`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A line that goes behind another one.
struct Line {
    file: &'static str,
    behind: &'static str,
    line: &'static str,
}

/// An example, the file that it becomes, and the two lines.
struct Recipe {
    example: &'static str,
    file: &'static str,
    lines: [Line; 2],
}

const fn line(file: &'static str, behind: &'static str, line: &'static str) -> Line {
    Line { file, behind, line }
}

const RECIPES: [Recipe; 9] = [
    Recipe {
        example: "pam-diagnose/examples/own_effect.rs",
        file: "pam-effects/src/effects/mechanics/quadratic_drag.rs",
        lines: [
            line(
                "pam-effects/src/effects/mechanics/mod.rs",
                "pub(super) mod hysteresis;",
                "pub(super) mod quadratic_drag;",
            ),
            line(
                "pam-effects/src/effects/mod.rs",
                "effects! {",
                "mechanics::quadratic_drag::QuadraticDrag,",
            ),
        ],
    },
    Recipe {
        example: "pam-core/examples/own_activation.rs",
        file: "pam-core/src/activation/mish.rs",
        lines: [
            line("pam-core/src/activation/mod.rs", "mod leaky_relu;", "mod mish;"),
            line(
                "pam-core/src/activation/mod.rs",
                "activations! {",
                "/** Mish. */ \"mish\" => Mish(mish::Mish),",
            ),
        ],
    },
    Recipe {
        example: "pam-core/examples/own_force.rs",
        file: "pam-core/src/force/hardening.rs",
        lines: [
            line("pam-core/src/force/mod.rs", "mod any;", "mod hardening;"),
            line(
                "pam-core/src/force/any.rs",
                "forces! {",
                "/** Hardening. */ \"hardening\" => Hardening(super::hardening::HardeningSpring<S>),",
            ),
        ],
    },
    Recipe {
        example: "pam-solvers/examples/own_tableau.rs",
        file: "pam-solvers/src/tableau/three_eighths.rs",
        lines: [
            line("pam-solvers/src/tableau/mod.rs", "mod rk4;", "mod three_eighths;"),
            line(
                "pam-solvers/src/tableau/mod.rs",
                "tableaux! {",
                "\"rk38\" => three_eighths::three_eighths,",
            ),
        ],
    },
    Recipe {
        example: "pam-solvers/examples/own_gradient_method.rs",
        file: "pam-solvers/src/sensitivity/complex_step.rs",
        lines: [
            line("pam-solvers/src/sensitivity/mod.rs", "mod continuous;", "mod complex_step;"),
            line(
                "pam-solvers/src/sensitivity/named.rs",
                "gradient_methods! {",
                "/** complex step */ \"complex_step\" => ComplexStep(complex_step::ComplexStepThroughSolver),",
            ),
        ],
    },
    Recipe {
        example: "pam-trajectory/examples/own_loss.rs",
        file: "pam-trajectory/src/loss/log_cosh.rs",
        lines: [
            line("pam-trajectory/src/loss/mod.rs", "mod huber;", "mod log_cosh;"),
            line(
                "pam-trajectory/src/loss/any.rs",
                "losses! {",
                "/** Log-cosh. */ LogCosh(log_cosh::LogCosh),",
            ),
        ],
    },
    Recipe {
        example: "pam-baselines/examples/own_baseline.rs",
        file: "pam-baselines/src/static_joint.rs",
        lines: [
            line("pam-baselines/src/lib.rs", "pub mod spring_damper;", "pub mod static_joint;"),
            line(
                "pam-baselines/src/registry.rs",
                "methods! {",
                "/** Static. */ \"static_joint\" => StaticJoint(crate::static_joint::StaticJoint),",
            ),
        ],
    },
    Recipe {
        example: "pam-cli/examples/own_command.rs",
        file: "pam-cli/src/commands/duration.rs",
        lines: [
            line("pam-cli/src/commands/mod.rs", "pub mod doctor;", "pub mod duration;"),
            line(
                "pam-cli/src/commands/mod.rs",
                "commands! {",
                "/** Time that recordings cover */ Duration(duration::DurationArguments),",
            ),
        ],
    },
    Recipe {
        example: "pam-data/examples/own_format.rs",
        file: "pam-data/src/formats/si_log.rs",
        lines: [
            line("pam-data/src/formats/mod.rs", "pub mod raw_log;", "pub mod si_log;"),
            line("pam-data/src/formats/list.rs", "formats! {", "super::si_log::SiLog,"),
        ],
    },
];

/// A program that names the entries in the lists of the library.
const NAMES: &str = "use pam::core::{Activation, AnyForce};\nfn main() {
    let _: &dyn pam::effects::effects::AnyEffect = &pam::effects::effects::QuadraticDrag;
    let _ = [Activation::Mish(Default::default())];
    let _: fn(_) -> AnyForce<f64> = AnyForce::Hardening;
    let _ = pam::trajectory::GradientChoice::ComplexStep;
    let _ = pam::trajectory::AnyLoss::LogCosh;
    let _ = pam::baselines::AnyMethod::StaticJoint;
}
";

/// A recording in the format of the recipe: 2 s at rest.
const SI_LOG: &str = "#SI\n0;0;0;412000;412000;0\n1;0;0;412000;412000;0\n2;0;0;412000;412000;0\n";

/// The part of an example that becomes the file: all before `main`, with the crate's own names.
fn file_of(example: &str, crate_name: &str) -> String {
    let text = example.split("\nfn main").next().expect("a part before main");
    text.replace(&format!("{crate_name}::"), "crate::")
}

fn insert(root: &Path, l: &Line) {
    let path = root.join(l.file);
    let text = std::fs::read_to_string(&path).expect("a file of the table");
    let anchor = format!("\n{}\n", l.behind);
    assert_eq!(text.matches(&anchor).count(), 1, "{}: {}", l.file, l.behind);
    let with = format!("{anchor}{}\n", l.line);
    std::fs::write(&path, text.replacen(&anchor, &with, 1)).expect("a copy is writable");
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("the workspace").flatten() {
        let name = entry.file_name();
        let hidden = name.to_string_lossy().starts_with('.');
        if hidden || ["target", "docs", "peers"].iter().any(|n| name == *n) {
            continue;
        }
        let (from, to) = (entry.path(), to.join(&name));
        if from.is_dir() {
            copy(&from, &to);
        } else {
            std::fs::copy(&from, &to).expect("a copy");
        }
    }
}

/// Cargo in the copy. It builds into the folder of this build, so that crates from outside the workspace are
/// there already; those of the workspace are optimised less, for a short build.
fn cargo(root: &Path, level: u8) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().expect("a folder of builds");
    command.current_dir(root).env("CARGO_TARGET_DIR", target);
    for entry in std::fs::read_dir(root).expect("the copy").flatten() {
        let manifest = std::fs::read_to_string(entry.path().join("Cargo.toml")).unwrap_or_default();
        let name = manifest.lines().find_map(|l| l.strip_prefix("name = \"")?.strip_suffix('"'));
        if let Some(name) = name {
            let level = format!("profile.release.package.{name}.opt-level={level}");
            command.args(["--config", &level]);
        }
    }
    command
}

/// A copy of the workspace with the recipes applied, and the crates they change.
fn carried_out(copy_name: &str) -> (PathBuf, BTreeSet<&'static str>) {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace");
    let root: PathBuf = Path::new(env!("CARGO_TARGET_TMPDIR")).join(copy_name);
    let _ = std::fs::remove_dir_all(&root);
    copy(workspace, &root);
    // The README and the book are parts of the documentation of `pam`.
    copy(&workspace.join("docs"), &root.join("docs"));
    let mut touched = BTreeSet::new();
    for recipe in &RECIPES {
        let example =
            std::fs::read_to_string(workspace.join(recipe.example)).expect(recipe.example);
        let package = recipe.file.split('/').next().expect("a crate");
        let to = root.join(recipe.file);
        assert!(!to.exists(), "{} is new", recipe.file);
        std::fs::write(to, file_of(&example, &package.replace('-', "_"))).expect("writable");
        recipe.lines.iter().for_each(|l| insert(&root, l));
        touched.insert(package);
    }
    (root, touched)
}

#[test]
#[ignore = "compiles the workspace once more"]
fn each_recipe_is_one_new_file_and_two_lines() {
    let (root, _) = carried_out("recipes");
    let example = root.join("pam/examples");
    std::fs::create_dir_all(&example).expect("a folder");
    std::fs::write(example.join("names.rs"), NAMES).expect("a copy is writable");
    let recording = root.join("run.log");
    std::fs::write(&recording, SI_LOG).expect("a copy is writable");

    // All of the workspace: features of crates from outside are then those of the build that is there.
    let built = cargo(&root, 0)
        .args(["build", "--release", "--workspace", "--example", "names", "--bin", "pam"])
        .args(["--offline", "--locked", "--quiet"])
        .status();
    assert!(built.expect("cargo runs").success(), "the library knows the names");
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().expect("a folder of builds");
    let run =
        Command::new(target.join("release").join(format!("pam{}", std::env::consts::EXE_SUFFIX)))
            .current_dir(&root)
            .args(["duration", "run.log", "--json"])
            .output()
            .expect("the command runs");
    let text = String::from_utf8_lossy(&run.stdout);
    let found: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(found["duration_s"], 2.0, "{text}{}", String::from_utf8_lossy(&run.stderr));
    let _ = std::fs::remove_dir_all(&root);
}

#[test]
#[ignore = "compiles the tests once more and runs them"]
fn the_tests_pass_with_the_recipes() {
    let (root, touched) = carried_out("recipes-tested");
    let tests = cargo(&root, 1)
        .args(["test", "--release", "--lib", "--bins", "--tests", "--offline", "--locked"])
        .arg("--no-fail-fast")
        .args(touched.iter().flat_map(|package| ["--package", package]))
        .status();
    assert!(tests.expect("cargo runs").success(), "the tests of {touched:?}");
    let _ = std::fs::remove_dir_all(&root);
}
