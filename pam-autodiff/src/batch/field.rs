//! Batched vector fields.

use crate::field::At;

/// Sums of parameter cotangents.
#[derive(Debug)]
pub struct ParameterSums<'a> {
    /// Of the parameters that all trajectories share.
    pub shared: &'a mut [f64],
    /// Of the condition's own.
    pub own: &'a mut [f64],
}

/// Times (s), states and inputs at which a batched field is evaluated, point after point.
#[derive(Debug, Clone, Copy)]
pub struct Points<'a> {
    /// Times, s.
    pub t: &'a [f64],
    /// States, `[points, states]`.
    pub y: &'a [f64],
    /// Inputs, `[points, inputs]`.
    pub u: &'a [f64],
}

impl<'a> Points<'a> {
    /// The points one by one, of a field with `n` states and `m` inputs.
    pub(super) fn each(self, n: usize, m: usize) -> impl Iterator<Item = At<'a>> {
        self.t.iter().enumerate().map(move |(i, &t)| At {
            t,
            y: &self.y[i * n..(i + 1) * n],
            u: &self.u[i * m..(i + 1) * m],
        })
    }
}

/// A vector field for many points at once, with its derivatives.
///
/// Trajectories share the field's parameters (weights, mass) and differ in a *condition* with
/// parameters of its own (sealed masses). Two kinds of work are batched:
///
/// - **batches**: one point from each of many trajectories, for the forward solve;
/// - **blocks**: many points along one trajectory, for the adjoint. Once a solve is done all its stage
///   states are known, so the Jacobians of a whole block of steps are taken at once; the recursion
///   through time handles small matrices only, and the parameter cotangents of the block are summed at
///   once. This pays where the state is small and the field has few outputs that are expensive, such as
///   one force from a network.
pub trait BatchField: Sync {
    /// The parameters of one trajectory that the others do not share.
    type Condition: Sync;
    /// Memory for a batch, with the condition of each of its members.
    type Batch: Send;
    /// Memory for a block.
    type Block: Send;
    /// A number that the forward evaluation of a point can leave for its linearisation.
    type Kept: Copy + Default + Send + Sync;

    /// Number of states.
    fn state_len(&self) -> usize;

    /// Number of inputs.
    fn input_len(&self) -> usize;

    /// Number of parameters that all trajectories share.
    fn parameter_len(&self) -> usize;

    /// Number of parameters of one condition.
    fn condition_len(&self) -> usize;

    /// How many numbers the forward evaluation of a point can leave for its linearisation.
    fn kept_len(&self) -> usize;

    /// Memory for a batch of up to `capacity` members.
    fn batch(&self, capacity: usize) -> Self::Batch;

    /// Sets the condition of a member.
    fn set_condition(&self, member: usize, condition: &Self::Condition, batch: &mut Self::Batch);

    /// Moves the condition of member `from` to member `to`.
    fn move_condition(&self, from: usize, to: usize, batch: &mut Self::Batch);

    /// Writes the derivatives of the first members, one point each, to `dy` and, unless `kept` is empty,
    /// what [`linearise`](Self::linearise) can use, `[points, kept_len]`. The result of a member does not
    /// depend on the others.
    fn eval_batch(
        &self,
        points: Points<'_>,
        dy: &mut [f64],
        kept: &mut [Self::Kept],
        batch: &mut Self::Batch,
    );

    /// Memory for blocks of up to `capacity` points.
    fn block(&self, capacity: usize) -> Self::Block;

    /// Writes ∂f/∂y of the points, `[points, states, states]` row by row, and leaves in `block`
    /// what [`accumulate`](Self::accumulate) needs. `kept` is what the forward evaluation left of these
    /// points, or empty.
    fn linearise(
        &self,
        condition: &Self::Condition,
        points: Points<'_>,
        kept: &[Self::Kept],
        jacobians: &mut [f64],
        block: &mut Self::Block,
    );

    /// Adds `Σ_points (∂f/∂p)ᵀ w`, for cotangents `w` `[points, states]`; to be called once after
    /// [`linearise`](Self::linearise) with the same points and `kept`. The sums may stay in `block` until
    /// [`drain`](Self::drain).
    fn accumulate(
        &self,
        condition: &Self::Condition,
        points: Points<'_>,
        kept: &[Self::Kept],
        w: &[f64],
        sums: &mut ParameterSums<'_>,
        block: &mut Self::Block,
    );

    /// Moves the sums that are still in `block` to `sums`; to be called at the end of a trajectory.
    fn drain(
        &self,
        condition: &Self::Condition,
        sums: &mut ParameterSums<'_>,
        block: &mut Self::Block,
    );
}
