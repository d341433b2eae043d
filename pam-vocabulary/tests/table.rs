//! The table holds the published vocabulary, and every entry is complete.

use pam_vocabulary::{ALL, Group, by_id};
use std::path::{Path, PathBuf};

/// Suffixes of parameters that carry a unit, and the dimensionless ones.
const UNITS: [&str; 16] = [
    "_n", "_mm", "_kg", "_s", "_ms", "_hz", "_kpa", "_mg", "_mm_s", "_ns_m", "_n_mm", "_per_s",
    "_per_min", "relative", "exponent", "_loss",
];

/// Sections with their ids and parameters, from the tables of the published vocabulary.
fn published() -> Vec<(String, String, Vec<String>)> {
    let shared = std::env::var_os("PAM_SHARED")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"), PathBuf::from);
    let path = shared.join("reference/effects.md");
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
fn every_published_effect_is_there_with_its_parameters() {
    let published = published();
    assert!(published.len() >= 24, "only {} effects were read", published.len());
    for (section, id, parameters) in &published {
        let info = by_id(id).unwrap();
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
fn every_entry_is_complete() {
    for (i, e) in ALL.iter().enumerate() {
        assert!(ALL[..i].iter().all(|other| other.id != e.id), "`{}` is there twice", e.id);
        assert!(!e.description.is_empty() && !e.excited_by.is_empty(), "{}", e.id);
        assert!(!e.parameters.is_empty(), "{}", e.id);
        for p in e.parameters {
            assert!(UNITS.iter().any(|u| p.name.ends_with(u)), "{}: `{}`", e.id, p.name);
            assert!(!p.meaning.is_empty(), "{}: `{}`", e.id, p.name);
            let [low, high] = p.range;
            assert!(low < high && p.off.is_none_or(|off| p.admits(off)), "{}: `{}`", e.id, p.name);
            assert!(!p.logarithmic || (low > 0.0 && p.off.is_none()), "{}: `{}`", e.id, p.name);
        }
        assert!(e.switches.iter().all(|s| !s.meaning.is_empty()), "{}", e.id);
    }
}

#[test]
fn unknown_names_are_answered_with_the_known_ones() {
    let message = by_id("coulomb").unwrap_err().to_string();
    assert!(message.contains("no effect `coulomb`"));
    assert!(ALL.iter().all(|e| message.contains(e.id)));
    assert_eq!(by_id("creep").unwrap(), pam_vocabulary::entry("creep"));
}
