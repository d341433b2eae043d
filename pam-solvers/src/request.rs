//! Checks of a request before a solve.

use crate::controller::StepController;
use crate::input::Input;
use crate::save_at::SaveAt;
use crate::tableau::Tableau;
use crate::term::Term;
use pam_core::{Scalar, VectorField};

/// Numbers of states, of inputs that the field takes, and of inputs that are given.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lengths {
    pub(crate) states: usize,
    pub(crate) inputs: usize,
    pub(crate) given_inputs: usize,
}

/// Checks interval, initial state, inputs, and the times to save at, if there are any.
pub(crate) fn check_problem<S: Scalar>(
    lengths: Lengths,
    t0: f64,
    t1: f64,
    y0: &[S],
    times_s: Option<&[f64]>,
) -> Result<(), String> {
    if !(t0.is_finite() && t1.is_finite() && t1 >= t0) {
        return Err(format!("the interval [{t0}, {t1}] s is not ordered and finite"));
    }
    if y0.is_empty() || y0.len() != lengths.states {
        return Err(format!(
            "the field has {} states, the initial state has {}",
            lengths.states,
            y0.len()
        ));
    }
    if let Some(i) = y0.iter().position(|v| !v.real().is_finite()) {
        return Err(format!("initial state {i} is {}", y0[i].real()));
    }
    if lengths.given_inputs != lengths.inputs {
        return Err(format!(
            "the field takes {} inputs, {} are given",
            lengths.inputs, lengths.given_inputs
        ));
    }
    if let Some(times) = times_s {
        if times.windows(2).any(|w| w[0].partial_cmp(&w[1]) != Some(std::cmp::Ordering::Less)) {
            return Err("the times to save at must increase".into());
        }
        if times.iter().any(|t| !(t0..=t1).contains(t)) {
            return Err(format!("a time to save at is outside [{t0}, {t1}] s"));
        }
    }
    Ok(())
}

/// [`check_problem`] of a term.
pub(crate) fn check_term<S, F, I>(
    term: &Term<F, I>,
    t0: f64,
    t1: f64,
    y0: &[S],
    save_at: SaveAt<'_>,
) -> Result<(), String>
where
    S: Scalar,
    F: VectorField<S>,
    I: Input<S>,
{
    let lengths = Lengths {
        states: term.field.state_len(),
        inputs: term.field.input_len(),
        given_inputs: term.input.input_len(),
    };
    let times_s = match save_at {
        SaveAt::Times(times) => Some(times),
        SaveAt::End | SaveAt::Steps | SaveAt::Dense => None,
    };
    check_problem(lengths, t0, t1, y0, times_s)
}

/// Checks that a controller can drive a method over `state_len` states.
pub(crate) fn check_control<C: StepController + ?Sized>(
    controller: &C,
    tableau: &Tableau,
    state_len: usize,
) -> Result<(), String> {
    if let Some(tolerances) = controller.tolerances() {
        if tableau.error.is_none() {
            return Err(format!("{} has no error estimate; give it a constant step", tableau.name));
        }
        if !tolerances.is_valid() {
            return Err("tolerances must be positive numbers".into());
        }
        if tolerances.state_len().is_some_and(|len| len != state_len) {
            return Err("there must be one absolute tolerance for each state".into());
        }
    }
    match controller.initial_step_s() {
        Some(h) if !(h.is_finite() && h > 0.0) => {
            Err(format!("a step of {h} s is not positive and finite"))
        }
        _ => Ok(()),
    }
}
