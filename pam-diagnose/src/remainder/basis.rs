//! The terms of a smooth correction.

use crate::terms::{
    Factor, Function, Place, Term, Variable, VariableKind, is_dry_level, relaxing, repeating,
};

/// Sizes at which the direction of a variable turns, relative to its typical size: the first one is close to dry friction.
const TURNING: [f64; 2] = [0.05, 0.4];
/// Distances from zero at which a correction may bend, relative to the typical size.
const BENDS: [f64; 2] = [0.3, 0.65];
/// Time constant of the exponential decay with time, relative to the longest recording.
const FADING: f64 = 0.25;
/// Time constants of what a correction remembers, s.
const LAGS_S: [f64; 3] = [0.1, 0.5, 2.5];
/// Widths of slip elements, relative to the typical size.
const SLIPS: [f64; 2] = [0.15, 0.5];

/// Terms of low order in all variables, for every place of a family: a constant, powers, directions, products of two.
pub(crate) fn smooth(family: usize, variables: &[Variable], places: &[Place]) -> Vec<Term> {
    of_family(family, places)
        .flat_map(|k| {
            let products = at(&places[k], variables).into_iter();
            products.map(move |factors| Term::new(k, factors, variables, places))
        })
        .collect()
}

/// Terms that fade with time, for every place of a family, and terms that remember the variables or repeat along them, where
/// these can be.
pub(crate) fn remembering(family: usize, variables: &[Variable], places: &[Place]) -> Vec<Term> {
    of_family(family, places)
        .flat_map(|k| {
            let mut products = fading(&places[k], variables);
            products.extend(relaxing(&places[k], variables, &LAGS_S));
            if places[k].remembers {
                products.extend(lagged(&places[k], variables));
            }
            products.into_iter().map(move |factors| Term::new(k, factors, variables, places))
        })
        .collect()
}

/// Sines and cosines of the time with some periods, for every place of a family.
pub(crate) fn waves(
    family: usize,
    variables: &[Variable],
    places: &[Place],
    periods_s: &[f64],
) -> Vec<Term> {
    let mut all = Vec::new();
    for k in of_family(family, places) {
        for &time in places[k].variables.iter().filter(|v| variables[**v].is_time()) {
            for &period in periods_s {
                let factors =
                    [Function::Sine, Function::Cosine].map(|f| Factor::of(time, f, period));
                all.extend(factors.map(|f| Term::new(k, vec![f], variables, places)));
            }
        }
    }
    all
}

/// The places of a family at which a smooth term can act.
fn of_family(family: usize, places: &[Place]) -> impl Iterator<Item = usize> {
    (0..places.len()).filter(move |&k| places[k].family == family && !is_dry_level(k, places))
}

fn plain(variable: usize, function: Function) -> Factor {
    Factor::of(variable, function, 1.0)
}

