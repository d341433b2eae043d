//! From experiments to training, validation and test data.
//!
//! [`Roles`] decides which experiments, or parts of them, have which role. A [`Split`] holds the training rows, to which
//! candidates are fitted, and the validation rows, by which names are chosen; afterwards the chosen names are refitted to
//! both. The test rows are in a [`TestSet`](crate::test_set::TestSet), which no decision sees.

mod roles;
mod split;

pub(crate) use roles::range;
pub use roles::{OpenPart, Roles, Span, TestData, TestSource, ValidationData};
pub use split::Split;
