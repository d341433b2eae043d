use pam_data::conditions::TRAINING_PSI;
use pam_rig::Conditions;
use pam_rig::protocol::ConditionSet;

#[test]
fn the_training_conditions_are_part_of_the_grid() {
    let grid = Conditions::Set(ConditionSet::Grid).psi();
    assert_eq!(grid.len(), 225);
    assert!(TRAINING_PSI.iter().all(|c| grid.contains(c)));
    assert!(Conditions::List(TRAINING_PSI.to_vec()).check().is_ok());
}

#[test]
fn lists_are_read_and_checked() {
    assert_eq!(Conditions::parse("30/60, 45/45").unwrap().psi(), [[30, 60], [45, 45]]);
    for (text, why) in
        [("30-60", "30/60,45/45"), ("30/99", "supply"), ("30/60,30/60", "twice"), ("", "neither")]
    {
        assert!(Conditions::parse(text).unwrap_err().contains(why), "{text}");
    }
}
