//! Air masses for a motion and a stiffness: the global optimum, with a certificate.
//!
//! At a fixed displacement and velocity the force is piecewise affine in the two masses. The masses that give
//! a wanted force form a curve of straight segments, one in each linear region that it crosses. Along a
//! segment the stiffness estimate
//!
//! ```text
//! K̂ = [f(x + 2h) + f(x + h) − f(x − h) − f(x − 2h)] / (6h)
//! ```
//!
//! (the least-squares slope over five points) is piecewise affine too: it bends where one of its four forces
//! does. Its minimum, its maximum and the values nearest to a target lie at the bends or where K̂ equals the
//! target, so a finite list of points holds the optimum.
//!
//! **Certificate.** All linear regions of the mass plane are found from neighbour to neighbour, and their areas
//! are summed. If they fill the bounds, no piece of the curve was missed, closed loops included, and the
//! optimum is global to rounding.
//!
//! | file | holds |
//! |---|---|
//! | `problem` | request, solution and certificate |
//! | `along_segment` | a network's force along a straight segment of the mass plane |
//! | `solver` | the search |

mod along_segment;
mod problem;
mod solver;

pub use problem::{Certificate, InverseProblem, InverseSolution};
pub use solver::InverseSolver;
