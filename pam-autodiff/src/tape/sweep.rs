//! The two sweeps over a record.

use super::affine::{Affine, Operand};
use super::arena::{Arena, BlockKind, Lengths, Operation};
use super::{Element, Var, kernels};

/// Derivatives of everything on a tape after a sweep: adjoints after a
/// [reverse](super::Tape::reverse) one, tangents after a [forward](super::Tape::forward) one.
#[derive(Debug, Clone, Copy)]
pub struct Derivatives<'a, T: Element> {
    tape: u32,
    by_node: &'a [T],
}

impl<'a, T: Element> Derivatives<'a, T> {
    pub(super) fn new(tape: u32, by_node: &'a [T]) -> Self {
        Self { tape, by_node }
    }

    /// The derivative that belongs to `var`; zero for a constant.
    ///
    /// # Panics
    /// If `var` belongs to another tape.
    #[must_use]
    pub fn of(&self, var: Var<T>) -> T {
        var.node_on(self.tape).map_or(T::zero(), |node| self.by_node[node])
    }

    /// Adds the derivatives of `vars` to `sums`.
    ///
    /// # Panics
    /// If the lengths differ or a variable belongs to another tape.
    pub fn add_to(&self, vars: &[Var<T>], sums: &mut [T]) {
        assert_eq!(vars.len(), sums.len(), "one sum for each variable");
        for (sum, &var) in sums.iter_mut().zip(vars) {
            *sum += self.of(var);
        }
    }

    /// Adds the derivatives of variables that were made side by side, `first` and those after it.
    pub(crate) fn add_range_to(&self, first: Option<Var<T>>, sums: &mut [T]) {
        if let Some(first) = first.and_then(|var| var.node_on(self.tape)) {
            for (sum, &d) in sums.iter_mut().zip(&self.by_node[first..]) {
                *sum += d;
            }
        }
    }
}

/// Spreads adjoints from results to what they were made of, through what was recorded after `since`.
pub(super) fn reverse<T: Element>(
    arena: &Arena<T>,
    since: Lengths,
    adjoints: &mut [T],
    scratch: &mut Vec<T>,
) {
    let (mut nodes_end, mut operations_end) = (arena.values.len(), arena.operations.len());
    for block in arena.blocks[since.blocks..].iter().rev() {
        let run = &arena.operations[block.operations_before..operations_end];
        reverse_run(run, nodes_end - run.len(), adjoints);
        if let BlockKind::Affine(layer) = &block.kind {
            layer.reverse(arena, block.first, adjoints, scratch);
        }
        (nodes_end, operations_end) = (block.first, block.operations_before);
    }
    let run = &arena.operations[since.operations..operations_end];
    reverse_run(run, nodes_end - run.len(), adjoints);
}

/// Operations whose nodes begin at `first`.
fn reverse_run<T: Element>(run: &[Operation<T>], first: usize, adjoints: &mut [T]) {
    let results = first..first + run.len();
    for (operation, node) in run.iter().zip(results).rev() {
        let adjoint = adjoints[node];
        // Infinite partials of what the seeds do not depend on must not make NaN of zero.
        if adjoint.vanishes() {
            continue;
        }
        let [a, b] = operation.arguments;
        adjoints[a as usize] += adjoint * operation.partials[0];
        adjoints[b as usize] += adjoint * operation.partials[1];
    }
}

/// Carries tangents from variables to what was made of them.
pub(super) fn forward<T: Element>(arena: &Arena<T>, tangents: &mut [T], scratch: &mut Vec<T>) {
    let (mut node, mut done) = (1, 0);
    for block in &arena.blocks {
        let run = &arena.operations[done..block.operations_before];
        forward_run(run, node, tangents);
        done = block.operations_before;
        node = block.first;
        match &block.kind {
            BlockKind::Variables(len) => node += len,
            BlockKind::Affine(layer) => {
                layer.forward(arena, block.first, tangents, scratch);
                node += layer.outputs;
            }
        }
    }
    forward_run(&arena.operations[done..], node, tangents);
}

