//! A hash of content that stays the same over runs and machines.

/// BLAKE3 over texts and numbers, each with its length in front, so that neighbours cannot be confused.
///
/// It identifies recordings and settings in names of files and in the checks of resumed runs.
#[derive(Debug, Clone, Default)]
pub struct ContentHash(blake3::Hasher);

impl ContentHash {
    /// Adds a whole number.
    pub fn word(&mut self, word: u64) {
        self.0.update(&word.to_le_bytes());
    }

    /// Adds bytes with their count.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.word(bytes.len() as u64);
        self.0.update(bytes);
    }

    /// Adds a text with its length.
    pub fn text(&mut self, text: &str) {
        self.bytes(text.as_bytes());
    }

    /// Adds the bits of numbers with their count.
    pub fn numbers(&mut self, values: &[f64]) {
        self.word(values.len() as u64);
        // Many samples to one update, which is much faster than one by one.
        let mut buffer = [0; 1024];
        for chunk in values.chunks(buffer.len() / 8) {
            for (to, v) in buffer.chunks_exact_mut(8).zip(chunk) {
                to.copy_from_slice(&v.to_bits().to_le_bytes());
            }
            self.0.update(&buffer[..8 * chunk.len()]);
        }
    }

    /// The first 128 bits of the hash as 32 hexadecimal digits.
    #[must_use]
    pub fn hex(&self) -> String {
        self.0.finalize().to_hex()[..32].to_owned()
    }
}
