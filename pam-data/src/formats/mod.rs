//! File formats of recordings, one module each.

pub mod columns;
pub mod csv_columns;
pub mod format;
pub mod list;
pub mod mat;
#[cfg(feature = "hdf5")]
mod mat_hdf5;
pub mod mat_run;
pub mod npy;
pub mod npz;
pub mod npz_columns;
pub mod raw_log;
