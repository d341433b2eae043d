//! The joint: recordings, the effects of the vocabulary, and a hybrid model with them.
//!
//! [`JointSystem`] makes recordings and effects the experiments and candidates of the [search](crate::search). With
//! frozen weights and sealed air the network is a function of (x, ẋ) alone;
//! [`simulation`](pam_effects::simulation) tabulates it once for each recording, and reading the table costs
//! nanoseconds where the network costs hundreds.

mod baseline;
mod calibrated;
mod design;
mod diagnose;
mod divergence;
mod factors;
mod features;
mod force_noise;
mod ladder;
mod law;
mod motions;
mod parts;
mod pieces;
mod refit;
mod report;
mod scales;
mod sensitivities;
mod signatures;
mod spans;
mod start;
mod system;
mod terms;

pub use baseline::BaselineDiscrepancy;
pub use calibrated::calibrated_inputs;
pub use design::{Excitation, Separation, excitations, separate};
pub use diagnose::{DiagnoseOptions, DiagnosedJoint, JointDiagnosis, RecordingSets, diagnose};
pub use divergence::CutRecording;
pub use ladder::{EffectLadder, joint_ladder};
pub use law::learn_remainder;
pub use refit::refit;
pub use signatures::{Acceptance, PreparedTrials, Signature, SignatureSpan, Signatures};
pub use system::JointSystem;
