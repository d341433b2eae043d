//! A content hash that is stable across runs and machines.

/// BLAKE3 over length-prefixed strings and arrays, so that moving bytes between neighbours changes the hash.
///
/// It identifies recordings and settings in file names and when a run is resumed.
#[derive(Debug, Clone, Default)]
pub struct ContentHash(blake3::Hasher);

impl ContentHash {
    /// Adds an integer.
    pub fn word(&mut self, word: u64) {
        self.0.update(&word.to_le_bytes());
    }

    /// Adds a byte string, prefixed with its length.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.word(bytes.len() as u64);
        self.0.update(bytes);
    }

    /// Adds a string, prefixed with its length.
    pub fn text(&mut self, text: &str) {
        self.bytes(text.as_bytes());
    }

    /// Adds the bits of an array, prefixed with its length.
    pub fn numbers(&mut self, values: &[f64]) {
        self.word(values.len() as u64);
        // The vector instructions of BLAKE3 need many blocks of 1024 bytes at once.
        let mut buffer = vec![0; (8 * values.len()).min(1 << 16)];
        for chunk in values.chunks((buffer.len() / 8).max(1)) {
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
