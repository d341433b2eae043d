//! The vocabulary of effects, as data.
//!
//! An *effect* is a known way in which a joint differs from its model: dry friction, a leak, a sensor
//! offset. [`ALL`] lists every effect with its id, parameters, units and physical ranges. The virtual rig
//! hides effects in recordings and the diagnosis finds them there. Both refer to this table, and each
//! implements the physics on its own: an estimator that shares code with the simulator of its test data
//! commits an inverse crime (Colton and Kress, *Inverse Acoustic and Electromagnetic Scattering Theory*).
//!
//! Effects that are in no table are [defined by expressions](definition) in a file. Any effect may begin, end or grow at a
//! time: its [`course`].
//!
//! An entry is a block in the file of its group (`mechanics.rs`, `gas.rs`, `sensing.rs`); an id never changes
//! once it is released. Effects outside the vocabulary describe themselves with an [`EffectInfo`] of their
//! own.
//!
//! ```
//! let leak = pam_vocabulary::by_id("leak")?;
//! assert_eq!(leak.parameters[0].name, "flexor_rate_per_s");
//! assert!(pam_vocabulary::by_id("leaks").is_err_and(|e| e.to_string().contains("there are")));
//! # Ok::<(), pam_vocabulary::VocabularyError>(())
//! ```

pub mod course;
pub mod definition;
mod error;
pub mod expression;
mod gas;
mod info;
mod mechanics;
mod sensing;

pub use course::ActivityWindow;
pub use error::VocabularyError;
pub use info::{EffectInfo, Group, ParameterInfo, Switch};

const LEN: usize = mechanics::EFFECTS.len() + gas::EFFECTS.len() + sensing::EFFECTS.len();

/// Every effect of the vocabulary in reading order: mechanics, gas, actuation and sensing.
pub static ALL: [EffectInfo; LEN] = {
    let groups = [mechanics::EFFECTS, gas::EFFECTS, sensing::EFFECTS];
    let mut all = [mechanics::EFFECTS[0]; LEN];
    let (mut group, mut filled) = (0, 0);
    while group < groups.len() {
        let mut i = 0;
        while i < groups[group].len() {
            all[filled] = groups[group][i];
            (i, filled) = (i + 1, filled + 1);
        }
        group += 1;
    }
    all
};

/// The effect with this id.
///
/// # Errors
/// [`VocabularyError::UnknownEffect`], which lists the ids of the vocabulary.
pub fn by_id(id: &str) -> Result<&'static EffectInfo, VocabularyError> {
    ALL.iter()
        .find(|e| e.id == id)
        .ok_or_else(|| VocabularyError::unknown_effect(id, ALL.iter().map(|e| e.id)))
}

/// The plain name of an effect: "dry friction" for `coulomb_friction`; the words of the id for effects outside the vocabulary.
#[must_use]
pub fn plain_name(id: &str) -> String {
    by_id(id).map_or_else(|_| id.replace('_', " "), EffectInfo::plain_name)
}

/// The effect with this id, for constants: `const { entry("leak") }` does not compile if the vocabulary
/// lacks the id. Use [`by_id`] for ids that are not known at compile time.
///
/// # Panics
/// If the vocabulary lacks the id.
#[must_use]
pub const fn entry(id: &str) -> &'static EffectInfo {
    let mut i = 0;
    while i < ALL.len() {
        if same(ALL[i].id.as_bytes(), id.as_bytes()) {
            return &ALL[i];
        }
        i += 1;
    }
    panic!("the vocabulary has no effect with this id")
}

/// `a == b` for constants.
const fn same(a: &[u8], b: &[u8]) -> bool {
    let mut i = 0;
    while i < a.len() && i < b.len() && a[i] == b[i] {
        i += 1;
    }
    a.len() == b.len() && i == a.len()
}
