//! Sweeps as job arrays of Slurm.

/// A batch script that runs a sweep as a job array; `slurm/test.sh` of this crate runs it against a real
/// controller.
pub const BATCH_SCRIPT: &str = include_str!("../slurm/ablate.sbatch");
