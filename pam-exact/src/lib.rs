//! Exact simulation, gradients and synthesis for joints whose force is a network of rectifiers.
//!
//! With LeakyReLU or ReLU and sealed air the learned force depends on `(x, ẋ)` alone and is *piecewise
//! affine*: inside one activation pattern
//!
//! ```text
//! m ẍ = u(t) − a − b x − (c + B) ẋ
//! ```
//!
//! is a linear equation with a closed-form solution. Nothing is discretised: there are no steps, no
//! tolerances, and no step error at kinks.
//!
//! | part | does |
//! |---|---|
//! | [`PiecewiseNetwork`], [`Plane`] | the network on a plane of two of its inputs |
//! | [`ExactSolver`] | trajectories, their losses, and gradients by transposed propagators |
//! | [`ExactTrajectory`] | one solution at any time, with its crossings |
//! | [`forward_sensitivities`] | tangents by the propagators themselves |
//! | [`Partition`] | the polygons in which the force is affine: exact maps of stiffness and damping |
//! | [`InverseSolver`] | air masses for a motion and a stiffness: the global optimum with a certificate |
//!
//! # Patterns and polygons
//!
//! The first layer's kinks are straight lines in the plane, deeper ones are lines inside each pattern, so
//! a pattern holds in a convex polygon. Its sides, a handful of the network's units, are found once: a
//! step checks these instead of all units. Every side knows the pattern behind it, so that a crossing is
//! a look-up; a pattern that is met for the first time is made from its neighbour by a change of rank one,
//! and its sides are the corners of the hull of its half-planes' dual points.
//!
//! # Crossings
//!
//! Over a step between samples the motion stays within a known distance of its chord, `h²/8` times a
//! bound of its second derivative. A side whose margin at both ends exceeds that distance is not crossed.
//! A margin that falls throughout the step, by a bound of its curvature, has its root found by Halley's
//! method on the motion. Any other is a power series in time; an interval is dropped only if the ends and
//! the bound prove it free of roots, otherwise it is halved until the margin is monotonic there, and the
//! root is found within its bracket. So no crossing above rounding is missed; touches are no crossings,
//! several crossings at one instant follow one another without time passing.
//!
//! # Gradients
//!
//! The field is continuous across kinks, so the costate is too: nothing is added at a crossing. Within a
//! pattern the force's derivative by any weight is affine in `x` and `ẋ`, so all that the weights need are
//! three integrals of the velocity's costate times `1`, `x` and `ẋ`, summed over all the time that is spent
//! in the pattern. One outer product a pattern and layer would turn them into the gradient; for the last
//! hidden layer sums over subtrees of patterns do with a vector a pattern.
//!
//! ```
//! use pam_core::force::{Dense, Mlp};
//! use pam_core::{Activation, JointModel, NetworkForce, SealedMasses};
//! use pam_exact::{ExactMotion, ExactProblem, ExactSolver, ForceSignal};
//! use pam_solvers::Interpolation;
//!
//! // f = 150 N/mm · x, from two rectifiers: 75 (x + |x|) − 75 (|x| − x).
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
//!
mod adjoint;
mod affine;
mod atlas;
mod cell;
mod clip;
mod crossing;
mod event;
mod forcing;
mod fundamental;
mod gradient;
mod hull;
mod inverse;
mod lanes;
mod motion;
mod network;
mod partition;
mod pullback;
mod sensitivity;
mod series;
mod sides;
mod solve;
mod step;
mod trajectory;

pub use cell::Window;
pub use forcing::ForceSignal;
pub use gradient::{ExactProblem, ExactSolver};
pub use inverse::{Certificate, InverseProblem, InverseSolution, InverseSolver};
pub use motion::ExactMotion;
pub use network::{PiecewiseNetwork, Plane};
pub use partition::{Partition, Partitioner, Polygon};
pub use sensitivity::{ExactDirection, forward_sensitivities};
pub use solve::ExactStatistics;
pub use trajectory::{Crossing, ExactTrajectory};
