//! The restoring force over the displacement, for sealed pairs of muscles.

use crate::figure::{LineFigure, Role, Stroke};
use crate::page::{figure, number};
use maud::{Markup, html};
use pam_core::units::{ATMOSPHERE_KPA, KPA_PER_PSI, MN_PER_N};
use pam_core::{ForceInput, ForceModel, JointModel, SealedMasses};

/// Displacements between which the force is drawn, mm.
pub const REACH_MM: f64 = 5.0;

/// Velocities at which the force is drawn, mm/s.
pub const VELOCITIES_MM_S: [f64; 3] = [-5.0, 0.0, 5.0];

/// Pressures of the muscles at x = 0, psi gauge as the rig is commanded: 170, 308, 412, 515 and
/// 653 kPa absolute.
const PRESSURES_PSI: [f64; 5] = [10.0, 30.0, 45.0, 60.0, 80.0];

/// Colours of the pairs, distinguishable side by side.
const COLOURS: [Role; 5] =
    [Role::Category(0), Role::Category(1), Role::Category(2), Role::Category(3), Role::Category(8)];

/// Points of a curve.
const POINTS: usize = 201;

/// Step of the slope's estimate, mm.
const SLOPE_STEP_MM: f64 = 1.0;

/// Muscles sealed at x = 0 with these pressures, kPa absolute.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SealedPair {
    pressures_kpa: [f64; 2],
    masses: SealedMasses,
}

impl SealedPair {
    fn label(&self) -> String {
        let [f, e] = self.pressures_kpa.map(|p| number(p, 0));
        format!("{f}/{e}")
    }
}

/// The restoring force along the displacement, N, at `(x, f)` with x from −[`REACH_MM`] to
/// [`REACH_MM`] mm.
#[must_use]
pub fn force_curve<F: ForceModel<f64>>(
    model: &JointModel<f64, F>,
    masses: SealedMasses,
    velocity_mm_s: f64,
) -> Vec<(f64, f64)> {
    let mut force = force_n(model, masses, velocity_mm_s);
    let x = |k: usize| REACH_MM * (2.0 * k as f64 / (POINTS - 1) as f64 - 1.0);
    (0..POINTS).map(|k| (x(k), force(x(k)))).collect()
}

/// Where the restoring force is zero between −[`REACH_MM`] and [`REACH_MM`] at a velocity, mm, in
/// ascending order. Zeros that lie closer than 0.05 mm may be missed in pairs.
#[must_use]
pub fn equilibria_mm<F: ForceModel<f64>>(
    model: &JointModel<f64, F>,
    masses: SealedMasses,
    velocity_mm_s: f64,
) -> Vec<f64> {
    let curve = force_curve(model, masses, velocity_mm_s);
    let mut force = force_n(model, masses, velocity_mm_s);
    let mut zeros = Vec::new();
    for pair in curve.windows(2) {
        let ((mut low, f_low), (mut high, f_high)) = (pair[0], pair[1]);
        if f_low == 0.0 {
            zeros.push(low);
        } else if f_low * f_high < 0.0 {
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if force(middle) * f_low > 0.0 { low = middle } else { high = middle }
            }
            zeros.push(0.5 * (low + high));
        }
    }
    if let Some((x, 0.0)) = curve.last() {
        zeros.push(*x);
    }
    zeros
}

/// The learned force in two figures, symmetric and unequal pairs of muscles, with a table of their
/// equilibria and stiffnesses.
#[must_use]
pub fn force_curves<F: ForceModel<f64>>(model: &JointModel<f64, F>) -> Markup {
    let kpa = PRESSURES_PSI.map(|p| p * KPA_PER_PSI + ATMOSPHERE_KPA);
    let pair = |f: f64, e: f64| SealedPair {
        pressures_kpa: [f, e],
        masses: model.gas_law_masses(0.0, [f, e]),
    };
    let symmetric = kpa.map(|p| pair(p, p));
    let mut unequal = kpa.map(|p| pair(p, p));
    for (k, p) in unequal.iter_mut().enumerate() {
        *p = pair(kpa[k], kpa[kpa.len() - 1 - k]);
    }
    html! {
        p { "The restoring force f(x, ẋ) for muscles sealed at x = 0 with the pressures P_f/P_e in the "
            "legend (kPa absolute; their air by the gas law). A stable joint has a rising curve. Dotted "
            "vertical lines mark where the force is zero at standstill." }
        div.grid {
            (panel(model, "a", &symmetric, "a: equal pressures in both muscles."))
            (panel(model, "b", &unequal, "b: unequal pressures."))
        }
        (table(model, &symmetric, &unequal))
    }
}

