//! Recordings and model files: read, checked, preprocessed, written.
//!
//! A [`Recording`] is what every other part of the framework works on: one run of the joint with
//! sealed muscles, in the units of [`pam_core`], together with where it came from and what was done
//! to it. [`open_recordings`] reads any supported file:
//!
//! | format | module |
//! |---|---|
//! | raw log of the rig (`nn_FFEE`) | [`formats::raw_log`], preprocessed by [`preprocess`] |
//! | CSV and `.npz` of the standard columns | [`formats::csv_columns`], [`formats::npz_columns`] |
//! | the published MATLAB run (`data.mat`) | [`formats::mat_run`] |
//! | any table of a rig that is described by a [`rig_file`] | [`table`] |
//!
//! Models come from the published `.eqx` weights or from safetensors ([`models`]); sealed air masses
//! from the file itself, the gas law, or the single-muscle surfaces ([`masses`]).
//!
//! Units, signs and columns that contradict the physics of the joint are found by [`plausibility`].
//!
//! Every error names the file, and the line and column where there is one, in TOML files too
//! ([`toml_file`]). Files are read up to a largest size ([`read_limit`]) and written atomically ([`atomic`]), into
//! folders that are checked and locked first ([`output_folder`]).

pub mod atomic;
pub mod conditions;
pub mod detect;
pub mod document;
pub mod error;
pub mod fingerprint;
pub mod formats;
pub mod load_options;
pub mod masses;
pub mod models;
pub mod output_folder;
pub mod plausibility;
pub mod preprocess;
pub mod quality;
pub mod read_limit;
pub mod recording;
pub mod rig_file;
pub mod subject;
pub mod table;
pub mod toml_file;

pub use detect::{
    TRUTH_SUFFIX, collect_paths, collect_paths_of, open_recordings, read_files, read_recordings,
    rig_of,
};
pub use error::DataError;
pub use formats::format::FileFormat;
pub use formats::list::{format_of, write_recording, writer_for};
pub use formats::raw_log::RawLog;
pub use load_options::{LoadOptions, PressureReference};
pub use masses::{MassChoice, MassOptions, MassOrigin, MuscleSurfaces, resolve_masses};
pub use models::{ModelInfo, SavedModel, load_model, parse_model, save_model};
pub use preprocess::RawLogOptions;
pub use recording::{Channel, Recording, SealedReading};
pub use rig_file::RigFile;
pub use subject::{Subject, subjects};
