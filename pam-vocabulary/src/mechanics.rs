//! Effects in the mechanics.

use crate::{EffectInfo, Group, ParameterInfo, Switch};

/// A friction or loop force: never negative, at most five times the 200 N of the published experiments.
const RESISTANCE_N: [f64; 2] = [0.0, 1e3];

/// A force of either sign, as large.
const FORCE_N: [f64; 2] = [-1e3, 1e3];

const MECHANICS: EffectInfo = EffectInfo::new("", Group::Mechanics, "", &[]);

pub(crate) const EFFECTS: &[EffectInfo] = &[
    EffectInfo {
        id: "coulomb_friction",
        name: "dry friction",
        description: "dry friction that opposes the motion and sticks at rest",
        parameters: &[ParameterInfo::linear("force_n", RESISTANCE_N)
            .meaning("friction force while the joint slides; the largest one while it sticks")],
        excited_by: "reversals of a slow motion",
        ..MECHANICS
    },
    EffectInfo {
        id: "stribeck_friction",
        name: "Stribeck friction",
        description: "dry friction that is higher near standstill",
        parameters: &[
            ParameterInfo::linear("coulomb_n", RESISTANCE_N)
                .meaning("friction force at high velocity"),
            ParameterInfo::linear("static_n", RESISTANCE_N)
                .not_below(0)
                .meaning("largest friction force at rest; not below `coulomb_n`"),
            // Lubricated contacts: 0.1 to 10 mm/s (Armstrong-Hélouvry, Dupont and Canudas de Wit 1994).
            ParameterInfo::scale("velocity_mm_s", [0.02, 100.0]).meaning(
                "velocity scale of `coulomb_n + (static_n − coulomb_n) · exp(−(ẋ/velocity_mm_s)²)`",
            ),
        ],
        excited_by: "slow reversals and slow creeping motion",
        ..MECHANICS
    },
    EffectInfo {
        id: "load_friction",
        name: "load-dependent friction",
        description: "dry friction that grows with the tension of the tendons",
        parameters: &[
            // 1 kN, as of the other frictions, at the 200 kPa mean gauge pressure of the published experiments.
            ParameterInfo::linear("force_n_per_kpa", [0.0, 5.0]).meaning(
                "friction force for each kPa of the mean gauge pressure of both chambers; it sticks at rest",
            ),
        ],
        excited_by: "reversals of a slow motion at pressures far apart, which separate it from `coulomb_friction`",
        ..MECHANICS
    },
    EffectInfo {
        id: "viscous_damping",
        description: "force proportional to the velocity",
        // The published joint has 6000 to 7500 N s/m; a model may have too much of it.
        parameters: &[ParameterInfo::linear("coefficient_ns_m", [-5e3, 1e5])
            .meaning("force `−coefficient_ns_m · ẋ`; negative if the model has too much damping")],
        excited_by: "fast motion",
        ..MECHANICS
    },
    EffectInfo {
        id: "hysteresis",
        description: "force loop with memory that does not depend on the rate",
        parameters: &[
            ParameterInfo::linear("force_n", RESISTANCE_N)
                .meaning("force at which the loop saturates"),
            // From the resolution of the encoder to more than the stroke.
            ParameterInfo::scale("slip_mm", [5e-3, 20.0])
                .meaning("travel within which the force saturates"),
        ],
        switches: &[Switch {
            name: "bouc_wen_exponent",
            meaning: "0: Maxwell slip (Iwan 1966); 1 or 2: Bouc–Wen with this exponent (Wen 1976); from 10: one element, elastic until it slips (Prandtl 1928)",
        }],
        excited_by: "motion of several amplitudes, with inner loops",
        ..MECHANICS
    },
    EffectInfo {
        id: "creep",
        description: "slow viscoelastic relaxation, a spring in series with a damper",
        parameters: &[
            // The published stiffness of the joint is 120 to 180 N/mm.
            ParameterInfo::linear("stiffness_n_mm", [0.0, 1e3]).meaning("stiffness of the spring"),
            ParameterInfo::scale("time_constant_s", [0.02, 1e3])
                .meaning("time in which the force of a held displacement falls to 1/e"),
        ],
        excited_by: "a step that is held, or motion at frequencies far apart",
        ..MECHANICS
    },
    EffectInfo {
        id: "constant_load",
        description: "steady force on the joint (gravity, imbalance, preload)",
        parameters: &[ParameterInfo::linear("force_n", FORCE_N)
            .meaning("force in the direction of +x")],
        excited_by: "any motion; a wide range of pressures separates it from a position offset",
        ..MECHANICS
    },
    EffectInfo {
        id: "added_inertia",
        description: "reflected mass that the model lacks",
        // The datasheet gives 254 kg at the joint, and the sum must stay positive.
        parameters: &[ParameterInfo::linear("mass_kg", [-150.0, 5e3])
            .meaning("additional mass; negative if the model has too much")],
        excited_by: "fast motion",
        ..MECHANICS
    },
    EffectInfo {
        id: "backlash",
        description: "play between joint and encoder",
        parameters: &[ParameterInfo::linear("gap_mm", [0.0, 20.0]).meaning("full width of the play")],
        excited_by: "reversals at several amplitudes",
        ..MECHANICS
    },
    EffectInfo {
        id: "cogging",
        name: "position-periodic force",
        description: "force periodic in the position",
        parameters: &[
            ParameterInfo::linear("force_n", FORCE_N)
                .meaning("amplitude of the force `−force_n · sin(2π x/pitch_mm)`"),
            // From a few steps of the encoder to more than the stroke.
            ParameterInfo::scale("pitch_mm", [0.02, 50.0]).meaning("period in the position"),
        ],
        excited_by: "slow motion over the whole range",
        ..MECHANICS
    },
    EffectInfo {
        id: "tendon_slack",
        description: "tendon that is slack beyond a displacement",
        parameters: &[
            ParameterInfo::linear("displacement_mm", [0.0, 20.0]).off_at(None).meaning(
                "displacement, to either side, beyond which the chamber that shortens keeps its volume",
            ),
            ParameterInfo::linear("stiffness_loss", [0.0, 1.0])
                .meaning("share of the elastic force's further growth that is lost there"),
        ],
        excited_by: "motion beyond the slack displacement, to both sides",
        ..MECHANICS
    },
    EffectInfo {
        id: "stiffness_drift",
        description: "restoring force that changes slowly with time",
        parameters: &[ParameterInfo::linear("relative_per_min", [-0.9, 10.0])
            .meaning("restoring force `f · (1 + relative_per_min · t/(60 s))`")],
        excited_by: "a long recording, or the same motion at its two ends",
        ..MECHANICS
    },
    EffectInfo {
        id: "stiffness_scale",
        name: "wrong stiffness",
        description: "restoring force that is off by a constant factor",
        parameters: &[ParameterInfo::linear("relative", [-0.9, 5.0])
            .meaning("restoring force `f · (1 + relative)`")],
        excited_by: "motion at frequencies far apart",
        ..MECHANICS
    },
];
