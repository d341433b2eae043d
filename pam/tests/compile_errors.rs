//! What the compiler says to common mistakes.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The library that this test was built with.
fn library() -> (PathBuf, PathBuf) {
    let program = std::env::current_exe().expect("a running program has a path");
    let folder = program.parent().expect("in a folder").to_owned();
    let files = std::fs::read_dir(&folder).expect("the build's folder").flatten();
    let newest = files
        .filter(|f| {
            let name = f.file_name().to_string_lossy().into_owned();
            name.starts_with("libpam-") && name.ends_with(".rlib")
        })
        .max_by_key(|f| f.metadata().and_then(|m| m.modified()).ok());
    (newest.expect("the library was built").path(), folder)
}

/// The errors of a program.
fn errors_of(name: &str, body: &str) -> String {
    let (library, dependencies) = library();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let source = folder.join(format!("{name}.rs"));
    let text = format!(
        "#![allow(unused)]\nuse pam::prelude::*;\nuse pam::autodiff::ByTape;\nuse pam::solvers::Term;\n\
         use pam::solvers::sensitivity::{{DiscreteAdjoint, GradientMethod, Problem}};\n\
         use pam::effects::effects::AnyEffect;\nfn main() {{\n{body}\n}}\n"
    );
    std::fs::write(&source, text).expect("the folder is writable");
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(rustc)
        .args(["--edition", "2024", "--emit", "metadata", "--color", "never", "--extern"])
        .arg(format!("pam={}", library.display()))
        .arg("-L")
        .arg(format!("dependency={}", dependencies.display()))
        .arg("--out-dir")
        .arg(folder)
        .arg(&source)
        .output()
        .expect("the compiler runs");
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.success(), errors.is_empty(), "{errors}");
    errors
}

#[test]
fn mistakes_are_told_in_words_of_the_field() {
    // What is right compiles, so that what follows fails for its own reasons.
    let integrator =
        "let integrator = Integrator::new(Tableau::tsit5(), PidController::new(1e-6, 1e-6));\n";
    let right = "let field = field_fn!([4.0], 0 => 1, |_t, y, _u, p, dy| dy[0] = -p[0] * y[0]);\n\
                 let problem = Problem::new(&field, &[1.0], &[1.0], &integrator);\n\
                 let mut loss = |_: &[f64], y: &[f64], w: &mut [f64]| { w[0] = 1.0; y[0] };\n\
                 DiscreteAdjoint::new(ByTape).value_and_gradient(&problem, &mut loss);";
    assert_eq!(errors_of("right", &format!("{integrator}{right}")), "");

    for (name, body, said) in [
        (
            "closure_as_field",
            "integrator.solve(&Term::new(|t: f64| t, NoInput), 0.0, 1.0, &[1.0], SaveAt::End);",
            ["is no vector field over", "or wrap a closure: `FieldFn::new("],
        ),
        (
            "closure_to_differentiate",
            "let field = FieldFn::new(1, 0, |_t, y: &[f64], _u: &[f64], dy: &mut [f64]| dy[0] = -y[0]);\n\
             let problem = Problem::new(&field, &[1.0], &[1.0], &integrator);\n\
             let mut loss = |_: &[f64], y: &[f64], w: &mut [f64]| { w[0] = 1.0; y[0] };\n\
             DiscreteAdjoint::new(ByTape).value_and_gradient(&problem, &mut loss);",
            ["cannot be exchanged, so that it cannot be differentiated", "use `field_fn!`"],
        ),
        (
            "number_as_input",
            "let field = FieldFn::new(1, 1, |_t, y: &[f64], u: &[f64], dy: &mut [f64]| dy[0] = u[0]);\n\
             integrator.solve(&Term::new(field, 3.0), 0.0, 1.0, &[1.0], SaveAt::End);",
            ["is no input over", "`InputFn::new(inputs,"],
        ),
        (
            "text_as_scalar",
            "fn twice<S: Scalar>(x: S) -> S { x + x }\ntwice(String::new());",
            [
                "is no number that a model can run with",
                "scalars are `f64`, `f32`, the dual numbers",
            ],
        ),
        (
            "number_as_loss",
            "Training::new([]).with_loss(3.0);",
            ["is no loss of a trajectory", "loss_fn(|measured, predicted, cotangents| …)"],
        ),
        (
            "loss_of_one_number",
            "Training::new([]).with_loss(|error: f64| error * error);",
            ["closure is expected to take 3 arguments", "`TrajectoryLoss`"],
        ),
        (
            "effect_without_hooks",
            "struct Mine;\nlet effect: &dyn AnyEffect = &Mine;",
            ["is no effect", "implement `Effect`"],
        ),
        (
            "number_as_force",
            "let at = ForceInput { displacement_mm: 0.0, velocity_mm_s: 0.0, mass_flexor_g: 0.1, \
             mass_extensor_g: 0.1 };\nlinearise(&42.0, &at);",
            ["is no force model over", "for derivatives pass it with dual numbers"],
        ),
    ] {
        let errors = errors_of(name, &format!("{integrator}{body}"));
        for part in said {
            // The compiler breaks lines where it likes.
            let flat = errors.split_whitespace().collect::<Vec<_>>().join(" ");
            assert!(flat.contains(part), "{name} does not say {part:?}:\n{errors}");
        }
    }
}
