//! The rig can hide every effect of the vocabulary, and phenomena outside it.

use pam_rig::effects::{ALL, Group};

#[test]
fn every_entry_has_one_generator() {
    let listed: Vec<_> = ALL.iter().filter(|e| e.is_listed()).map(|e| *e.info).collect();
    assert_eq!(listed, pam_vocabulary::ALL);
}

#[test]
fn some_phenomena_are_outside_the_vocabulary() {
    assert!(ALL.iter().filter(|e| !e.is_listed()).count() >= 4);
    let mut ids: Vec<&str> = ALL.iter().map(|e| e.info.id).collect();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), ALL.len(), "an id is there twice");
}

/// Whoever adds an effect adds its test, of the same name and in the file of its group.
#[test]
fn every_effect_has_its_test() {
    for effect in ALL {
        let source = match effect.info.group {
            _ if !effect.is_listed() => include_str!("unlisted.rs"),
            Group::Mechanics => include_str!("mechanics.rs"),
            Group::Gas => include_str!("gas.rs"),
            Group::Sensing => include_str!("sensing.rs"),
        };
        let test = format!("#[test]\nfn {}() {{", effect.info.id);
        assert!(source.contains(&test), "`{}` has no test", effect.info.id);
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
