//! Content hashes of recordings, used to check that a resumed run or a cached result belongs to the same data.
//!
//! The hash covers every input of training and evaluation: name, time, all channels, force, air masses, sealed state
//! and filters. It ignores file paths and notes.

use crate::recording::{Channel, Recording};
use crate::subject::Subject;
use pam_numerics::ContentHash;

/// Hashes recordings in the given order. Returns 32 hexadecimal digits.
#[must_use]
pub fn fingerprint<'a>(recordings: impl IntoIterator<Item = &'a Recording>) -> String {
    let mut hash = ContentHash::default();
    recordings.into_iter().for_each(|r| add_recording(&mut hash, r));
    hash.hex()
}

/// Hashes recordings together with their computed air masses, in the given order. Returns 32 hexadecimal digits.
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
    hash.numbers(&r.low_passed.resolution);
}
