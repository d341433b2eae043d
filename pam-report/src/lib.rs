//! Figures and self-contained HTML reports.
//!
//! - [`figure`]: line figures and coloured maps as SVG text, in one style: units on the axes,
//!   colours that colour-blind readers can distinguish (Okabe and Ito 2008; viridis);
//! - [`page`]: the frame of a report, one HTML file that needs nothing else;
//! - [`evaluation`]: the report of an evaluation;
//! - [`mod@force_curves`]: the restoring force over the displacement; [`parameters`]: the joint's own
//!   parameters and their known values;
//! - [`training`]: the report of a training run;
//! - [`gradient`]: the report of a loss and its gradient;
//! - [`inspection`]: the report of recordings that are checked before a fit;
//! - [`recordings`]: the report of recordings before any model;
//! - [`simulation`]: the report of a simulated trajectory.

pub mod evaluation;
pub mod figure;
pub mod force_curves;
pub mod gradient;
pub mod inspection;
pub mod page;
pub mod parameters;
pub mod recordings;
pub mod simulation;
pub mod training;

pub use evaluation::{EvaluationContext, evaluation_report};
pub use figure::{Band, ColourMap, LineFigure, Role, Scale, Series, Stroke, ValuePlane};
pub use force_curves::force_curves;
pub use gradient::{GradientBlock, GradientReport, gradient_report};
pub use inspection::{InspectedRun, inspection_report};
pub use parameters::parameter_table;
pub use recordings::{RecordedRun, recordings_report};
pub use simulation::simulation_report;
pub use training::{
    EpochRow, ParameterRow, StageRow, TrainingReport, effect_courses, training_report,
};
