//! Effects in the gas.

use crate::{EffectInfo, Group, ParameterInfo, Switch};

/// A chamber that leaks faster is at room pressure after a few seconds, before an experiment begins.
const LEAK_PER_S: [f64; 2] = [0.0, 1.0];

/// The pressure of a changed gas law can act on the joint or on the sensors alone.
const FORCE_FEEDBACK: &[Switch] = &[Switch {
    name: "force_feedback",
    meaning: "1: the changed pressure ΔP acts on the joint with the force ΔP · dV/dx; 0: it does not",
}];

const GAS: EffectInfo = EffectInfo::new("", Group::Gas, "", &[]);

pub(crate) const EFFECTS: &[EffectInfo] = &[
    EffectInfo {
        id: "leak",
        name: "air leak",
        description: "air that leaks out of the chambers",
        parameters: &[
            ParameterInfo::linear("flexor_rate_per_s", LEAK_PER_S)
                .meaning("rate of the flexor: `ṁ = −rate · m · (P − P_atm)/P`"),
            ParameterInfo::linear("extensor_rate_per_s", LEAK_PER_S)
                .meaning("rate of the extensor"),
        ],
        excited_by: "a long recording at high pressure",
        ..GAS
    },
    EffectInfo {
        id: "polytropic_gas",
        name: "non-isothermal air",
        description: "pressure that follows a power of the volume other than the isothermal one",
        // Air alone has 1 to 1.4; dead volume and the expansion of the wall lower what is seen.
        parameters: &[ParameterInfo::linear("exponent", [0.5, 2.0])
            .off_at(Some(1.0))
            .meaning("n of `P · Vⁿ = constant`; 1 is isothermal, 1.4 adiabatic")],
        switches: FORCE_FEEDBACK,
        excited_by: "motion far from the middle, where the exponent and the geometry differ",
        ..GAS
    },
    EffectInfo {
        id: "geometry_coefficient",
        name: "wrong muscle geometry",
        description: "deformation coefficient ν of the chambers that is off by a factor",
        // ν is above 1/2 for any braid that shortens under pressure.
        parameters: &[ParameterInfo::linear("relative", [-0.6, 2.0])
            .meaning("coefficient `ν · (1 + relative)`")],
        switches: FORCE_FEEDBACK,
        excited_by: "motion far from the middle, where the exponent and the geometry differ",
        ..GAS
    },
];
