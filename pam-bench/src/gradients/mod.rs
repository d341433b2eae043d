//! Gradient methods, compared.
//!
//! Every method on every problem at every tolerance, horizon and activation: its error against the
//! gradient of the steps taken and against the truth, its time, its memory and its counts. Further parts
//! look at one question each: [`parts`] lists them. A cell that fails is a row that says why.
//!
//! ```
//! use pam_bench::gradients::{Grid, Kind, Method, Solver, Study, methods, problems};
//! use pam_autodiff::ByTape;
//! use pam_solvers::{NoInput, Tableau};
//! use pam_solvers::sensitivity::DiscreteAdjoint;
//!
//! // A problem is a field, an input, a start, when it is observed, and a loss: see `Case::new`.
//! let case = problems::van_der_pol::case(2.0);
//! // A method is a name and how it is built for a solver; here one is added to the list of all.
//! let mut all = methods();
//! all.push(Method::new("mine", "tape", Kind::Exact, |_solver| Box::new(DiscreteAdjoint::new(ByTape))));
//! let study = Study::new().with(Grid {
//!     part: "mine".into(),
//!     case,
//!     methods: all,
//!     solvers: vec![Solver::adaptive(Tableau::tsit5(), 1e-6)],
//! });
//! let study = study.with_methods(&["adjoint".into(), "mine".into()])?;
//! let result = study.run(|progress| eprintln!("{} of {}", progress.done, progress.total));
//! assert_eq!(result.rows.len(), 3); // the adjoint by tape and by dual numbers, and mine
//! assert!(result.rows.iter().all(|row| row.replay_error.unwrap() < 1e-10));
//! # Ok::<(), pam_core::ModelError>(())
//! ```

pub mod batched;
pub mod case;
pub mod cells;
pub mod conditions;
pub mod figures;
pub mod findings;
pub mod kinked;
pub mod measure;
pub mod method;
pub mod output;
pub mod parts;
pub mod problems;
pub mod report;
pub mod result;
pub mod solver;
pub mod study;
pub mod table;
pub mod truth;

pub use batched::BatchGrid;
pub use case::Case;
pub use cells::{Cells, Grid};
pub use conditions::ConditionGrid;
pub use method::{Kind, Method, all as methods, of_joint as joint_methods};
pub use problems::Problem;
pub use result::{Row, StudyResult};
pub use solver::{Solver, Steps};
pub use study::{Progress, Study};
