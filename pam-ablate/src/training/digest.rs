//! A digest of recordings, independent of their paths.

use pam_data::{Channel, Recording};
use pam_numerics::ContentHash;

/// A digest of names and numbers of recordings, in their order. Files, notes and whatever else no training
/// sees is left out; how the files were read is in the numbers.
pub(super) fn of_recordings(recordings: &[Recording]) -> String {
    let mut digest = ContentHash::default();
    for r in recordings {
        digest.text(&r.name);
        digest.numbers(&r.time_s);
        for channel in Channel::ALL {
            digest.numbers(r.channel(channel));
        }
        digest.numbers(&r.force_mn);
        let masses = r.given_masses.map_or(vec![], |m| vec![m.flexor_g, m.extensor_g]);
        digest.numbers(&masses);
        let rest = r.sealed.map_or(vec![], |s| {
            vec![s.displacement_mm, s.pressure_flexor_kpa, s.pressure_extensor_kpa]
        });
        digest.numbers(&rest);
        for cutoff in r.low_passed.cutoff_hz {
            digest.numbers(cutoff.as_slice());
        }
        digest.numbers(r.low_passed.force_mn.as_deref().unwrap_or_default());
    }
    format!("{} recordings, {}", recordings.len(), digest.hex())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_counts_and_the_place_does_not() {
        let time_s = (0..50).map(|k| 0.01 * f64::from(k)).collect();
        let r = Recording::at_rest("a", time_s, [400.0, 410.0]).with_force(|t| 1e3 * t);
        let of = |change: &dyn Fn(&mut Recording)| {
            let mut r = r.clone();
            change(&mut r);
            of_recordings(&[r])
        };
        let same = of(&|_| {});
        assert_eq!(of(&|r| r.source = "/elsewhere/a.csv".into()), same);
        assert_eq!(of(&|r| r.notes.push("a gap".into())), same);
        let others = [
            of(&|r| r.name = "b".into()),
            of(&|r| r.velocity_mm_s[49] = f64::EPSILON),
            of(&|r| r.force_mn.swap(3, 4)),
            of(&|r| r.low_passed.cutoff_hz[3] = Some(3.0)),
            of(&|r| *r = r.slice(0..49)),
        ];
        for (i, other) in others.iter().enumerate() {
            assert_ne!(*other, same, "change {i}");
        }
        assert_ne!(of_recordings(&[r.clone(), r.clone()]), same);
    }
}
