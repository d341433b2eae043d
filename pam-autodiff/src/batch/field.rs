//! What a batched vector field is.

/// Sums of parameter cotangents.
#[derive(Debug)]
pub struct ParameterSums<'a> {
    /// Of the parameters that all trajectories share.
    pub shared: &'a mut [f64],
    /// Of the condition's own.
    pub own: &'a mut [f64],
}

/// A vector field for many points at once, with its derivatives.
///
/// Trajectories share the field's parameters (weights, mass) and differ in a *condition* with
/// parameters of its own (sealed masses). Two kinds of work are batched:
///
/// - **lanes**: one point from each of many trajectories, for the forward solve;
/// - **blocks**: many points along one trajectory, for the adjoint. Once a solve is done all its stage
///   states are known, so Jacobians can be taken for a whole block of steps at once; the recursion
///   through time then handles small matrices only, and the parameter cotangents are summed for the
///   block at once again. This pays where the state is small and the field has few outputs that are
///   dear, as with a network of one force.
///
/// States and inputs lie point after point.
pub trait BatchField: Sync {
    /// What distinguishes one trajectory from another.
    type Condition: Sync;
    /// Memory for lanes, with the condition of each.
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

    /// Memory for `capacity` lanes.
    fn batch(&self, capacity: usize) -> Self::Batch;

    /// Puts a condition into a lane.
    fn set_condition(&self, lane: usize, condition: &Self::Condition, lanes: &mut Self::Batch);

    /// Moves the condition of lane `from` to lane `to`.
    fn move_condition(&self, from: usize, to: usize, lanes: &mut Self::Batch);

    /// Writes the derivative of the first `t.len()` lanes to `dy` and, unless `kept` is empty, what
    /// [`linearise`](Self::linearise) can use, `[lanes, kept_len]`. A lane's result does not depend on
    /// the others'.
    fn eval_batch(
        &self,
        t: &[f64],
        y: &[f64],
        u: &[f64],
        dy: &mut [f64],
        kept: &mut [Self::Kept],
        lanes: &mut Self::Batch,
    );

    /// Memory for blocks of up to `capacity` points.
    fn block(&self, capacity: usize) -> Self::Block;

    /// Writes ∂f/∂y of `t.len()` points, `[points, states, states]` row by row, and leaves in `block`
    /// what [`accumulate`](Self::accumulate) needs. `kept` is what the forward evaluation left of these
    /// points, or empty.
    #[allow(clippy::too_many_arguments)]
    fn linearise(
        &self,
        condition: &Self::Condition,
        t: &[f64],
        y: &[f64],
        u: &[f64],
        kept: &[Self::Kept],
        jacobians: &mut [f64],
        block: &mut Self::Block,
    );

    /// Adds `Σ_points (∂f/∂p)ᵀ w`, for cotangents `w` `[points, states]`; to be called once after
    /// [`linearise`](Self::linearise) with the same points and `kept`. The sums may stay in `block` until
    /// [`drain`](Self::drain).
    #[allow(clippy::too_many_arguments)]
    fn accumulate(
        &self,
        condition: &Self::Condition,
        t: &[f64],
        y: &[f64],
        u: &[f64],
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
