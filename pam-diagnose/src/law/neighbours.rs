//! Terms that differ from a term in one factor.

use super::library::{LAGGED, MOST_FACTORS, companions, functions, singles};
use crate::terms::{
    Factor, Function, Lag, Place, Term, Variable, VariableKind, is_dry_level, waves_along,
};

/// Time constants of another memory, s.
const LAGS_S: [f64; 2] = [0.3, 1.5];
/// Functions of a memory state.
const OF_MEMORY: [Function; 6] = [
    Function::Absolute,
    Function::Square,
    Function::SignedSquare,
    Function::Positive,
    Function::Saturated,
    Function::Decaying,
];
/// Width of a saturation or a decay of a memory state, relative to the typical size of the state.
const WIDTH: f64 = 0.2;

/// Exponents at which the fit of a power starts: a root, and exponents between and above those of the library.
const POWERS: [f64; 4] = [0.5, 1.5, 2.5, 4.0];

/// The term with another function, another variable, or more or less memory in the place of one of its factors, without one of
/// them, or with a further one; and the same term at the other places of its family. Terms with like factors have like neighbours,
/// in the same order.
pub(super) fn neighbours(term: &Term, variables: &[Variable], places: &[Place]) -> Vec<Term> {
    let place = &places[term.place];
    let with = |factors: Vec<Factor>| term.with_factors(factors, variables, places);
    let mut all = Vec::new();
    for (i, factor) in term.factors.iter().enumerate() {
        let mut others = siblings(*factor, variables);
        others.extend(of_other_variables(*factor, place, variables));
        if may_remember(term.place, places) {
            others.extend(with_memory(*factor, place, variables));
        }
        all.extend(others.into_iter().map(|other| {
            let mut factors = term.factors.clone();
            factors[i] = other;
            with(factors)
        }));
        let mut fewer = term.factors.clone();
        fewer.remove(i);
        all.push(with(fewer));
    }
    if term.factors.len() < MOST_FACTORS {
        let more = |k: &usize| further(*k, term, variables);
        all.extend(place.variables.iter().flat_map(more).map(|factor| {
            let mut factors = term.factors.clone();
            factors.push(factor);
            with(factors)
        }));
    }
    let is_other = |k: usize| {
        let other = &places[k];
        let is_like = other.family == place.family && other.unit == place.unit;
        k != term.place && is_like && !is_dry_level(k, places)
    };
    let others = (0..places.len()).filter(|k| is_other(*k));
    all.extend(others.map(|place| Term { place, ..term.clone() }));
    all
}

/// Whether terms with memory are allowed at a place. The level of a dry friction takes them if the force at which it acts does.
fn may_remember(place: usize, places: &[Place]) -> bool {
    let takes_level = |p: &Place| p.dry.is_some_and(|(level, _)| level == place);
    places[place].remembers || places.iter().any(|p| p.remembers && takes_level(p))
}

/// The other functions of a factor's variable, at all their scales; for a low-pass, other functions as its input and of its state.
fn siblings(factor: Factor, variables: &[Variable]) -> Vec<Factor> {
    match factor.lag {
        Some(Lag::LowPass { time_s, .. }) => {
            let inputs = LAGGED.into_iter().map(|of| (of, Function::Linear));
            let states = OF_MEMORY.into_iter().map(|function| (Function::Linear, function));
            let kinds = inputs.chain(states);
            let times = [time_s].into_iter().chain(LAGS_S);
            let with = |(of, function)| {
                times.clone().map(move |time_s| {
                    of_state(function, Factor::low_pass(factor.variable, of, time_s), variables)
                })
            };
            kinds.flat_map(with).filter(|f| !f.is_like(&factor)).collect()
        }
        Some(Lag::HighPass { .. }) => {
            let directed = [Function::SignedSquare, Function::Positive, Function::Negative];
            directed.map(|function| Factor { function, ..factor }).to_vec()
        }
        Some(Lag::Slip { .. }) => Vec::new(),
        None => {
            let mut all = singles(factor.variable, variables);
            all.retain(|f| f.function != factor.function);
            let gaussian = Factor { function: Function::Gaussian, ..factor };
            all.extend((factor.function == Function::Peaked).then_some(gaussian));
            all.extend(powers(factor.variable, variables));
            if variables[factor.variable].change.is_some() && !factor.function.is_wave() {
                all.extend(waves_along(factor.variable, variables));
            }
            all
        }
    }
}

