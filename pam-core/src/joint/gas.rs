//! Isothermal ideal gas in a chamber of changing volume: `P V = C m`.

use crate::scalar::Scalar;

/// Pressure rate of a chamber with mass flow ṁ,
/// `Ṗ = C (ṁ/V − m V̇/V²)` (kPa/s), for volume `V` (mm³), volume rate `V̇` (mm³/s), air mass `m`
/// (g), mass flow `ṁ` (g/s) and gas coefficient `C` (kPa·mm³/g).
#[inline]
pub fn pressure_rate<S: Scalar>(
    gas_coefficient: S,
    mass_g: S,
    mass_flow_g_s: S,
    volume_mm3: S,
    volume_rate_mm3_s: S,
) -> S {
    gas_coefficient
        * (mass_flow_g_s / volume_mm3 - mass_g * volume_rate_mm3_s / (volume_mm3 * volume_mm3))
}

/// Pressure rate of a closed chamber, `Ṗ = −C m V̇/V²` (kPa/s).
#[inline]
pub fn closed_pressure_rate<S: Scalar>(
    gas_coefficient: S,
    mass_g: S,
    volume_mm3: S,
    volume_rate_mm3_s: S,
) -> S {
    -(gas_coefficient * mass_g * volume_rate_mm3_s / (volume_mm3 * volume_mm3))
}

/// Pressure of sealed air, `P = C m / V`, kPa absolute.
#[inline]
pub fn sealed_pressure_kpa<S: Scalar>(gas_coefficient: S, mass_g: S, volume_mm3: S) -> S {
    gas_coefficient * mass_g / volume_mm3
}

/// Air in a chamber by the gas law, `m = P V / C`, g.
#[inline]
pub fn sealed_mass_g<S: Scalar>(gas_coefficient: S, pressure_kpa: S, volume_mm3: S) -> S {
    pressure_kpa * volume_mm3 / gas_coefficient
}
