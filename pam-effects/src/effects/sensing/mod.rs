//! Effects between command and force, and between joint and record.

pub(super) mod actuation_delay;
pub(super) mod force_gain;
pub(super) mod force_saturation;
pub(super) mod position_gain;
pub(super) mod position_offset;
pub(super) mod pressure_bias;
pub(super) mod pressure_delay;
pub(super) mod pressure_gain;
pub(super) mod pressure_sensor_lag;
