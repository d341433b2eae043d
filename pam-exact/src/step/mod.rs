//! One closed-form step within a linear region, and the location of the first facet that it crosses.
//!
//! Inside a region the joint is a linear oscillator driven by a straight line,
//!
//! ```text
//! ẍ + ζ ẋ + κ x = w₀ + w₁ τ        κ = b/m    ζ = (c + B)/m    w = (u − a)/m
//! ```
//!
//! whose propagator is a short series. A step ends at the end of the forcing segment or at the first facet.
//! The margin `g(τ) = α + β x(τ) + γ ẋ(τ)` of a facet is an event function; locating its first zero is done in
//! three stages, each left where it is conclusive:
//!
//! 1. The motion stays within `h²/8 max|ẍ|` of its chord, so facets whose margins at both ends exceed that
//!    deviation are not crossed.
//! 2. If a bound of `|g̈|` proves that each remaining margin rises or falls throughout the step, each has one
//!    root at most. Inverse cubic interpolation estimates all of them; Halley's method corrects the earliest.
//! 3. Otherwise `g` is a Taylor series, and bisection with the same bound isolates its first root. A part of
//!    the step is dropped only if values and bound prove it free of roots.
//!
//! So no crossing above rounding is missed (compare the interval arguments in T. Park, P. I. Barton, *State
//! event location in differential-algebraic models*, 1996).
//!
//! | file | holds |
//! |---|---|
//! | `propagator` | the oscillator, its propagator and the integrals for derivatives |
//! | `coefficients` | the oscillator of a region, with the propagator of the nominal step |
//! | `closed_form` | one step with bounds of acceleration and jerk; stage 1 |
//! | `taylor` | the motion as a power series |
//! | `monotonic_exit` | stage 2 |
//! | `event` | stage 3 for one facet |
//! | `exit` | the first facet crossed, by all stages |

pub(crate) mod closed_form;
pub(crate) mod coefficients;
mod event;
pub(crate) mod exit;
mod monotonic_exit;
pub(crate) mod propagator;
mod taylor;
