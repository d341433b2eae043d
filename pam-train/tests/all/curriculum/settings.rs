use pam_train::curriculum::{Selection, SelectionSet};

#[test]
fn selections_take_what_they_say() {
    let train = Selection::Set(SelectionSet::Train);
    assert!(train.takes("nn_3060", false) && train.takes("nn_3060_validation", false));
    assert!(!train.takes("nn_3065", false));
    assert!(Selection::Set(SelectionSet::Rest).takes("nn_3065", false));
    assert!(!Selection::Set(SelectionSet::Rest).takes("nn_3060", true));
    let names = Selection::Names(vec!["3065".into(), "run1".into()]);
    assert!(names.takes("nn_3065", false) && names.takes("run1", false));
    assert!(!names.takes("run2", false));
}
