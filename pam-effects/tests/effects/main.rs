//! The effects and their simulation against equations written out here, against an exact solver, and against
//! themselves (derivatives, files).

mod support;

mod accuracy;
mod base;
mod expressions;
mod files;
mod friction;
mod gas;
mod hooks;
mod loops;
mod mechanics;
mod own;
mod plain;
mod sensing;
mod sensitivities;
mod start;
mod steps;
mod table;
mod timed;
mod training;
mod vocabulary;
