//! Fast simulation and gradients of joints whose force is a smooth network.
//!
//! With sealed air the learned force of one recording is a smooth function of `(x, ẋ)` alone, and a motion of a minute
//! returns to the same small region again and again. So the network is evaluated at a few thousand nodes in place of every
//! stage of every step: on patches of the plane the force is a polynomial of high degree, checked between its nodes and written
//! out as polynomials of degree seven on small cells. The motion is simulated on the cells, and the derivatives by the
//! network's weights come back the same way: cotangents of the coefficients, of the values at the nodes, and one batched pass of
//! the network.
//!
//! | file | holds |
//! |---|---|
//! | `chebyshev` | interpolation of any degree at Chebyshev nodes |
//! | `polynomial` | polynomials of cells: evaluation, slopes and their transpose by whole vectors |
//! | `cells` | the cells of a patch, a linear map of the values at its nodes |
//! | `nodes` | the network at nodes, in batches |
//! | `surface` | the patches of one trajectory |
//! | `forcing`, `samples` | the measured force and its integrals over a step, and over equal intervals |
//! | `method`, `adams` | the Runge–Kutta method and Adams' method |
//! | `trajectory` | one trajectory: its equations, its steps |
//! | `forward`, `backward` | Runge–Kutta steps, and their transpose |
//! | `adams_forward`, `adams_backward` | Adams steps, and their transpose |
//! | `segments` | whole trajectories of segments of both, forward and backward |
//! | `run` | one trajectory with its loss |
//! | `solver` | many trajectories, and the gradient of the sum |

mod adams;
mod adams_backward;
mod adams_forward;
mod backward;
mod cells;
mod chebyshev;
mod forcing;
mod forward;
mod method;
mod nodes;
mod polynomial;
mod problem;
mod result;
mod run;
mod samples;
mod segments;
mod settings;
mod solver;
mod surface;
mod trajectory;

pub use nodes::{PointForces, PointMemory};
pub use pam_solvers::ForceSignal;
pub use problem::SurrogateProblem;
pub use result::{SurrogateGradient, SurrogateStatistics};
pub use settings::SurrogateSettings;
pub use solver::{MotionLoss, SurrogateMotion, SurrogateSolver};
