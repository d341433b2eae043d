//! Every entry of the vocabulary is implemented once, with its parameters.

use pam_effects::effects::{ALL, EffectInfo};

#[test]
fn every_entry_has_one_implementation() {
    for entry in &pam_vocabulary::ALL {
        let own: Vec<&EffectInfo> =
            ALL.iter().map(|e| e.info()).filter(|info| info.id == entry.id).collect();
        assert_eq!(own, [entry]);
    }
}
