//! The book: every page is in its summary and among the documentation tests, every link leads somewhere.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Targets of `[text](target)` outside code blocks.
fn links(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (k, outside) in text.split("```").enumerate() {
        if k % 2 == 1 {
            continue;
        }
        for piece in outside.split("](").skip(1) {
            if let Some((target, _)) = piece.split_once(')') {
                found.push(target.to_owned());
            }
        }
    }
    found
}

fn pages() -> BTreeSet<String> {
    std::fs::read_dir(root().join("docs"))
        .expect("the pages exist")
        .map(|entry| entry.expect("a readable folder").file_name().to_string_lossy().into_owned())
        .filter(|name| name.ends_with(".md") && name != "SUMMARY.md")
        .collect()
}

#[test]
fn every_page_is_in_the_summary_and_tested() {
    let summary: BTreeSet<String> =
        links(&read(&root().join("docs/SUMMARY.md"))).into_iter().collect();
    assert_eq!(summary, pages(), "docs/SUMMARY.md lists the files of docs/");
    let tested = read(&root().join("pam/src/lib.rs"));
    for page in pages() {
        assert!(tested.contains(&format!("docs/{page}")), "{page} is missing in pam/src/lib.rs");
    }
}

#[test]
fn every_link_leads_to_a_file() {
    let mut files: Vec<PathBuf> = pages().iter().map(|p| root().join("docs").join(p)).collect();
    files.extend([root().join("README.md"), root().join("CONTRIBUTING.md")]);
    let mut seen = 0;
    for file in files {
        for target in links(&read(&file)) {
            let path = target.split('#').next().unwrap_or_default();
            if path.is_empty() || path.contains("://") || path.starts_with("mailto:") {
                continue;
            }
            let there = file.parent().expect("a folder").join(path);
            assert!(there.exists(), "{}: {target} does not exist", file.display());
            seen += 1;
        }
    }
    assert!(seen > 40, "the pages link to each other: {seen}");
}

/// A recipe names a folder for the new file, the places of its lines, and an example that exists and is run.
#[test]
fn every_recipe_has_an_example_that_tests_run() {
    let text = read(&root().join("CONTRIBUTING.md"));
    let examples: Vec<String> =
        links(&text).into_iter().filter(|l| l.contains("/examples/")).collect();
    assert!(examples.len() >= 9, "{examples:?}");
    for example in examples {
        let (package, name) = example.split_once("/examples/").expect("PACKAGE/examples/NAME.rs");
        let manifest = read(&root().join(package).join("Cargo.toml"));
        let name = name.trim_end_matches(".rs");
        let entry = format!("[[example]]\nname = \"{name}\"\ntest = true\nharness = false\n");
        assert!(manifest.contains(&entry), "{package}/Cargo.toml runs example {name} as a test");
    }
}

/// Notebooks hold their outputs: every cell that prints or shows has one, and none is an error.
#[test]
fn notebooks_are_stored_with_their_outputs() {
    let mut count = 0;
    for entry in std::fs::read_dir(root().join("notebooks")).expect("there are notebooks") {
        let path = entry.expect("a readable folder").path();
        if path.extension().is_none_or(|e| e != "ipynb") {
            continue;
        }
        count += 1;
        let notebook: serde_json::Value = serde_json::from_str(&read(&path)).expect("JSON");
        let mut figures = 0;
        for cell in notebook["cells"].as_array().expect("cells") {
            let outputs = cell["outputs"].as_array().cloned().unwrap_or_default();
            figures += outputs
                .iter()
                .filter(|o| {
                    o["data"]["image/svg+xml"].is_array() || o["data"]["image/svg+xml"].is_string()
                })
                .count();
            for output in &outputs {
                assert_ne!(output["output_type"], "error", "{}: {output}", path.display());
                assert_ne!(output["name"], "stderr", "{}: {output}", path.display());
            }
        }
        assert!(figures > 0, "{}: no stored figure", path.display());
    }
    assert!(count >= 5, "{count} notebooks");
}
