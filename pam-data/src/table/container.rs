//! The containers of named arrays that a table can be read from.
//!
//! To add one, write a file with a function that reads it, and an entry in [`ALL`].

use super::arrays::ArrayTable;
use crate::error::DataError;
use crate::formats::{mat, npz};
use crate::rig_file::FileLayout;
use std::path::Path;

/// Reads a table from a file whose bytes are given.
type Read = fn(&Path, Vec<u8>, &FileLayout) -> Result<ArrayTable, DataError>;

/// A kind of file with named arrays of numbers.
pub(super) struct Container {
    /// The kind with its article.
    name: &'static str,
    /// The first bytes of such files.
    magic: &'static [u8],
    /// The function that reads it, or the cargo feature that was left out of this build.
    read: Result<Read, &'static str>,
}

#[cfg(feature = "parquet")]
const PARQUET: Result<Read, &str> = Ok(super::parquet_file::read);
#[cfg(not(feature = "parquet"))]
const PARQUET: Result<Read, &str> = Err("parquet");

#[cfg(feature = "mcap")]
const MCAP: Result<Read, &str> = Ok(super::mcap_log::read);
#[cfg(not(feature = "mcap"))]
const MCAP: Result<Read, &str> = Err("mcap");

/// All of them.
pub(super) static ALL: &[Container] = &[
    Container { name: "an .npz archive", magic: b"PK", read: Ok(npz_arrays) },
    Container { name: "a MATLAB file", magic: b"MATLAB", read: Ok(mat_arrays) },
    Container { name: "a MATLAB 7.3 file", magic: b"\x89HDF", read: Ok(mat_arrays) },
    Container { name: "a Parquet file", magic: b"PAR1", read: PARQUET },
    Container { name: "an MCAP log", magic: b"\x89MCAP0\r\n", read: MCAP },
];

/// The container that begins with these bytes.
pub(super) fn of(bytes: &[u8]) -> Option<&'static Container> {
    ALL.iter().find(|c| bytes.starts_with(c.magic))
}

/// The sentence on a file that this build does not read.
pub(crate) fn not_built(what: &str, feature: &str) -> String {
    format!(
        "this is {what}, which this program was built without: build it with `cargo build --release --features {feature}`, \
         or save the table as CSV or .npz"
    )
}

/// Kind of such a file and the feature that it needs, if this build does not read it.
pub(crate) fn missing_feature(bytes: &[u8]) -> Option<String> {
    let container = of(bytes)?;
    container.read.err().map(|feature| not_built(container.name, feature))
}

/// True if a table with these first bytes can only be read through a rig file.
pub(crate) fn needs_rig_file(bytes: &[u8]) -> bool {
    [b"PAR1".as_slice(), b"\x89MCAP0\r\n"].iter().any(|magic| bytes.starts_with(magic))
}

impl Container {
    pub(super) fn read(
        &self,
        path: &Path,
        bytes: Vec<u8>,
        layout: &FileLayout,
    ) -> Result<ArrayTable, DataError> {
        match self.read {
            Ok(read) => read(path, bytes, layout),
            Err(feature) => Err(DataError::file(path, not_built(self.name, feature))),
        }
    }
}

fn npz_arrays(path: &Path, _: Vec<u8>, _: &FileLayout) -> Result<ArrayTable, DataError> {
    let arrays = npz::read(path)?.into_iter().map(|(name, array)| (name, array.values));
    Ok(ArrayTable::new(path, arrays.collect()))
}

fn mat_arrays(path: &Path, _: Vec<u8>, _: &FileLayout) -> Result<ArrayTable, DataError> {
    Ok(ArrayTable::new(path, mat::read(path)?.into_iter().collect()))
}
