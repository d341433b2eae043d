//! Phenomena outside the vocabulary. A diagnosis should call them unexplained.

pub mod chamber_crosstalk;
pub mod encoder_freeze;
pub mod periodic_disturbance;
pub mod sensor_gain_jump;
pub mod tendon_slip;
pub mod valve_glitch;
