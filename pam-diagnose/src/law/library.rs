//! The terms that are tried.

use crate::terms::{
    Factor, Function, Place, Term, Variable, VariableKind, is_dry_level, relaxing, repeating,
};

/// Scales of functions, relative to the typical size of their argument.
const THRESHOLDS: [f64; 3] = [0.2, 0.45, 0.7];
const WIDTHS: [f64; 3] = [0.05, 0.2, 0.6];
const DECAYS: [f64; 2] = [0.1, 0.4];
const BELLS: [f64; 2] = [0.15, 0.5];
/// Time constants of the exponential decay with time, relative to the longest recording.
const FADINGS: [f64; 3] = [0.1, 0.3, 1.0];
/// Thresholds of gauge pressures, relative to their typical size: what only acts above a pressure.
const PRESSURE_THRESHOLDS: [f64; 3] = [0.6, 0.85, 1.1];
/// A scale at which a stiffening is a cube, and one at which it is nearly an exponential function.
const STIFFENINGS: [f64; 2] = [0.8, 0.3];
/// Time constants, s.
const LAGS_S: [f64; 4] = [0.08, 0.3, 1.0, 4.0];
/// Functions of a variable that are remembered.
pub(super) const LAGGED: [Function; 4] =
    [Function::Linear, Function::Absolute, Function::Square, Function::SignedSquare];
/// Scale of the exponential decay of a loss with a memory state, relative to the typical size of the state.
const WORN: f64 = 0.4;
/// Widths of slip elements, relative to the typical size.
const SLIPS: [f64; 3] = [0.1, 0.25, 0.6];

/// Most factors of a term.
pub(super) const MOST_FACTORS: usize = 3;

/// All terms of up to two factors at the places of some families, each at a few scales.
pub(crate) fn library(families: &[usize], variables: &[Variable], places: &[Place]) -> Vec<Term> {
    let mut all = Vec::new();
    for (k, place) in places.iter().enumerate() {
        if families.contains(&place.family) && !is_dry_level(k, places) {
            let products = at(place, variables).into_iter();
            all.extend(products.map(|factors| Term::new(k, factors, variables, places)));
        }
    }
    all
}

/// Functions of a variable that moves; the last one only of one whose direction matters.
static OF_MOTION: [Function; 14] = [
    Function::Linear,
    Function::Absolute,
    Function::Square,
    Function::Cube,
    Function::SignedSquare,
    Function::Positive,
    Function::Negative,
    Function::Above,
    Function::Below,
    Function::Outside,
    Function::Stiffening,
    Function::Peaked,
    Function::Saturated,
    Function::Decaying,
];

/// The functions of a variable or of its low-pass, at their scales.
pub(crate) fn functions(variable: &Variable) -> &'static [Function] {
    use Function::{Above, Absolute, Fading, Linear, Negative, Positive, SignedSquare, Square};
    match variable.kind {
        VariableKind::Moving => &OF_MOTION[..OF_MOTION.len() - 1],
        VariableKind::Turning => &OF_MOTION,
        VariableKind::Slow | VariableKind::Combined if variable.signed => {
            &[Linear, Absolute, Square, SignedSquare, Positive, Negative]
        }
        VariableKind::Slow if variable.is_time() => &[Linear, Square, Fading],
        VariableKind::Slow => &[Linear, Square],
        VariableKind::Combined => &[Linear, Square, Above],
    }
}

/// A function at each of its scales.
pub(crate) fn at_scales(factor: Factor, kind: VariableKind, size: f64) -> Vec<Factor> {
    let scales: &[f64] = match factor.function {
        Function::Above if kind == VariableKind::Combined => &PRESSURE_THRESHOLDS,
        Function::Above | Function::Below | Function::Outside => &THRESHOLDS,
        Function::Stiffening => &STIFFENINGS,
        Function::Saturated => &WIDTHS,
        Function::Decaying => &DECAYS,
        Function::Peaked => &BELLS,
        Function::Fading => &FADINGS,
        _ => &[1.0],
    };
    scales.iter().map(|s| Factor { scale: s * size, ..factor }).collect()
}

/// Products of the terms of a law with one factor more, about as large as these are.
pub(crate) fn extensions(law: &[Term], variables: &[Variable], places: &[Place]) -> Vec<Term> {
    let mut all: Vec<Term> = Vec::new();
    for term in law.iter().filter(|t| t.factors.len() < MOST_FACTORS) {
        for &k in &places[term.place].variables {
            if term.factors.iter().any(|f| f.variable == k) {
                continue;
            }
            for more in companions(k, variables) {
                let mut factors = term.factors.clone();
                factors.push(more);
                all.push(term.with_factors(factors, variables, places));
            }
        }
    }
    all
}

pub(super) fn singles(variable: usize, variables: &[Variable]) -> Vec<Factor> {
    let Variable { kind, size, .. } = variables[variable];
    let of = |f: &Function| at_scales(Factor::of(variable, *f, 1.0), kind, size);
    functions(&variables[variable]).iter().flat_map(of).collect()
}

