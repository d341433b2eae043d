//! The settings and their reference.

use pam_diagnose::DiagnosisSettings;
use std::path::Path;

fn parse(text: &str, changes: &[&str]) -> Result<DiagnosisSettings, String> {
    let changes: Vec<String> = changes.iter().map(|s| (*s).to_owned()).collect();
    DiagnosisSettings::parse(text, &changes).map_err(|e| e.to_string())
}

#[test]
fn wrong_settings_are_refused_with_the_known_keys() {
    let error = parse("", &["search.single=4"]).unwrap_err();
    assert!(error.contains("singles") && error.contains("`single`"), "{error}");
    let error = parse("[serch]\nsingles = 4", &[]).unwrap_err();
    assert!(error.contains("serch") && error.contains("search"), "{error}");
    for (change, says) in [
        ("search.singles=0", "`search.singles` must be from 1"),
        ("search.singles=four", "not a value of TOML"),
        ("verdict.named_share=1.5", "from 0 to 1"),
        ("singles=4", "a group and a name"),
        ("search.singles", "key=value"),
    ] {
        let error = parse("", &[change]).unwrap_err();
        assert!(error.contains(says), "{change}: {error}");
    }
}

#[test]
fn settings_survive_their_text() {
    let settings = parse("[residual]\ngroups = 8", &["fit.first_damping=1e-2"]).unwrap();
    let text = toml::to_string(&settings).unwrap();
    assert_eq!(parse(&text, &[]).unwrap(), settings);
    assert_eq!((settings.residual.groups, settings.fit.first_damping), (8, 1e-2));
}

/// `UPDATE_DOCS=1 cargo test -p pam-diagnose` writes the table of docs/diagnosis.md.
#[test]
fn the_reference_of_the_settings_is_current() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/diagnosis.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let (start, end) = ("settings_is_current` -->\n", "<!-- end of settings -->");
    let from = page.find(start).unwrap() + start.len();
    let to = page.find(end).unwrap();
    let wanted = format!("\n{}\n", DiagnosisSettings::reference());
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&path, format!("{}{wanted}{}", &page[..from], &page[to..])).unwrap();
    } else {
        assert!(page[from..to] == wanted, "the table is old: run the test with UPDATE_DOCS=1");
    }
}
