use pam_numerics::ContentHash;

/// Test vectors of the FNV reference code.
#[test]
fn bytes_follow_fnv_1a() {
    for (text, hash) in [
        ("", 0xcbf2_9ce4_8422_2325),
        ("a", 0xaf63_dc4c_8601_ec8c),
        ("foobar", 0x8594_4171_f739_67e8),
    ] {
        let mut h = ContentHash::default();
        h.bytes(text.as_bytes());
        assert_eq!(h.value(), hash, "{text}");
    }
}

#[test]
fn every_bit_and_every_boundary_counts() {
    let of = |numbers: &[&[f64]]| {
        let mut h = ContentHash::default();
        numbers.iter().for_each(|n| h.numbers(n));
        h.hex()
    };
    assert_ne!(of(&[&[1.0], &[2.0]]), of(&[&[1.0, 2.0]]));
    assert_ne!(of(&[&[0.0]]), of(&[&[-0.0]]));
    assert_ne!(of(&[&[1.0]]), of(&[&[1.0 + f64::EPSILON]]));
}
