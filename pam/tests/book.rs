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

/// Anchors of the headings, as GitHub and mdBook make them.
fn headings(text: &str) -> BTreeSet<String> {
    let outside = text.split("```").step_by(2);
    let lines = outside.flat_map(str::lines).filter(|line| line.starts_with('#'));
    let anchor = |line: &str| -> String {
        let kept = line.trim_start_matches('#').trim().to_lowercase();
        kept.chars()
            .filter(|c| c.is_alphanumeric() || " -_".contains(*c))
            .map(|c| if c == ' ' { '-' } else { c })
            .collect()
    };
    lines.map(anchor).collect()
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
            if let Some((_, anchor)) = target.split_once('#')
                && path.ends_with(".md")
            {
                let headings = headings(&read(&there));
                assert!(
                    headings.contains(anchor),
                    "{}: {target} is no heading of {headings:?}",
                    file.display()
                );
            }
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
    files.extend(
        ["README.md", "CONTRIBUTING.md", "docs/studies/README.md"].map(|name| root().join(name)),
    );
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
        let (searched, shown) =
            (plain(&text), file.strip_prefix(root()).unwrap_or(&file).display());
        for (word, instead) in &prose {
            if searched.contains(&plain(word)) {
                found.push(format!("{shown}: `{word}`: {instead}"));
            }
        }
        for line in text.lines().map(str::trim_start).filter(|line| line.starts_with("pub ")) {
            let name = line.split(|c: char| !c.is_alphanumeric() && c != '_').find(|w| {
                ![
                    "pub", "const", "fn", "struct", "enum", "trait", "type", "mod", "static",
                    "unsafe",
                ]
                .contains(w)
            });
            for (word, instead) in names.iter().filter(|(word, _)| name == Some(word)) {
                found.push(format!("{shown}: the name `{word}`: {instead}"));
            }
        }
    }
    assert!(found.is_empty(), "words of .ci/words.txt:\n{}", found.join("\n"));
}

/// The reference of the commands is that of the program: `UPDATE_DOCS=1 cargo test -p pam-ode --test book` writes it.
#[test]
fn the_reference_of_the_commands_is_current() {
    let mut command = pam_cli::Arguments::with_exit_codes();
    command.build();
    let mut page = String::from(
        "<!-- Generated from the program; UPDATE_DOCS=1 cargo test -p pam-ode --test book writes it again. -->\n\n# Commands\n\n\
         `pam COMMAND --help` shows the same with examples. `pam parts` lists the names that options may take.\n\n\
         | exit code | meaning |\n|---|---|\n| 0 | success |\n| 1 | error in files, data or computation |\n| 2 | wrong usage |\n\
         | 3 | finished, but some recordings, samples or cells failed |\n| 130 | interrupted, can be resumed |\n\n\
         ## Options of every command\n\n",
    );
    page += &options(&command, true);
    for sub in command.get_subcommands().filter(|c| c.get_name() != "help" && !c.is_hide_set()) {
        reference(sub, "pam", &mut page);
    }
    let path = root().join("docs/commands.md");
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&path, &page).expect("the page can be written");
    }
    assert!(read(&path) == page, "docs/commands.md is old: run this test with UPDATE_DOCS=1");
}

fn reference(command: &clap::Command, parent: &str, page: &mut String) {
    let name = format!("{parent} {}", command.get_name());
    let about = command.get_long_about().or(command.get_about()).map(ToString::to_string);
    *page += &format!("\n## {name}\n\n{}\n\n", cell(&about.unwrap_or_default()));
    *page += &options(command, false);
    for sub in command.get_subcommands().filter(|c| c.get_name() != "help" && !c.is_hide_set()) {
        reference(sub, &name, page);
    }
}

/// A table of the arguments of a command, those of every command or the others.
fn options(command: &clap::Command, global: bool) -> String {
    let shown = |a: &&clap::Arg| {
        a.is_global_set() == global
            && !a.is_hide_set()
            && !["help", "version"].contains(&a.get_id().as_str())
    };
    let mut table = String::new();
    for argument in command.get_arguments().filter(shown) {
        let value = match argument.get_value_names() {
            Some(names) if argument.get_action().takes_values() => {
                let names: Vec<&str> = names.iter().map(|n| n.as_str()).collect();
                names.join(" ")
            }
            _ => String::new(),
        };
        let name = match argument.get_long() {
            Some(long) if value.is_empty() => format!("`--{long}`"),
            Some(long) => format!("`--{long} {value}`"),
            None => format!("`{value}`"),
        };
        let help = argument.get_long_help().or(argument.get_help()).map(ToString::to_string);
        let mut help = cell(&help.unwrap_or_default());
        let values = argument.get_possible_values();
        if argument.get_action().takes_values() && !values.is_empty() {
            let names: Vec<String> = values.iter().map(|v| format!("`{}`", v.get_name())).collect();
            help += &format!("; one of {}", names.join(", "));
        }
        let defaults: Vec<String> = argument
            .get_default_values()
            .iter()
            .map(|v| v.to_string_lossy().into_owned())
            .collect();
        if argument.get_action().takes_values() && !defaults.is_empty() {
            help += &format!(" (default `{}`)", defaults.join(" "));
        }
        table += &format!("| {} | {help} |\n", name.replace('|', "\\|"));
    }
    if table.is_empty() { table } else { format!("| option | meaning |\n|---|---|\n{table}") }
}

/// Help as a table cell: on one line, with Markdown's signs escaped outside of code.
fn cell(help: &str) -> String {
    let line = help.split_whitespace().collect::<Vec<_>>().join(" ");
    let escape = |(k, part): (usize, &str)| {
        let part = part.replace('|', "\\|");
        if k % 2 == 1 {
            part
        } else {
            part.replace('<', "&lt;").replace('*', "\\*").replace('[', "\\[")
        }
    };
    line.split('`').enumerate().map(escape).collect::<Vec<_>>().join("`")
}
