//! Effects in actuation and sensing.

use crate::{EffectInfo, Group, ParameterInfo};

/// A factor `1 + relative` between a tenth and six; a negative one is a sign error, not an effect.
const RELATIVE: [f64; 2] = [-0.9, 5.0];

/// Half a second, a quarter of the slowest published period.
const DELAY_MS: [f64; 2] = [0.0, 500.0];

/// About a tenth of the supply's 667 kPa; a sensor further off is broken, not out of calibration.
const PRESSURE_BIAS_KPA: [f64; 2] = [-60.0, 60.0];

/// A quarter; a sensor further off is broken, not out of calibration.
const PRESSURE_RELATIVE: [f64; 2] = [-0.25, 0.25];

/// Slower than any motion, to a lag of less than a tenth of a millisecond, the sample of the fastest recordings.
const CUTOFF_HZ: [f64; 2] = [0.05, 2000.0];

const SENSING: EffectInfo = EffectInfo::new("", Group::Sensing, "", &[]);

pub(crate) const EFFECTS: &[EffectInfo] = &[
    EffectInfo {
        id: "force_gain",
        name: "wrong force gain",
        description: "real force that differs from the commanded one by a factor",
        parameters: &[ParameterInfo::linear("relative", RELATIVE)
            .meaning("real force = (1 + relative) · commanded force")],
        excited_by: "motion at frequencies far apart",
        ..SENSING
    },
    EffectInfo {
        id: "force_saturation",
        description: "real force that is clipped",
        parameters: &[ParameterInfo::linear("force_n", [1.0, 1e5])
            .off_at(None)
            .meaning("largest real force in either direction")],
        excited_by: "amplitudes below and above the limit",
        ..SENSING
    },
    EffectInfo {
        id: "actuation_delay",
        description: "real force that follows the recorded one late",
        parameters: &[ParameterInfo::linear("delay_ms", DELAY_MS)
            .meaning("real force at t = recorded force at t − delay_ms")],
        excited_by: "fast motion",
        ..SENSING
    },
    EffectInfo {
        id: "actuator_lag",
        description: "real force that follows the commanded one through a first-order low-pass",
        parameters: &[ParameterInfo::scale("cutoff_hz", CUTOFF_HZ)
            .meaning("cutoff f of `dF/dt = 2π f (F_commanded − F)`")],
        excited_by: "fast and slow motion: lag and delay differ in amplitude",
        ..SENSING
    },
    EffectInfo {
        id: "pressure_sensor_lag",
        description: "first-order low-pass on both pressure channels",
        parameters: &[ParameterInfo::scale("cutoff_hz", CUTOFF_HZ)
            .meaning("cutoff of `1/(1 + s/(2π cutoff_hz))`")],
        excited_by: "fast and slow motion: lag and delay differ in amplitude",
        ..SENSING
    },
    EffectInfo {
        id: "pressure_delay",
        description: "pure delay on both pressure channels",
        parameters: &[ParameterInfo::linear("delay_ms", DELAY_MS)
            .meaning("measured pressure at t = true pressure at t − delay_ms")],
        excited_by: "fast and slow motion: lag and delay differ in amplitude",
        ..SENSING
    },
    EffectInfo {
        id: "pressure_bias",
        name: "pressure offset",
        description: "offset of the pressure sensors",
        parameters: &[
            ParameterInfo::linear("flexor_kpa", PRESSURE_BIAS_KPA)
                .meaning("measured − true pressure of the flexor"),
            ParameterInfo::linear("extensor_kpa", PRESSURE_BIAS_KPA)
                .meaning("measured − true pressure of the extensor"),
        ],
        excited_by: "a wide range of pressures",
        ..SENSING
    },
    EffectInfo {
        id: "pressure_gain",
        name: "wrong pressure gain",
        description: "pressure sensors that are off by a factor",
        parameters: &[
            ParameterInfo::linear("flexor_relative", PRESSURE_RELATIVE)
                .meaning("measured = (1 + flexor_relative) · true gauge pressure of the flexor"),
            ParameterInfo::linear("extensor_relative", PRESSURE_RELATIVE).meaning(
                "measured = (1 + extensor_relative) · true gauge pressure of the extensor",
            ),
        ],
        excited_by: "a wide range of pressures",
        ..SENSING
    },
    EffectInfo {
        id: "position_offset",
        name: "displacement offset",
        description: "offset of the position sensor",
        parameters: &[ParameterInfo::linear("offset_mm", [-20.0, 20.0])
            .meaning("measured − true displacement")],
        excited_by: "any motion; a wide range of pressures separates it from a steady force",
        ..SENSING
    },
    EffectInfo {
        id: "position_gain",
        name: "wrong displacement gain",
        description: "position sensor that is off by a factor",
        parameters: &[ParameterInfo::linear("relative", RELATIVE)
            .meaning("measured = (1 + relative) · true displacement")],
        excited_by: "motion at frequencies far apart",
        ..SENSING
    },
    EffectInfo {
        id: "position_sensor_lag",
        name: "displacement sensor lag",
        description: "first-order low-pass on the position reading",
        parameters: &[ParameterInfo::scale("cutoff_hz", CUTOFF_HZ)
            .meaning("cutoff of `1/(1 + s/(2π cutoff_hz))`")],
        excited_by: "fast and slow motion: lag and delay differ in amplitude",
        ..SENSING
    },
    EffectInfo {
        id: "position_delay",
        name: "displacement delay",
        description: "pure delay of the position reading",
        parameters: &[ParameterInfo::linear("delay_ms", DELAY_MS)
            .meaning("measured displacement at t = true displacement at t − delay_ms")],
        excited_by: "fast and slow motion: lag and delay differ in amplitude; pressures separate it from a late force",
        ..SENSING
    },
];
