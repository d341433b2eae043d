//! A plan on a microcontroller: the force network and the table of commands, read in place.
//!
//! Nothing is allocated and nothing is copied: [`Network`] and [`Table`] borrow the bytes that `pam plan`
//! writes (`network.bin`, `table.bin`), wherever they lie in flash. Numbers are little-endian and may lie at
//! any address.
//!
//! ```
//! use pam_embedded::{Table, TableError};
//!
//! // Two rows of one column, a second apart.
//! let mut bytes = *b"PAMT\x01\0\0\0\x02\0\0\0\x01\0\0\0\0\0\0\0\0\0\xf0\x3f\0\0\0\0\0\0\0\x40";
//! let table = Table::new(&bytes)?;
//! assert_eq!(table.value(0, 0.5), 1.0);
//! bytes[0] = b'X';
//! assert_eq!(Table::new(&bytes).err(), Some(TableError::Magic));
//! # Ok::<(), TableError>(())
//! ```

#![no_std]

pub mod activation;
pub mod joint;
pub mod network;
pub mod real;
pub mod table;

pub use activation::Activation;
pub use joint::Joint;
pub use network::{Network, NetworkError};
pub use real::Real;
pub use table::{Table, TableError};

/// Bytes `at..at + N`, if they are there.
fn bytes<const N: usize>(from: &[u8], at: usize) -> Option<[u8; N]> {
    from.get(at..at.checked_add(N)?)?.try_into().ok()
}

fn word(from: &[u8], at: usize) -> Option<usize> {
    bytes(from, at).map(|b| u32::from_le_bytes(b) as usize)
}
