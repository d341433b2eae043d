use pam_baselines::ComparisonConfig;
use std::path::Path;

fn parse(text: &str) -> Result<ComparisonConfig, String> {
    ComparisonConfig::parse(text, Path::new("here/c.toml")).map_err(|e| e.to_string())
}

#[test]
fn defaults_names_and_paths() {
    let c = parse(
        "[data]\nrecordings = [\"logs\"]\n[[model]]\nkind = \"koopman\"\n[[model]]\nkind = \
         \"koopman\"\ndictionary = \"linear\"\n",
    )
    .unwrap();
    assert_eq!(c.name, "c");
    assert_eq!(c.data.recordings, [Path::new("here/logs")]);
    assert_eq!(c.evaluation.warm_up, 100);
    assert_eq!(c.models[1].name, "Koopman, linear");
}

#[test]
fn mistakes_are_told_with_their_line() {
    let data = "[data]\nrecordings = [\"logs\"]\n";
    for (text, line, part) in [
        (format!("{data}[[model]]\nkind = \"kopman\"\n"), 3, "koopman"),
        (format!("{data}[[model]]\nkind = \"koopman\"\nrigde = 1\n"), 3, "rigde"),
        (format!("{data}[[model]]\nkind = \"koopman\"\nridge = -1.0\n"), 3, "ridge"),
        (format!("{data}model = []\n"), 3, "unknown field"),
        ("[data]\nrecordings = 3\n".to_owned(), 2, "sequence"),
    ] {
        let message = parse(&text).unwrap_err();
        assert!(message.contains(&format!("c.toml:{line}:")), "{message}");
        assert!(message.contains(part), "{message}");
    }
    let twice = "[[model]]\nkind = \"koopman\"\n";
    assert!(parse(&format!("{data}{twice}{twice}")).unwrap_err().contains("name"));
}
