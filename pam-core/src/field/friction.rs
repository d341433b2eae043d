/// Set-valued dry friction in a field: one of its velocities sticks and slips.
///
/// The field has one more input than it is driven by, the direction σ of the motion, and the friction in it is a
/// function of σ in place of the sign of the velocity: `−c σ`, or `−(c σ + a |σ|)` for friction that is `c + a`
/// in one direction and `c − a` in the other. The solver sets σ = ±1 while the velocity `v` has that sign.
/// At `v = 0` it compares the accelerations `f_v(σ)` of both directions (Filippov 1988):
///
/// - `f_v(+1) ≤ 0 ≤ f_v(−1)`: friction can hold it. It sticks, with `v̇ = 0` exactly, and all other states move by the
///   convex combination of `f(+1)` and `f(−1)` that has this `v̇`;
/// - otherwise it slides in the direction in which it is accelerated.
///
/// No law of the friction need be known for that: it may depend on position, time or load. A field has one such
/// velocity at most.
///
/// ```
/// use pam_core::{DryFriction, ParametricField, Scalar, VectorField};
///
/// /// A sledge with dry friction: `v̇ = u − c σ`, with the force `u` per mass as input 0 and σ as input 1.
/// struct Sledge<S> {
///     friction: S,
/// }
///
/// impl<S: Scalar> VectorField<S> for Sledge<S> {
///     fn state_len(&self) -> usize {
///         2
///     }
///     fn input_len(&self) -> usize {
///         2
///     }
///     fn eval_into(&self, _t: f64, y: &[S], u: &[S], dy: &mut [S], _work: &mut [S]) {
///         dy[0] = y[1];
///         dy[1] = u[0] - self.friction * u[1];
///     }
/// }
///
/// impl ParametricField for Sledge<f64> {
///     type With<S: Scalar> = Sledge<S>;
///     fn parameters(&self) -> Vec<f64> {
///         vec![self.friction]
///     }
///     fn with_parameters<S: Scalar>(&self, p: &[S]) -> Sledge<S> {
///         Sledge { friction: p[0] }
///     }
///     fn dry_friction(&self) -> Option<DryFriction> {
///         Some(DryFriction { velocity: 1, direction: 1 })
///     }
/// }
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DryFriction {
    /// Index of the state that is the velocity.
    pub velocity: usize,
    /// Index of the input of the field that takes the direction: +1 or −1.
    pub direction: usize,
}
