//! Difference schemes for a first derivative, one file each.
//!
//! | scheme | error | evaluations | where it is weak |
//! |---|---|---|---|
//! | [`Forward`] | O(h) | 2 | half of all digits at best |
//! | [`Central`] | O(h²) | 2 | two thirds of all digits at best |
//! | [`FourPointSmoothed`] | O(h²) | 4 | meant to average over kinks, not to be exact |
//! | [`Richardson`] | O(h²ᴸ), with an estimate | 2 L | needs a smooth `f` over ±h |
//! | [`ComplexDifference`] | O(h²), h = 1e-40 | 1 | needs a generic, real analytic `f` |
//!
//! Those that need only values of `f` are [`DifferenceScheme`]s and can be chosen
//! [by name](from_name). The complex step needs `f` at a complex number, so it stands beside them.

mod central;
mod complex_step;
mod forward;
mod four_point_smoothed;
mod gradient;
mod richardson;

pub use central::Central;
pub use complex_step::ComplexDifference;
pub use forward::Forward;
pub use four_point_smoothed::FourPointSmoothed;
pub use gradient::{gradient_by_difference, scaled_gradient_by_difference};
pub use richardson::{Estimate, Richardson};

use pam_core::ModelError;

/// A scheme that estimates `f'(x)` from values of `f`.
pub trait DifferenceScheme {
    /// Name for tables and plots.
    fn name(&self) -> &'static str;

    /// The estimate of `f'(x)`.
    fn derivative(&self, f: &mut dyn FnMut(f64) -> f64, x: f64) -> f64;
}

macro_rules! schemes {
    ($($name:literal => $type:ident),+ $(,)?) => {
        /// Names of all schemes that [`from_name`] knows.
        pub const NAMES: &[&str] = &[$($name),+];

        /// The scheme of this name with its default step, which is meant for arguments of size one.
        ///
        /// ```
        /// use pam_autodiff::finite_difference::{NAMES, from_name};
        /// for name in NAMES {
        ///     let estimate = from_name(name)?.derivative(&mut |x| x * x, 3.0);
        ///     assert!((estimate - 6.0).abs() < 1e-6, "{name}");
        /// }
        /// # Ok::<(), pam_core::ModelError>(())
        /// ```
        ///
        /// # Errors
        /// [`ModelError::UnknownName`] with the names that exist.
        pub fn from_name(name: &str) -> Result<Box<dyn DifferenceScheme>, ModelError> {
            match name {
                $($name => Ok(Box::new($type::default())),)+
                _ => Err(ModelError::UnknownName {
                    kind: "difference scheme",
                    name: name.to_owned(),
                    known: NAMES.join(", "),
                }),
            }
        }
    };
}

schemes! {
    "forward" => Forward,
    "central" => Central,
    "four_point_smoothed" => FourPointSmoothed,
    "richardson" => Richardson,
}
