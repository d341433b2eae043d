//! A hash of content that stays the same over runs, machines and versions.

/// FNV-1a with 64 bits (Fowler, Noll and Vo), over bytes or over 64-bit words.
///
/// It identifies recordings and settings in file names and resume checks. It is no cryptographic hash.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ContentHash(u64);

const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
const PRIME: u64 = 0x0100_0000_01b3;

impl Default for ContentHash {
    fn default() -> Self {
        Self(OFFSET)
    }
}

impl ContentHash {
    /// A hash whose start is mixed with `seed`.
    #[must_use]
    pub fn seeded(seed: u64) -> Self {
        Self(OFFSET ^ seed)
    }

    /// Adds bytes, as FNV-1a does.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.0 = bytes.iter().fold(self.0, |hash, b| (hash ^ u64::from(*b)).wrapping_mul(PRIME));
    }

    /// Adds a 64-bit word. The product carries into higher bits only, so the upper half is folded down.
    pub fn word(&mut self, word: u64) {
        self.0 = (self.0 ^ word).wrapping_mul(PRIME);
        self.0 ^= self.0 >> 32;
    }

    /// Adds a text with its length.
    pub fn text(&mut self, text: &str) {
        self.word(text.len() as u64);
        text.bytes().for_each(|b| self.word(u64::from(b)));
    }

    /// Adds the bits of numbers with their count.
    pub fn numbers(&mut self, values: &[f64]) {
        self.word(values.len() as u64);
        values.iter().for_each(|v| self.word(v.to_bits()));
    }

    /// The hash.
    #[must_use]
    pub fn value(&self) -> u64 {
        self.0
    }

    /// The hash as 16 hexadecimal digits.
    #[must_use]
    pub fn hex(&self) -> String {
        format!("{:016x}", self.0)
    }
}
