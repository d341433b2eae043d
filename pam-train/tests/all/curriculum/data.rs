use pam_train::curriculum::{DataSettings, Selection, SelectionSet, SplitRole};

fn names(settings: &DataSettings, all: &[&str], role: SplitRole) -> Vec<String> {
    let roles = settings.roles(all);
    all.iter().zip(roles).filter(|(_, r)| *r == role).map(|(n, _)| (*n).to_owned()).collect()
}

/// Of recordings under a lab's own names a fifth is held out, the same for the same seed in whatever order they come.
#[test]
fn a_fifth_of_foreign_recordings_is_held_out() {
    let all: Vec<String> = (0..10).map(|k| format!("run-{k}")).collect();
    let all: Vec<&str> = all.iter().map(String::as_str).collect();
    let settings = DataSettings::default();
    let held = names(&settings, &all, SplitRole::HeldOut);
    assert_eq!(held.len(), 2);
    assert_eq!(names(&settings, &all, SplitRole::Train).len(), 8);
    let reversed: Vec<&str> = all.iter().rev().copied().collect();
    let mut again = names(&settings, &reversed, SplitRole::HeldOut);
    again.sort();
    let mut sorted = held.clone();
    sorted.sort();
    assert_eq!(again, sorted);
    let others = DataSettings { split_seed: 5, ..DataSettings::default() };
    assert_ne!(names(&others, &all, SplitRole::HeldOut), held);
    // A part of the set is split as the whole.
    let pinned = settings.pinned(&all);
    let part: Vec<&str> = all.iter().copied().filter(|n| held.contains(&(*n).to_owned())).collect();
    assert_eq!(names(&pinned, &part, SplitRole::HeldOut), held);
}

/// The published conditions are split as published, whatever else is there.
#[test]
fn published_names_are_split_as_published() {
    let all = ["nn_3060", "nn_3065", "nn_4545"];
    let settings = DataSettings::default();
    assert_eq!(names(&settings, &all, SplitRole::Train), ["nn_3060", "nn_4545"]);
    assert_eq!(names(&settings, &all, SplitRole::HeldOut), ["nn_3065"]);
}

/// Patterns select; what is held out by name is never trained on.
#[test]
fn patterns_select() {
    let all = ["monday-1", "monday-2", "tuesday-1", "test"];
    let settings = DataSettings {
        train: Selection::Names(vec!["*-?".into()]),
        held_out: Selection::Names(vec!["tuesday-*".into()]),
        ..DataSettings::default()
    };
    assert_eq!(names(&settings, &all, SplitRole::Train), ["monday-1", "monday-2"]);
    assert_eq!(names(&settings, &all, SplitRole::HeldOut), ["tuesday-1"]);
    assert_eq!(names(&settings, &all, SplitRole::Unused), ["test"]);
    let rest = DataSettings { train: Selection::Set(SelectionSet::Rest), ..settings };
    assert_eq!(names(&rest, &all, SplitRole::Train), ["monday-1", "monday-2", "test"]);
}
