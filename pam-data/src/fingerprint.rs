//! Fingerprints of recordings: equal for equal data, wherever the files lie.
//!
//! They guard resumed runs and cached results. Everything that a training or an evaluation sees counts: the
//! name, time, all channels, force, air masses, the sealed state and the filters. Paths and notes do not.

use crate::recording::{Channel, Recording};
use crate::subject::Subject;
use pam_numerics::ContentHash;

/// The fingerprint of recordings, in their order: 32 hexadecimal digits.
#[must_use]
pub fn fingerprint<'a>(recordings: impl IntoIterator<Item = &'a Recording>) -> String {
    let mut hash = ContentHash::default();
    recordings.into_iter().for_each(|r| add_recording(&mut hash, r));
    hash.hex()
}

/// The fingerprint of recordings with the air masses that were found for them, in their order.
#[must_use]
pub fn fingerprint_of_subjects<'a>(subjects: impl IntoIterator<Item = &'a Subject>) -> String {
    let mut hash = ContentHash::default();
    for subject in subjects {
        add_recording(&mut hash, &subject.recording);
        hash.numbers(&[subject.masses.flexor_g, subject.masses.extensor_g]);
    }
    hash.hex()
}

fn add_recording(hash: &mut ContentHash, r: &Recording) {
    hash.text(&r.name);
    hash.numbers(&r.time_s);
    Channel::ALL.iter().for_each(|&channel| hash.numbers(r.channel(channel)));
    hash.numbers(&r.force_mn);
    hash.numbers(&r.given_masses.map_or(vec![], |m| vec![m.flexor_g, m.extensor_g]));
    let sealed =
        r.sealed.map(|s| [s.displacement_mm, s.pressure_flexor_kpa, s.pressure_extensor_kpa]);
    hash.numbers(sealed.as_ref().map_or(&[], |s| &s[..]));
    r.low_passed.cutoff_hz.iter().for_each(|cutoff| hash.numbers(cutoff.as_slice()));
    hash.numbers(r.low_passed.force_mn.as_deref().unwrap_or_default());
}