fn panel<F: ForceModel<f64>>(
    model: &JointModel<f64, F>,
    title: &str,
    pairs: &[SealedPair],
    caption: &str,
) -> Markup {
    let mut plot = LineFigure::new(title, "displacement x (mm)", "restoring force (N)", 440, 400);
    let strokes = [Stroke::Dashed, Stroke::Solid, Stroke::Dotted];
    for (pair, role) in pairs.iter().zip(COLOURS) {
        for (velocity, stroke) in VELOCITIES_MM_S.into_iter().zip(strokes) {
            let still = velocity == 0.0;
            let label = if still { pair.label() } else { String::new() };
            let curve = force_curve(model, pair.masses, velocity);
            plot = plot.with_stroke(&label, role, stroke, curve);
            if still {
                for x in equilibria_mm(model, pair.masses, velocity) {
                    plot = plot.with_vertical(x, role).with("", role, vec![(x, 0.0)]);
                }
            }
        }
    }
    for (velocity, stroke) in VELOCITIES_MM_S.into_iter().zip(strokes) {
        let label = speed(velocity);
        plot = plot.with_stroke(&label, Role::Neutral, stroke, Vec::new());
    }
    figure(plot.to_svg(), caption)
}

fn table<F: ForceModel<f64>>(
    model: &JointModel<f64, F>,
    symmetric: &[SealedPair],
    unequal: &[SealedPair],
) -> Markup {
    let middle = unequal.len() / 2;
    let others = unequal.iter().enumerate().filter(|(k, _)| *k != middle).map(|(_, pair)| pair);
    html! {
        div.scroll { table {
            tr {
                th { "P_f/P_e (kPa)" } th { "m_f (g)" } th { "m_e (g)" }
                @for v in VELOCITIES_MM_S { th { "x₀ at " (speed(v)) " (mm)" } }
                th { "slope at x₀, 0 mm/s (N/mm)" }
            }
            @for pair in symmetric.iter().chain(others) {
                tr {
                    td { (pair.label()) }
                    td { (number(pair.masses.flexor_g, 4)) }
                    td { (number(pair.masses.extensor_g, 4)) }
                    @for v in VELOCITIES_MM_S { td { (listed(&equilibria_mm(model, pair.masses, v))) } }
                    td { (slope_at_rest(model, pair.masses)) }
                }
            }
        } }
        p.sub { "x₀: where the force is zero. Slope: the published four-point estimate of the stiffness, "
            "with steps of 1 mm." }
    }
}

fn listed(values: &[f64]) -> String {
    if values.is_empty() {
        return format!("outside ±{REACH_MM} mm");
    }
    values.iter().map(|v| signed(*v, 3)).collect::<Vec<_>>().join(", ")
}

/// A velocity with its sign.
fn speed(velocity_mm_s: f64) -> String {
    let plus = if velocity_mm_s > 0.0 { "+" } else { "" };
    format!("{plus}{} mm/s", signed(velocity_mm_s, 0))
}

fn signed(value: f64, digits: usize) -> String {
    number(value, digits).replace('-', "−")
}

/// `K̂ = [f(x+2h) + f(x+h) − f(x−h) − f(x−2h)] / 6h` at the only equilibrium at standstill, N/mm.
fn slope_at_rest<F: ForceModel<f64>>(model: &JointModel<f64, F>, masses: SealedMasses) -> String {
    let [x] = equilibria_mm(model, masses, 0.0)[..] else {
        return "–".into();
    };
    let (h, mut f) = (SLOPE_STEP_MM, force_n(model, masses, 0.0));
    let sum = f(x + 2.0 * h) + f(x + h) - f(x - h) - f(x - 2.0 * h);
    number(sum / (6.0 * h), 1)
}

fn force_n<'a, F: ForceModel<f64>>(
    model: &'a JointModel<f64, F>,
    masses: SealedMasses,
    velocity_mm_s: f64,
) -> impl FnMut(f64) -> f64 + 'a {
    let mut work = vec![0.0; model.force.work_len()];
    move |x| {
        let input = ForceInput {
            displacement_mm: x,
            velocity_mm_s,
            mass_flexor_g: masses.flexor_g,
            mass_extensor_g: masses.extensor_g,
        };
        model.force.restoring_force_mn(&input, &mut work) / MN_PER_N
    }
}
