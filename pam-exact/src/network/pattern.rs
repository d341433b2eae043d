//! Activation patterns: one bit per hidden unit, padding included, set where the unit is active.

/// Word and mask of a unit in a pattern.
#[inline(always)]
pub(crate) fn word_and_mask(unit: usize) -> (usize, u64) {
    (unit / 64, 1 << (unit % 64))
}

/// True if a unit is active.
#[inline(always)]
pub(crate) fn is_active(pattern: &[u64], unit: usize) -> bool {
    let (word, mask) = word_and_mask(unit);
    pattern[word] & mask != 0
}

/// 1 for an active unit, −1 for any other.
#[inline(always)]
pub(crate) fn sign(pattern: &[u64], unit: usize) -> f64 {
    if is_active(pattern, unit) { 1.0 } else { -1.0 }
}

/// A well-mixed number for each unit (splitmix64). The hash of a pattern is the exclusive or of the numbers
/// of its active units, so that a sign change updates it in one operation (A. L. Zobrist, *A new hashing
/// method*, 1970).
pub(crate) fn unit_hash(unit: usize) -> u64 {
    let mut z = (unit as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// `one` if the bit is set, else `zero`, without a branch: signs cannot be predicted.
#[inline(always)]
pub(crate) fn select(bit: u64, one: f64, zero: f64) -> f64 {
    let mask = bit.wrapping_neg();
    f64::from_bits((one.to_bits() & mask) | (zero.to_bits() & !mask))
}

/// Writes `dσ/dz` of each unit, 1 or `slope`.
#[inline(always)]
pub(crate) fn slopes_into(pattern: &[u64], slope: f64, slopes: &mut [f64]) {
    for (block, bits) in slopes.chunks_mut(64).zip(pattern) {
        for (i, value) in block.iter_mut().enumerate() {
            *value = select((bits >> i) & 1, 1.0, slope);
        }
    }
}
