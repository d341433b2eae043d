//! Fast simulation and gradients of joints whose force is a smooth network.
//!
//! With sealed air the learned force of one recording is a smooth function of `(x, ẋ)` alone, and a motion of a minute
//! returns to the same small region again and again. So the network is evaluated at a few thousand nodes in place of every
//! stage of every step: on patches of the plane the force is a polynomial of degree seven in each direction, checked between
//! its nodes and halved until the error is below a tolerance. The motion is simulated on the patches, and the derivatives by
//! the network's weights come back the same way: cotangents of the coefficients, of the values at the nodes, and one batched
//! pass of the network.
//!
//! | file | holds |
//! |---|---|
//! | `polynomial` | interpolation at Chebyshev nodes; evaluation, slopes and their transpose by whole vectors |
//! | `nodes` | the network at nodes, in batches |
//! | `surface` | the patches of one trajectory |
//! | `forcing` | the measured force and its integrals over a step |
//! | `method` | the Runge–Kutta method |
//! | `trajectory` | one trajectory: its equations, its steps |
//! | `forward`, `backward` | steps, and their transpose |
//! | `run` | one trajectory with its loss |
//! | `solver` | many trajectories, and the gradient of the sum |

mod adams;
mod backward;
mod cells;
mod chebyshev;
mod course;
mod forcing;
mod forward;
mod march;
mod method;
mod nodes;
mod polynomial;
mod problem;
mod result;
mod retreat;
mod run;
mod samples;
mod settings;
mod solver;
mod surface;
mod trajectory;

pub use pam_solvers::ForceSignal;
pub use problem::SurrogateProblem;
pub use result::{SurrogateGradient, SurrogateStatistics};
pub use settings::SurrogateSettings;
pub use solver::{MotionLoss, SurrogateMotion, SurrogateSolver};
