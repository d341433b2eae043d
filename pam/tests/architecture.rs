//! The architecture page is true: crates are layers, and the figures name code that exists.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Text elements of a figure with a class, in document order: height and text.
fn texts(figure: &str, class: &str) -> Vec<(f64, String)> {
    let marker = format!("class=\"{class}\"");
    figure
        .lines()
        .filter(|line| line.starts_with("<text") && line.contains(&marker))
        .map(|line| {
            let y = line.split(" y=\"").nth(1).and_then(|rest| rest.split('"').next());
            let text = line.split('>').nth(1).and_then(|rest| rest.split('<').next());
            let y = y.and_then(|y| y.parse().ok()).expect("a height");
            (y, text.expect("a text").to_owned())
        })
        .collect()
}

/// Crates of the workspace that a crate depends on, for other purposes than its tests.
fn dependencies(manifest: &str) -> Vec<String> {
    let section = manifest.split("[dependencies]").nth(1).unwrap_or_default();
    let section = section.split("\n[").next().unwrap_or_default();
    let names = section.lines().filter_map(|line| line.split(['.', ' ', '=']).next());
    names.filter(|name| name.starts_with("pam-")).map(str::to_owned).collect()
}

/// In the figure of the crates, every crate stands above those that it uses.
#[test]
fn crates_use_only_layers_below_them() {
    let figure = read(&root().join("docs/architecture.svg"));
    let height: BTreeMap<String, f64> =
        texts(&figure, "title").into_iter().map(|(y, name)| (name, y)).collect();
    let mut crates = 0;
    for entry in std::fs::read_dir(root()).expect("the workspace").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let manifest = entry.path().join("Cargo.toml");
        if !(name == "pam" || name.starts_with("pam-")) || !manifest.exists() {
            continue;
        }
        crates += 1;
        let own = height.get(&name).unwrap_or_else(|| panic!("{name} is not in the figure"));
        for used in dependencies(&read(&manifest)) {
            let below = height.get(&used).unwrap_or_else(|| panic!("{used} is not in the figure"));
            // Heights of an SVG grow downwards.
            assert!(below > own, "{name} uses {used}, which is not below it");
        }
    }
    assert_eq!(crates, height.len(), "the figure shows the crates of the workspace and no others");
}

/// Unit tests in a crate with `test = false` would silently not run.
#[test]
fn unit_tests_stand_where_they_are_run() {
    let mut checked = 0;
    for entry in std::fs::read_dir(root()).expect("the workspace").flatten() {
        let manifest = std::fs::read_to_string(entry.path().join("Cargo.toml")).unwrap_or_default();
        let library = manifest.split("[lib]").nth(1).unwrap_or_default();
        if !library.split("\n[").next().unwrap_or_default().contains("test = false") {
            continue;
        }
        checked += 1;
        let mut folders = vec![entry.path().join("src")];
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(&folder).expect("sources").flatten() {
                let path = entry.path();
                if path.is_dir() {
                    folders.push(path);
                } else {
                    let tests = read(&path).contains("#[cfg(test)]");
                    assert!(!tests, "{}: remove `test = false` from Cargo.toml", path.display());
                }
            }
        }
    }
    assert!(checked > 0, "some library has all its tests in its folder `tests`");
}

/// Code in figures is `path` or `path: item`; the file exists and has the item.
#[test]
fn figures_name_code_that_exists() {
    for figure in ["recording-through-diagnose.svg", "weight-through-gradient.svg"] {
        let named = texts(&read(&root().join("docs").join(figure)), "code");
        assert!(named.len() > 15, "{figure} names code");
        for (_, code) in named {
            let (path, item) = code.split_once(": ").map_or((code.as_str(), ""), |(p, i)| (p, i));
            let file = root().join(path);
            assert!(file.exists(), "{figure}: {path} does not exist");
            if !item.is_empty() {
                let text = read(&file);
                let defined = ["struct", "enum", "trait", "fn", "type"]
                    .iter()
                    .any(|kind| text.contains(&format!("{kind} {item}")));
                assert!(defined, "{figure}: {path} does not define {item}");
            }
        }
    }
}
