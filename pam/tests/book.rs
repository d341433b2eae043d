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

/// Words to avoid and what to use in their place: those of prose, and those of public names.
fn words() -> [Vec<(String, String)>; 2] {
    let text = read(&root().join(".ci/words.txt"));
    let (prose, names) = text.split_once("\nnames\n").expect("a line `names` between the lists");
    [prose, names].map(|list| {
        let lines = list.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
        let pair = |line: &str| {
            let (word, instead) = line.split_once(" => ").expect("`word => use instead`");
            (word.to_owned(), instead.to_owned())
        };
        lines.map(pair).collect()
    })
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a readable folder") {
        let path = entry.expect("a readable folder").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// Words of a text: letters, digits, `_` and `'`, in lower case, with one space between them, and one at either end.
fn plain(text: &str) -> String {
    let keep = |c: char| if c.is_alphanumeric() || "_'–".contains(c) { c } else { ' ' };
    let kept: String = text.replace("\n///", " ").replace("\n//!", " ").chars().map(keep).collect();
    let words: Vec<String> = kept.split_whitespace().map(str::to_lowercase).collect();
    format!(" {} ", words.join(" "))
}

/// Pages, help, reports and comments use the field's words, and so do public names.
#[test]
fn words_are_those_of_the_field() {
    let [prose, names] = words();
    let mut files: Vec<PathBuf> = pages().iter().map(|p| root().join("docs").join(p)).collect();
    files.extend(["README.md", "CONTRIBUTING.md"].map(|name| root().join(name)));
    for entry in std::fs::read_dir(root()).expect("a readable folder") {
        let path = entry.expect("a readable folder").path();
        if path.file_name().is_some_and(|n| n.to_string_lossy().starts_with("pam")) {
            let folder = path.join("src");
            if folder.is_dir() {
                sources(&folder, &mut files);
            }
        }
    }
    assert!(files.len() > 300, "{} files", files.len());
    let mut found = Vec::new();
    for file in files {
        let text = read(&file);
        let (searched, shown) = (plain(&text), file.strip_prefix(root()).unwrap_or(&file).display());
        for (word, instead) in &prose {
            if searched.contains(&plain(word)) {
                found.push(format!("{shown}: `{word}`: {instead}"));
            }
        }
        for line in text.lines().map(str::trim_start).filter(|line| line.starts_with("pub ")) {
            let name = line
                .split(|c: char| !c.is_alphanumeric() && c != '_')
                .find(|w| !["pub", "const", "fn", "struct", "enum", "trait", "type", "mod", "static", "unsafe"].contains(w));
            for (word, instead) in names.iter().filter(|(word, _)| name == Some(word)) {
                found.push(format!("{shown}: the name `{word}`: {instead}"));
            }
        }
    }
    assert!(found.is_empty(), "words of .ci/words.txt:\n{}", found.join("\n"));
}
