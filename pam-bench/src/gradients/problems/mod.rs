//! The problems, one file each.
//!
//! - [`linear`]: a damped oscillation, as a baseline;
//! - [`van_der_pol`]: a nonlinear oscillation;
//! - [`quartic`]: `u̇ = (t − θ)⁴`, whose steps suit the state and not the gradient;
//! - [`stiff`]: a slow state with a fast one, where nothing may be integrated back;
//! - [`joint`]: the hybrid model of the joint with a network of any activation and width, made by
//!   [`network`] without any data;
//! - [`own`]: a field of your own, from a file of expressions.
//!
//! All but the joint are a [`SmallField`](small::SmallField).

use super::cells::{Cells, Grid};
use super::method::{all, of_joint};
use super::solver::Solver;
use pam_core::Activation;

pub mod joint;
pub mod linear;
pub mod network;
pub mod own;
pub mod quartic;
pub mod small;
pub mod stiff;
pub mod van_der_pol;

/// A problem of the list.
#[derive(Debug, Clone, Copy)]
pub enum Problem {
    /// The damped oscillation.
    Linear,
    /// Van der Pol's oscillator.
    VanDerPol,
    /// `u̇ = (t − θ)⁴`.
    Quartic,
    /// A slow state with a fast one.
    Stiff,
    /// The joint.
    Joint {
        /// Activation of its network.
        activation: Activation,
        /// Width of its network.
        width: usize,
    },
}

impl Problem {
    /// Every method on the problem up to `horizon_s`, with every solver. The methods are compiled here, once for all
    /// who call.
    #[must_use]
    pub fn with_every_method(
        self,
        part: &str,
        horizon_s: f64,
        solvers: Vec<Solver>,
    ) -> Box<dyn Cells> {
        let part = part.into();
        let case = match self {
            Self::Linear => linear::case(horizon_s),
            Self::VanDerPol => van_der_pol::case(horizon_s),
            Self::Quartic => quartic::case(horizon_s),
            Self::Stiff => stiff::case(horizon_s),
            Self::Joint { activation, width } => {
                let case = joint::case(activation, width, horizon_s);
                return Box::new(Grid { part, case, methods: of_joint(), solvers });
            }
        };
        Box::new(Grid { part, case, methods: all(), solvers })
    }
}