/// Powers of a variable with exponents of their own.
fn powers(variable: usize, variables: &[Variable]) -> impl Iterator<Item = Factor> {
    let signed = variables[variable].signed.then_some(Function::SignedPower);
    let of = move |f| POWERS.map(|exponent| Factor::of(variable, f, exponent));
    [Function::Power].into_iter().chain(signed).flat_map(of)
}

/// A function of a memory state.
fn of_state(function: Function, state: Factor, variables: &[Variable]) -> Factor {
    Factor { function, scale: WIDTH * state.argument_size(variables), ..state }
}

/// The same function of the other variables that have it.
fn of_other_variables(factor: Factor, place: &Place, variables: &[Variable]) -> Vec<Factor> {
    let own = &variables[factor.variable];
    let slow = |v: &Variable| matches!(v.kind, VariableKind::Slow | VariableKind::Combined);
    let other = |&k: &usize| {
        let v = &variables[k];
        let is_like = slow(v) == slow(own) && v.is_time() == own.is_time();
        let moved = Factor { variable: k, scale: factor.scale / own.size * v.size, ..factor };
        match factor.lag {
            _ if k == factor.variable || !is_like => Vec::new(),
            Some(Lag::HighPass { .. }) if v.relaxes() => vec![moved],
            Some(Lag::LowPass { of, .. }) if v.is_remembered() => {
                let lag = |time_s| Factor::low_pass(k, of, time_s).lag;
                let others = LAGS_S.map(|time_s| Factor { lag: lag(time_s), ..moved });
                [moved].into_iter().chain(others).collect()
            }
            None if functions(v).contains(&factor.function) => vec![moved],
            _ => Vec::new(),
        }
    };
    place.variables.iter().flat_map(other).collect()
}

/// A factor that remembers in the place of one that does not or in another way, and the other way round.
fn with_memory(factor: Factor, place: &Place, variables: &[Variable]) -> Vec<Factor> {
    let relaxed = |k: usize| {
        LAGS_S.into_iter().flat_map(move |time_s| {
            let state = Factor::low_pass(k, Function::Linear, time_s);
            [state, of_state(Function::Saturated, state, variables)]
        })
    };
    match factor.lag {
        Some(Lag::LowPass { of, .. }) if factor.function == Function::Linear => {
            vec![Factor::of(factor.variable, of, 1.0)]
        }
        Some(Lag::LowPass { of, .. }) if factor.function == Function::Decaying => {
            let scale = factor.scale;
            let at_once = match of {
                Function::Absolute => Some((Function::Decaying, scale)),
                Function::Square => Some((Function::Gaussian, scale.sqrt())),
                _ => None,
            };
            at_once.into_iter().map(|(f, scale)| Factor::of(factor.variable, f, scale)).collect()
        }
        // A spring that slips, and one that a damper relaxes.
        Some(Lag::Slip { .. }) => {
            let is_turning = |k: &&usize| variables[**k].kind == VariableKind::Turning;
            place.variables.iter().filter(is_turning).copied().flat_map(relaxed).collect()
        }
        None if LAGGED.contains(&factor.function) && variables[factor.variable].is_remembered() => {
            let with = |time_s| Factor::low_pass(factor.variable, factor.function, time_s);
            LAGS_S.into_iter().map(with).collect()
        }
        _ => Vec::new(),
    }
}

/// Factors of a variable that may stand beside those of a term. Of one that the term has already, only what confines the term to
/// a range of it.
fn further(variable: usize, term: &Term, variables: &[Variable]) -> Vec<Factor> {
    let has = |f: &Factor| f.variable == variable && f.lag.is_none();
    let mut all = companions(variable, variables);
    if term.factors.iter().any(has) {
        all.retain(|f| f.function == Function::Peaked);
        let gaussians: Vec<Factor> =
            all.iter().map(|f| Factor { function: Function::Gaussian, ..*f }).collect();
        all.extend(gaussians);
    } else if variables[variable].change.is_some() {
        all.extend(waves_along(variable, variables));
    }
    all
}
