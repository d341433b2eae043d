//! The rig speaks the shared vocabulary, and a little beyond it.

use pam_rig::effects::{ALL, Group};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The vocabulary, from the folder of shared files.
fn vocabulary_file() -> PathBuf {
    let shared = std::env::var_os("PAM_SHARED")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"), PathBuf::from);
    shared.join("reference/effects.md")
}

/// Sections with their ids and parameters, as the tables of the vocabulary give them.
fn vocabulary() -> Vec<(String, String, Vec<String>)> {
    let path = vocabulary_file();
    let text = std::fs::read_to_string(&path)
        .unwrap_or_else(|e| panic!("{}: {e}; set PAM_SHARED to the shared files", path.display()));
    let quoted = |cell: &str| -> Vec<String> {
        cell.split('`').skip(1).step_by(2).map(str::to_owned).collect()
    };
    let mut section = String::new();
    let mut out = Vec::new();
    for line in text.lines() {
        if let Some(title) = line.strip_prefix("## ") {
            section = title.trim().to_owned();
        } else if let [_, id, parameters, ..] = line.split('|').collect::<Vec<_>>()[..]
            && let [id] = &quoted(id)[..]
        {
            out.push((section.clone(), id.clone(), quoted(parameters)));
        }
    }
    out
}

#[test]
fn every_listed_effect_is_there_with_its_parameters() {
    let vocabulary = vocabulary();
    assert!(vocabulary.len() >= 24, "only {} effects were read", vocabulary.len());
    for (section, id, parameters) in &vocabulary {
        let info = ALL.iter().find(|e| e.id == id).unwrap_or_else(|| panic!("`{id}` is missing"));
        let names: Vec<&str> = info.parameters.iter().map(|p| p.name).collect();
        assert_eq!(names, *parameters, "{id}");
        let group = match section.as_str() {
            "In the mechanics" => Group::Mechanics,
            "In the gas" => Group::Gas,
            "In actuation and sensing" => Group::Sensing,
            other => panic!("unknown section `{other}`"),
        };
        assert_eq!(info.group, group, "{id}");
    }
}

#[test]
fn what_is_not_listed_says_so() {
    let listed: Vec<String> = vocabulary().into_iter().map(|(_, id, _)| id).collect();
    let unlisted = ALL.iter().filter(|e| e.group == Group::Unlisted);
    assert!(unlisted.clone().count() >= 4);
    for effect in ALL {
        let is_listed = listed.iter().any(|id| id == effect.id);
        assert_eq!(is_listed, effect.group != Group::Unlisted, "{}", effect.id);
    }
    let mut ids: Vec<&str> = ALL.iter().map(|e| e.id).collect();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), ALL.len(), "an id is there twice");
}

/// Whoever adds an effect adds its test, of the same name and in the file of its group.
#[test]
fn every_effect_has_its_test() {
    let sources = BTreeMap::from([
        (Group::Mechanics.label(), include_str!("mechanics.rs")),
        (Group::Gas.label(), include_str!("gas.rs")),
        (Group::Sensing.label(), include_str!("sensing.rs")),
        (Group::Unlisted.label(), include_str!("unlisted.rs")),
    ]);
    for effect in ALL {
        let test = format!("#[test]\nfn {}() {{", effect.id);
        assert!(sources[effect.group.label()].contains(&test), "`{}` has no test", effect.id);
    }
}

/// Units are part of the names; a typical value lies within its limits, and the neutral one, too.
#[test]
fn parameters_have_units_and_limits() {
    const UNITS: [&str; 15] = [
        "_n", "_mm", "_kg", "_s", "_ms", "_hz", "_kpa", "_mg", "_mm_s", "_ns_m", "_n_mm", "_per_s",
        "_per_min", "relative", "exponent",
    ];
    for effect in ALL {
        for p in effect.parameters {
            let known =
                UNITS.iter().any(|unit| p.name.ends_with(unit)) || p.name.ends_with("_loss");
            assert!(known, "{}: `{}` has no unit", effect.id, p.name);
            let [low, high] = p.limits;
            for value in [Some(p.typical), p.neutral].into_iter().flatten() {
                assert!((low..=high).contains(&value), "{}: {value}", effect.id);
            }
        }
    }
}
