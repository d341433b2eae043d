//! Figures and self-contained HTML reports.
//!
//! - [`figure`]: line figures and coloured maps as SVG text, in one style: units on the axes,
//!   colours that colour-blind readers can tell apart (Okabe and Ito 2008; viridis);
//! - [`page`]: the frame of a report, one HTML file that needs nothing else;
//! - [`evaluation`]: the report of an evaluation;
//! - [`gradient`]: the report of a loss and its gradient;
//! - [`recordings`]: the report of recordings before any model;
//! - [`simulation`]: the report of a simulated trajectory.

pub mod evaluation;
pub mod figure;
pub mod gradient;
pub mod page;
pub mod recordings;
pub mod simulation;

pub use evaluation::{EvaluationContext, evaluation_report};
pub use figure::{ColourMap, LineFigure, Role, Scale, Series};
pub use gradient::{GradientBlock, GradientReport, gradient_report};
pub use recordings::{RecordedRun, recordings_report};
pub use simulation::simulation_report;