fn at(place: &Place, variables: &[Variable]) -> Vec<Vec<Factor>> {
    use Function::{Above, Absolute, Below, Cube, Linear, Saturated, SignedSquare, Square};
    let kind = |k: usize| variables[k].kind;
    let slow = |k: usize| kind(k) == VariableKind::Slow;
    let known: Vec<usize> =
        place.variables.iter().copied().filter(|&k| kind(k) != VariableKind::Combined).collect();
    let moving: Vec<usize> = known.iter().copied().filter(|&k| !slow(k)).collect();
    let turning: Vec<usize> =
        known.iter().copied().filter(|&k| kind(k) == VariableKind::Turning).collect();
    let turned = |k: usize, width: f64| Factor::of(k, Saturated, width * variables[k].size);
    let mut all: Vec<Vec<Factor>> = vec![Vec::new()];
    all.extend(known.iter().map(|&k| vec![plain(k, Linear)]));
    all.extend(moving.iter().flat_map(|&k| [vec![plain(k, Square)], vec![plain(k, Cube)]]));
    for (i, &a) in known.iter().enumerate() {
        let others = known[i + 1..].iter().filter(|b| !(slow(a) && slow(**b)));
        all.extend(others.map(|&b| vec![plain(a, Linear), plain(b, Linear)]));
    }
    if !place.rich {
        let squares = known.iter().filter(|k| slow(**k));
        all.extend(squares.map(|&k| vec![plain(k, Square)]));
        return all;
    }
    for &k in &turning {
        all.extend([vec![plain(k, Absolute)], vec![plain(k, SignedSquare)]]);
        all.extend(TURNING.map(|width| vec![turned(k, width)]));
        for &other in known.iter().filter(|o| **o != k) {
            // How large a friction is, goes with the size of something.
            if slow(other) {
                all.push(vec![turned(k, TURNING[0]), plain(other, Linear)]);
            }
            if variables[other].signed {
                all.push(vec![turned(k, TURNING[0]), plain(other, Absolute)]);
            }
        }
    }
    for &k in &moving {
        let bends = BENDS.map(|at| at * variables[k].size);
        all.extend([Above, Below].iter().flat_map(|f| bends.map(|at| vec![Factor::of(k, *f, at)])));
    }
    for &a in &moving {
        let others = moving.iter().filter(|b| **b != a);
        all.extend(others.map(|&b| vec![plain(a, Square), plain(b, Linear)]));
    }
    all
}

/// Exponential decay with time, alone and times each variable that moves.
fn fading(place: &Place, variables: &[Variable]) -> Vec<Vec<Factor>> {
    let is_moving =
        |k: &&usize| matches!(variables[**k].kind, VariableKind::Moving | VariableKind::Turning);
    let mut all = Vec::new();
    for &time in place.variables.iter().filter(|k| variables[**k].is_time()) {
        let fading = Factor::of(time, Function::Fading, FADING * variables[time].size);
        all.push(vec![fading]);
        let moving = place.variables.iter().filter(is_moving);
        all.extend(moving.map(|&k| vec![fading, plain(k, Function::Linear)]));
    }
    all
}

fn lagged(place: &Place, variables: &[Variable]) -> Vec<Vec<Factor>> {
    let known = place.variables.iter().filter(|k| variables[**k].is_remembered());
    let mut all = Vec::new();
    for &k in known {
        for time_s in LAGS_S {
            let of = |of| Factor::low_pass(k, of, time_s);
            // A level of friction that remembers how hard something was driven.
            let turning = place
                .variables
                .iter()
                .filter(|v| place.rich && variables[**v].kind == VariableKind::Turning);
            all.extend(turning.map(|&v| {
                let width = TURNING[0] * variables[v].size;
                vec![of(Function::Absolute), Factor::of(v, Function::Saturated, width)]
            }));
            if variables[k].kind == VariableKind::Turning {
                all.push(vec![of(Function::Linear)]);
                all.push(vec![of(Function::Square), plain(k, Function::Linear)]);
                let moving = |x: &&usize| place.rich && variables[**x].kind == VariableKind::Moving;
                let others = place.variables.iter().filter(moving);
                all.extend(others.map(|&x| vec![of(Function::Square), plain(x, Function::Linear)]));
            } else {
                all.extend([Function::Linear, Function::Square].map(|f| vec![of(f)]));
            }
        }
    }
    // Where the motion turned, and what repeats along it: alone, and for a force as large as the pressures or the drive are.
    let drives =
        |k: usize| variables[k].kind == VariableKind::Moving && variables[k].change.is_none();
    // A dry friction may repeat as well: a force that turns with the velocity.
    let companion = |&k: &usize| match variables[k].kind {
        VariableKind::Turning => {
            Some(Factor::of(k, Function::Saturated, TURNING[0] * variables[k].size))
        }
        _ if variables[k].is_pressure() || drives(k) => Some(plain(k, Function::Linear)),
        _ => None,
    };
    let companions: Vec<Factor> =
        place.variables.iter().filter(|_| place.rich).filter_map(companion).collect();
    all.extend(repeating(place, variables, &SLIPS, &companions));
    all
}
