use pam_core::SealedMasses;
use pam_data::fingerprint::{fingerprint, fingerprint_of_subjects};
use pam_data::{Channel, MassOrigin, Recording, Subject};

fn recording(name: &str) -> Recording {
    let time_s = (0..200).map(|k| 0.01 * f64::from(k)).collect();
    let mut r = Recording::at_rest(name, time_s, [400.0, 410.0]).with_force(|t| 1e3 * t.sin());
    for (k, x) in r.displacement_mm.iter_mut().enumerate() {
        *x = (0.1 * k as f64).sin();
    }
    r
}

fn negate(values: &mut [f64]) {
    values.iter_mut().for_each(|v| *v = -*v);
}

#[test]
fn every_change_of_the_data_counts_and_the_place_does_not() {
    let original = recording("a");
    let of = |change: &dyn Fn(&mut Recording)| {
        let mut r = original.clone();
        change(&mut r);
        fingerprint([&r])
    };
    let same = fingerprint([&original]);
    assert_eq!(of(&|r| r.source = "/elsewhere/a.csv".into()), same);
    assert_eq!(of(&|r| r.notes.push("a gap".into())), same);
    type Change<'a> = (&'a str, &'a dyn Fn(&mut Recording));
    let changes: [Change<'_>; 12] = [
        ("a renamed file", &|r| r.name = "b".into()),
        ("one velocity", &|r| r.velocity_mm_s[199] = f64::EPSILON),
        ("negated displacement", &|r| negate(&mut r.displacement_mm)),
        ("negated force", &|r| negate(&mut r.force_mn)),
        ("both negated", &|r| {
            negate(&mut r.displacement_mm);
            negate(&mut r.force_mn);
        }),
        ("two signs", &|r| negate(&mut r.displacement_mm[7..9])),
        ("swapped samples", &|r| r.force_mn.swap(3, 4)),
        ("swapped pressures", &|r| {
            std::mem::swap(&mut r.pressure_flexor_kpa, &mut r.pressure_extensor_kpa);
        }),
        ("swapped channels", &|r| std::mem::swap(&mut r.displacement_mm, &mut r.velocity_mm_s)),
        ("another time", &|r| r.time_s.iter_mut().for_each(|t| *t += 1.0)),
        ("a filter", &|r| r.low_passed.cutoff_hz[3] = Some(3.0)),
        ("a part", &|r| *r = r.slice(0..199)),
    ];
    let mut seen = vec![same];
    for (what, change) in changes {
        let other = of(change);
        assert!(!seen.contains(&other), "{what}");
        seen.push(other);
    }
    let (a, b) = (recording("a"), recording("b"));
    assert_ne!(fingerprint([&a, &b]), fingerprint([&b, &a]));
    assert_ne!(fingerprint([&a, &a]), fingerprint([&a]));
}

/// Every bit of every sample of every channel.
#[test]
fn one_bit_of_one_sample_counts() {
    let original = recording("a");
    let same = fingerprint([&original]);
    for k in 0..original.time_s.len() {
        for channel in Channel::ALL {
            let mut r = original.clone();
            let values = match channel {
                Channel::X => &mut r.displacement_mm,
                Channel::V => &mut r.velocity_mm_s,
                Channel::Pf => &mut r.pressure_flexor_kpa,
                Channel::Pe => &mut r.pressure_extensor_kpa,
            };
            values[k] = f64::from_bits(values[k].to_bits() ^ (1 << (k % 52)));
            assert_ne!(fingerprint([&r]), same, "{channel:?} {k}");
        }
    }
}

#[test]
fn masses_count() {
    let subject = |flexor_g| Subject {
        recording: recording("a"),
        masses: SealedMasses { flexor_g, extensor_g: 0.07 },
        origin: MassOrigin::Given,
    };
    assert_ne!(
        fingerprint_of_subjects([&subject(0.07)]),
        fingerprint_of_subjects([&subject(0.08)])
    );
}
