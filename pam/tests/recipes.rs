//! The recipes of `CONTRIBUTING.md`, carried out: every example's type becomes a file of its crate, with two
//! lines elsewhere, and the whole workspace compiles with the names known.
//!
//! Compiles all crates once more, so it runs on request only:
//! `cargo test --release --workspace --test recipes -- --ignored`.

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

const RECIPES: [Recipe; 7] = [
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
];

/// What the lists then hold, beside the names that they make of it.
const KNOWN: &str = "use pam::core::{Activation, AnyForce};\nfn main() {
    let _: &dyn pam::effects::effects::AnyEffect = &pam::effects::effects::QuadraticDrag;
    let _ = [Activation::Mish(Default::default())];
    let _: fn(_) -> AnyForce<f64> = AnyForce::Hardening;
    let _ = pam::trajectory::GradientChoice::ComplexStep;
    let _ = pam::train::AnyLoss::LogCosh;
    let _ = pam::baselines::AnyMethod::StaticJoint;
}
";

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

#[test]
#[ignore = "compiles the workspace once more"]
fn each_recipe_is_one_new_file_and_two_lines() {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace");
    let root: PathBuf = Path::new(env!("CARGO_TARGET_TMPDIR")).join("recipes");
    let _ = std::fs::remove_dir_all(&root);
    copy(workspace, &root);
    // The README and the book are parts of the documentation of `pam`.
    copy(&workspace.join("docs"), &root.join("docs"));
    for recipe in &RECIPES {
        let example =
            std::fs::read_to_string(workspace.join(recipe.example)).expect(recipe.example);
        let crate_name = recipe.file.split('/').next().expect("a crate").replace('-', "_");
        let to = root.join(recipe.file);
        assert!(!to.exists(), "{} is new", recipe.file);
        std::fs::write(to, file_of(&example, &crate_name)).expect("a copy is writable");
        recipe.lines.iter().for_each(|l| insert(&root, l));
    }
    let example = root.join("pam/examples");
    std::fs::create_dir_all(&example).expect("a folder");
    std::fs::write(example.join("names.rs"), KNOWN).expect("a copy is writable");

    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    // In the same folder, so that what does not belong to the workspace is there already.
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().expect("a folder of builds");
    let status = Command::new(cargo)
        .args(["check", "--release", "--workspace", "--bin", "pam", "--example", "names"])
        .args(["--offline", "--locked", "--quiet"])
        .current_dir(&root)
        .env("CARGO_TARGET_DIR", target)
        .status();
    assert!(status.expect("cargo runs").success(), "the workspace compiles with all recipes");
    let _ = std::fs::remove_dir_all(&root);
}
