//! The commands, one file each.

pub mod ablate;
pub mod compare;
pub mod control;
pub mod convert;
pub mod diagnose;
pub mod doctor;
pub mod evaluate;
pub mod gradient;
pub mod inspect;
pub mod rig;
pub mod shell;
pub mod simulate;
pub mod train;
