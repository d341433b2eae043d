//! The parts of the diagnosis against equations written out here, against an exact solver, and against
//! themselves (derivatives, files, threads).

mod complex;
mod joint;
mod joint_training;

mod base;
mod biases;
mod coverage;
mod files;
mod friction;
mod gas;
mod loops;
mod mechanics;
mod plain;
mod published;
mod sensing;
mod sensitivities;
mod settings;
mod threads;
mod training;
