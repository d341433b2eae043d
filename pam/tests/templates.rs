//! The project templates are projects of their own: they stand outside the workspace, and one on vector fields brings few crates.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace").to_owned()
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("the template").flatten() {
        let (from, to) = (entry.path(), to.join(entry.file_name()));
        if from.is_dir() {
            copy(&from, &to);
        } else {
            std::fs::copy(&from, &to).expect("a copy");
        }
    }
}

/// A copy of a template elsewhere, as its README says to make one; versions are those of the workspace, so that nothing is
/// fetched.
fn project(template: &str, copy_name: &str) -> PathBuf {
    let root = Path::new(env!("CARGO_TARGET_TMPDIR")).join(copy_name);
    let _ = std::fs::remove_dir_all(&root);
    copy(&workspace().join("templates").join(template), &root);
    let manifest = root.join("Cargo.toml");
    let text = std::fs::read_to_string(&manifest).expect("a manifest");
    let outside = text.replace("\"../../", &format!("\"{}/", workspace().display()));
    std::fs::write(&manifest, outside).expect("a copy is writable");
    std::fs::copy(workspace().join("Cargo.lock"), root.join("Cargo.lock")).expect("a copy");
    root
}

fn cargo(root: &Path) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root);
    command
}

/// `fields` brings at most 40 crates from elsewhere, and none for files, tables or a rig.
#[test]
fn a_program_on_fields_brings_few_crates() {
    let root = project("own-system", "own-system-tree");
    let tree = cargo(&root)
        .args(["tree", "--offline", "--edges", "normal,build", "--prefix", "none"])
        .output()
        .expect("cargo runs");
    let text = String::from_utf8_lossy(&tree.stdout);
    assert!(tree.status.success(), "{}", String::from_utf8_lossy(&tree.stderr));
    let own = |line: &str| line.contains(&format!("({}", workspace().display()));
    let crates: BTreeSet<&str> = text
        .lines()
        .filter(|line| !line.is_empty() && !own(line) && !line.starts_with("own-system "))
        .map(|line| line.split(" (").next().unwrap_or(line))
        .collect();
    println!("{} crates: {crates:?}", crates.len());
    assert!((20..=40).contains(&crates.len()), "{} crates: {crates:?}", crates.len());
    for heavy in ["csv", "faer", "parquet", "toml", "zip"] {
        assert!(!crates.iter().any(|c| c.starts_with(&format!("{heavy} "))), "{heavy}");
    }
    let _ = std::fs::remove_dir_all(&root);
}

/// What stands in the templates compiles outside the workspace, with the features that their manifests ask for. It runs on
/// request only, since it checks the crates once more; `.ci/run` runs it.
#[test]
#[ignore = "checks the crates of the workspace once more"]
fn the_templates_compile_outside_the_workspace() {
    let manifest = std::fs::read_to_string(workspace().join("Cargo.toml")).expect("a manifest");
    // With the profiles of the workspace, crates from elsewhere are there already.
    let profiles = manifest.split_once("[profile.release]").expect("a profile").1;
    let config = Path::new(env!("CARGO_TARGET_TMPDIR")).join("profiles.toml");
    std::fs::write(&config, format!("[profile.release]{profiles}")).expect("a folder of builds");
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().expect("a folder of builds");
    for template in ["own-pam", "own-system"] {
        let root = project(template, &format!("{template}-outside"));
        let checked = cargo(&root)
            .env("CARGO_TARGET_DIR", target)
            .args(["check", "--release", "--offline", "--config"])
            .arg(&config)
            .output()
            .expect("cargo runs");
        let errors = String::from_utf8_lossy(&checked.stderr);
        assert!(checked.status.success(), "{template}: {errors}");
        assert!(!errors.contains("warning: unused"), "{template}: {errors}");
        let _ = std::fs::remove_dir_all(&root);
    }
}