fn forward_run<T: Element>(run: &[Operation<T>], first: usize, tangents: &mut [T]) {
    for (operation, node) in run.iter().zip(first..) {
        let [a, b] = operation.arguments.map(|argument| tangents[argument as usize]);
        let [along_a, along_b] = operation.partials;
        let mut tangent = T::zero();
        if !a.vanishes() {
            tangent += a * along_a;
        }
        if !b.vanishes() {
            tangent += b * along_b;
        }
        tangents[node] = tangent;
    }
}

impl Affine {
    /// `b̄ += ȳ`, `x̄ += Wᵀ ȳ`, `W̄ += ȳ xᵀ`.
    fn reverse<T: Element>(
        &self,
        arena: &Arena<T>,
        first: usize,
        adjoints: &mut [T],
        scratch: &mut Vec<T>,
    ) {
        let (earlier, results) = adjoints.split_at_mut(first);
        let adjoint = &results[..self.outputs];
        if adjoint.iter().all(T::vanishes) {
            return;
        }
        let weights = arena.values_of(self.weights, self.inputs * self.outputs);
        let input = arena.values_of(self.input, self.inputs);
        let mut add = |operand, len, kernel: &dyn Fn(&mut [T])| {
            add_through(arena, operand, len, earlier, scratch, kernel);
        };
        add(self.bias, self.outputs, &|out| {
            for (o, &a) in out.iter_mut().zip(adjoint) {
                *o += a;
            }
        });
        add(self.input, self.inputs, &|out| kernels::add_dots(out, weights, adjoint));
        add(self.weights, weights.len(), &|out| kernels::add_outer(out, input, adjoint));
    }

    /// `ẏ = ḃ + W ẋ + Ẇ x`.
    fn forward<T: Element>(
        &self,
        arena: &Arena<T>,
        first: usize,
        tangents: &mut [T],
        scratch: &mut Vec<T>,
    ) {
        let (earlier, results) = tangents.split_at_mut(first);
        let tangent = &mut results[..self.outputs];
        let weights = arena.values_of(self.weights, self.inputs * self.outputs);
        let input = arena.values_of(self.input, self.inputs);
        let mut look = |operand, len, kernel: &mut dyn FnMut(&[T])| match operand {
            Operand::Range(first) => kernel(&earlier[first..first + len]),
            Operand::Gathered { nodes, .. } => {
                let nodes = &arena.gathered_nodes[nodes..nodes + len];
                scratch.clear();
                scratch.extend(nodes.iter().map(|&node| earlier[node as usize]));
                kernel(scratch);
            }
            Operand::Constant { .. } => {}
        };
        tangent.fill(T::zero());
        look(self.bias, self.outputs, &mut |change| tangent.copy_from_slice(change));
        look(self.input, self.inputs, &mut |change| kernels::add_columns(tangent, change, weights));
        look(self.weights, weights.len(), &mut |change| {
            kernels::add_columns(tangent, input, change);
        });
    }
}

/// Lets `kernel` add to the adjoints of an operand: in place if they lie side by side, else through
/// scratch memory.
fn add_through<T: Element>(
    arena: &Arena<T>,
    operand: Operand,
    len: usize,
    adjoints: &mut [T],
    scratch: &mut Vec<T>,
    kernel: &dyn Fn(&mut [T]),
) {
    match operand {
        Operand::Range(first) => kernel(&mut adjoints[first..first + len]),
        Operand::Gathered { nodes, .. } => {
            scratch.clear();
            scratch.resize(len, T::zero());
            kernel(scratch);
            for (&node, &part) in arena.gathered_nodes[nodes..nodes + len].iter().zip(&*scratch) {
                adjoints[node as usize] += part;
            }
        }
        Operand::Constant { .. } => {}
    }
}
