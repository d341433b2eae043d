//! The rig can hide every effect of the vocabulary, and phenomena outside it.

use pam_rig::effects::{ALL, Group};

#[test]
fn every_entry_has_one_generator() {
    for entry in &pam_vocabulary::ALL {
        let own: Vec<_> = ALL.iter().map(|e| e.info).filter(|info| info.id == entry.id).collect();
        assert_eq!(own, [entry]);
    }
}

#[test]
fn some_phenomena_are_outside_the_vocabulary() {
    assert!(ALL.iter().filter(|e| !e.is_listed()).count() >= 4);
    let mut ids: Vec<&str> = ALL.iter().map(|e| e.info.id).collect();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), ALL.len(), "an id is there twice");
}

/// An effect has a test in its own file, or one of its name in the file of its group here.
#[test]
fn every_effect_has_its_test() {
    for effect in ALL {
        let source = match effect.info.group {
            _ if !effect.is_listed() => include_str!("unlisted.rs"),
            Group::Mechanics => include_str!("mechanics.rs"),
            Group::Gas => include_str!("gas.rs"),
            Group::Sensing => include_str!("sensing.rs"),
        };
        let id = effect.info.id;
        let folders = ["mechanics", "gas", "sensing", "unlisted"];
        let own = folders.map(|folder| {
            let root = concat!(env!("CARGO_MANIFEST_DIR"), "/src/effects");
            std::fs::read_to_string(format!("{root}/{folder}/{id}.rs")).unwrap_or_default()
        });
        let tested = source.contains(&format!("#[test]\nfn {id}() {{"));
        assert!(tested || own.iter().any(|text| text.contains("#[test]")), "`{id}` has no test");
    }
}

/// Typical and neutral values lie within the range.
#[test]
fn typical_values_are_possible() {
    for effect in ALL {
        for (p, typical) in effect.info.parameters.iter().zip(effect.typical) {
            for value in [Some(*typical), effect.neutral(p)].into_iter().flatten() {
                assert!(p.admits(value), "{}: {value}", effect.info.id);
            }
        }
    }
}
