//! The table holds the published vocabulary, and every entry is complete.

use pam_vocabulary::{ALL, Group, by_id};

/// Suffixes of parameters that carry a unit, and the dimensionless ones.
const UNITS: [&str; 16] = [
    "_n", "_mm", "_kg", "_s", "_ms", "_hz", "_kpa", "_mg", "_mm_s", "_ns_m", "_n_mm", "_per_s",
    "_per_min", "relative", "exponent", "_loss",
];

/// Group, id and parameters of the vocabulary as it was published for others to plant and to find.
const PUBLISHED: &str = include_str!("published.csv");

#[test]
fn every_published_effect_is_there_with_its_parameters() {
    let lines: Vec<&str> = PUBLISHED.lines().skip(1).collect();
    assert_eq!(lines.len(), 28);
    for line in lines {
        let [group, id, parameters] = line.split(',').collect::<Vec<_>>()[..] else {
            panic!("three columns: {line}")
        };
        let info = by_id(id).unwrap();
        let names: Vec<&str> = info.parameters.iter().map(|p| p.name).collect();
        assert_eq!(names.join(" "), parameters, "{id}");
        let expected = match group {
            "mechanics" => Group::Mechanics,
            "gas" => Group::Gas,
            _ => Group::Sensing,
        };
        assert_eq!(info.group, expected, "{id}");
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
