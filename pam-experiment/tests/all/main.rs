//! Tests of planned experiments: limits against diagnoses, confusions against published ones, certificates that resume, designs
//! within their limits, and the loop on the virtual rig.

mod certify;
mod common;
mod design;
mod detect;
mod standing;
