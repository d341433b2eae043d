//! `docs/effects.md` is generated from the table; `UPDATE_DOCS=1 cargo test -p pam-vocabulary` writes it.

use pam_vocabulary::{ALL, EffectInfo, Group, ParameterInfo};
use std::fmt::Write;
use std::path::Path;

const HEAD: &str = "\
<!-- Generated from pam-vocabulary; UPDATE_DOCS=1 cargo test -p pam-vocabulary writes it again. -->
# Effects

An effect is a known way in which a joint differs from its model. Use its id with the virtual rig (`pam rig record --effect`), the diagnosis
(`pam diagnose --effects`) and in files; reports show its plain name. An id never changes once it is released.

- The unit is part of a parameter's name. *log* marks positive scales that are fitted as logarithms.
- *Absent at* is the value at which a parameter contributes nothing. An effect is absent where all its parameters with such a value take it.
- A fit that ends at a limit of a range rejects the effect.
- Errors that no entry explains are reported as `unexplained`.

| id | plain name | acts in the |
|---|---|---|
";

fn parameter(p: &ParameterInfo) -> String {
    let [low, high] = p.range;
    let log = if p.logarithmic { ", log" } else { "" };
    let off = p.off.map_or("–".to_owned(), |off| off.to_string());
    format!("| `{}` | {low} … {high}{log} | {off} | {} |\n", p.name, p.meaning)
}

fn section(e: &EffectInfo) -> String {
    let (first, rest) = e.description.split_at(e.description.find(' ').unwrap_or(0));
    let mut first: Vec<char> = first.chars().collect();
    first[0] = first[0].to_ascii_uppercase();
    let title: String = first.into_iter().collect();
    let mut text = format!("\n### {}\n\n{title}{rest}. Excitation: {}.\n\n", e.id, e.excited_by);
    text += "| parameter | range | absent at | meaning |\n|---|---|---|---|\n";
    text.extend(e.parameters.iter().map(parameter));
    for s in e.switches {
        let _ = writeln!(text, "\nSwitch `{}`: {}.", s.name, s.meaning);
    }
    text
}

fn page() -> String {
    let mut text = HEAD.to_owned();
    for e in &ALL {
        let _ = writeln!(
            text,
            "| [{id}](#{id}) | {} | {} |",
            e.plain_name(),
            e.group.label(),
            id = e.id
        );
    }
    for (group, title) in [
        (Group::Mechanics, "In the mechanics"),
        (Group::Gas, "In the gas"),
        (Group::Sensing, "In actuation and sensing"),
    ] {
        let _ = writeln!(text, "\n## {title}");
        text.extend(ALL.iter().filter(|e| e.group == group).map(section));
    }
    text
}

#[test]
fn the_page_of_the_book_is_that_of_the_table() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/effects.md");
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&path, page()).unwrap();
    }
    let written = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(written == page(), "docs/effects.md differs from the table: run with UPDATE_DOCS=1");
}