/// Factors that stand beside another one.
pub(super) fn companions(variable: usize, variables: &[Variable]) -> Vec<Factor> {
    use Function::{Absolute, Linear, Outside, Peaked, Positive, Saturated, Square};
    let plain = |f| Factor::of(variable, f, 1.0);
    let Variable { kind, size, signed, .. } = variables[variable];
    if variables[variable].is_time() {
        let fading = Factor::of(variable, Function::Fading, FADINGS[1] * size);
        return vec![plain(Linear), fading];
    }
    match kind {
        VariableKind::Slow | VariableKind::Combined if signed => {
            vec![plain(Linear), plain(Absolute)]
        }
        VariableKind::Slow | VariableKind::Combined => vec![plain(Linear)],
        VariableKind::Moving => {
            let outside = Factor::of(variable, Outside, THRESHOLDS[1] * size);
            let bell = Factor::of(variable, Peaked, BELLS[1] * size);
            let plain = [Linear, Absolute, Square, Positive].map(plain).into_iter();
            plain.chain([outside, bell]).collect()
        }
        VariableKind::Turning => {
            let turned = Factor::of(variable, Saturated, WIDTHS[0] * size);
            [Linear, Absolute, Square, Positive].map(plain).into_iter().chain([turned]).collect()
        }
    }
}

fn at(place: &Place, variables: &[Variable]) -> Vec<Vec<Factor>> {
    let known = &place.variables;
    let moves =
        |k: usize| matches!(variables[k].kind, VariableKind::Moving | VariableKind::Turning);
    let mut all = vec![Vec::new()];
    for &k in known {
        all.extend(singles(k, variables).into_iter().map(|f| vec![f]));
    }
    for (i, &a) in known.iter().enumerate() {
        for &b in &known[i + 1..] {
            // The only products of two slow variables are those of a pressure and the time.
            let [is_a, is_b] = [a, b].map(|k| variables[k].is_time());
            if !moves(a) && !moves(b) && is_a == is_b {
                continue;
            }
            // Of a variable that is slow, everything of the other one.
            let of = |k: usize, other: usize| {
                if moves(k) && !moves(other) && place.rich {
                    singles(k, variables)
                } else {
                    companions(k, variables)
                }
            };
            for f in of(a, b) {
                all.extend(of(b, a).into_iter().map(|g| vec![f, g]));
            }
        }
    }
    all.extend(relaxing(place, variables, &LAGS_S));
    if place.remembers {
        all.extend(remembering(place, variables));
    }
    all
}

fn remembering(place: &Place, variables: &[Variable]) -> Vec<Vec<Factor>> {
    use Function::{Absolute, Decaying, Linear, Saturated, SignedSquare, Square};
    let mut all = Vec::new();
    // Pressures: the time has no companion among what remembers.
    let is_slow = |k: &usize| {
        matches!(variables[*k].kind, VariableKind::Slow | VariableKind::Combined)
            && variables[*k].group == "pressures"
    };
    let slow: Vec<usize> = place.variables.iter().copied().filter(is_slow).collect();
    let turning = place.variables.iter().find(|k| variables[**k].kind == VariableKind::Turning);
    let moving: Vec<usize> = place
        .variables
        .iter()
        .copied()
        .filter(|k| variables[*k].kind == VariableKind::Moving)
        .collect();
    for &k in place.variables.iter().filter(|k| variables[**k].is_remembered()) {
        for of in LAGGED {
            for time_s in LAGS_S {
                let lagged = Factor::low_pass(k, of, time_s);
                all.push(vec![lagged]);
                if of == Linear {
                    all.push(vec![Factor { function: SignedSquare, ..lagged }]);
                    if place.rich {
                        let slow = slow.iter().map(|&s| vec![lagged, Factor::of(s, Linear, 1.0)]);
                        all.extend(slow);
                    }
                }
                if let (Some(&v), true) = (turning, place.rich) {
                    let turned = Factor::of(v, Saturated, WIDTHS[0] * variables[v].size);
                    let losses = [Factor::of(v, Linear, 1.0), turned];
                    all.extend(losses.map(|loss| vec![lagged, loss]));
                    // Damping or friction that decays the more the joint is worked.
                    if k == v && matches!(of, Absolute | Square) {
                        let scale = WORN * lagged.argument_size(variables);
                        let worn = Factor { function: Decaying, scale, ..lagged };
                        all.extend(losses.map(|loss| vec![worn, loss]));
                    }
                }
                // How hard something was driven softens or stiffens it: a size that is remembered, times where it is.
                if place.rich && matches!(of, Absolute | Square) {
                    all.extend(moving.iter().map(|&x| vec![lagged, Factor::of(x, Linear, 1.0)]));
                }
            }
        }
    }
    let drives = moving.iter().filter(|k| variables[**k].change.is_none());
    let as_large_as = slow.iter().chain(drives).filter(|_| place.rich);
    let mut companions: Vec<Factor> = as_large_as.map(|&s| Factor::of(s, Linear, 1.0)).collect();
    // A dry friction that repeats.
    let turned = |&v: &usize| Factor::of(v, Saturated, WIDTHS[0] * variables[v].size);
    companions.extend(turning.filter(|_| place.rich).map(turned));
    all.extend(repeating(place, variables, &SLIPS, &companions));
    all
}
