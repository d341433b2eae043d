use pam_numerics::ContentHash;

/// The test vector of the BLAKE3 paper's reference for empty input, and the length in front of a text.
#[test]
fn the_digits_are_those_of_blake3() {
    assert_eq!(ContentHash::default().hex(), "af1349b9f5f9a1a6a0404dea36dcc949");
    let (mut text, mut words) = (ContentHash::default(), ContentHash::default());
    text.text("eight by");
    words.word(8);
    words.word(u64::from_le_bytes(*b"eight by"));
    assert_eq!(text.hex(), words.hex());
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
    let many: Vec<f64> = (0..1000).map(f64::from).collect();
    for k in [0, 127, 128, 999] {
        let mut other = many.clone();
        other[k] = -other[k];
        assert_ne!(of(&[&many]), of(&[&other]), "sample {k}");
    }
}
