//! Exact simulation, gradients and synthesis for joints whose force is a (leaky) ReLU network.
//!
//! With sealed air the learned force depends on `(x, ẋ)` alone and is piecewise affine. In each linear
//! region,
//!
//! ```text
//! m ẍ = u(t) − a − b x − (c + B) ẋ
//! ```
//!
//! is a linear equation with a closed-form solution. There is no discretisation: no step sizes, no
//! tolerances, and no step error at kinks.
//!
//! | part | does |
//! |---|---|
//! | [`ReluNetwork`], [`Plane`] | the network as a piecewise-affine function of two of its inputs |
//! | [`ExactSolver`] | trajectories, their losses, and gradients by transposed propagators |
//! | [`ExactTrajectory`] | one solution at any time, with its crossings |
//! | [`forward_sensitivities`] | tangents by the propagators themselves |
//! | [`Partition`] | the linear regions of a plane: exact maps of stiffness and damping |
//! | [`InverseSolver`] | air masses for a motion and a stiffness: the global optimum with a certificate |
//!
//! The modules build on each other in this order; each explains its method in its `mod.rs`:
//!
//! 1. `network`: pre-activations and force of an activation pattern, as affine functions on a plane.
//! 2. `regions`: the polygons in which a pattern holds, their facets, and the cache of those met.
//! 3. `step`: the closed-form step within a region, and the location of the first facet it crosses.
//! 4. `trajectory`: steps from forcing segment to forcing segment.
//! 5. `gradient`: costates and tangents, and the gradient of the weights region by region.
//! 6. `solver`: many trajectories in parallel, with losses and gradients.
//! 7. `inverse`: synthesis on the plane of the two air masses.
//!
//! ```
//! use pam_core::force::{Dense, Mlp};
//! use pam_core::{Activation, JointModel, NetworkForce, SealedMasses};
//! use pam_exact::{ExactMotion, ExactProblem, ExactSolver, ForceSignal};
//! use pam_solvers::Interpolation;
//!
//! // f = 150 N/mm · x, from two units: 75 (x + |x|) − 75 (|x| − x).
//! let hidden = Dense::from_rows(&[0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0, 0.0], vec![0.0, 0.0])?;
//! let output = Dense::from_rows(&[150e3, -150e3], vec![0.0])?;
//! let force = NetworkForce::new(Mlp::new(vec![hidden, output], Activation::from_name("relu")?)?)?;
//! let model = JointModel::datasheet(force);
//! let motion = ExactMotion::new(&model)?;
//! let times = [0.0, 0.05, 0.1];
//! let problem = ExactProblem {
//!     masses: SealedMasses::new(0.08, 0.08)?,
//!     signal: ForceSignal {
//!         times_s: &times,
//!         force_mn: &[0.0; 3],
//!         interpolation: Interpolation::Hold,
//!     },
//!     t0: 0.0,
//!     t1: 0.1,
//!     y0: [1.0, 0.0],
//!     observe_s: &times,
//! };
//! let mut solver = ExactSolver::new();
//! assert!(solver.solve(&motion, &[problem]).is_empty());
//! let omega = (150e3 / motion.mass_kg).sqrt();
//! assert!((solver.observed(0)[4] - (0.1 * omega).cos()).abs() < 1e-12);
//! # Ok::<(), pam_core::ModelError>(())
//! ```

mod gradient;
mod inverse;
mod network;
mod regions;
mod simd;
mod solver;
mod step;
mod trajectory;

pub use gradient::{ExactDirection, ExactGradient, forward_sensitivities};
pub use inverse::{Certificate, InverseProblem, InverseSolution, InverseSolver};
pub use network::{Plane, ReluNetwork};
pub use regions::{Partition, RegionPolygon, Window};
pub use solver::ExactSolver;
pub use trajectory::{
    Crossing, ExactMotion, ExactProblem, ExactStatistics, ExactTrajectory, ForceSignal,
};
