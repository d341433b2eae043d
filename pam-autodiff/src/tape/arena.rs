//! Where a record lies.
//!
//! Everything recorded has a number, its node; node 0 stands for all constants. Nodes are numbered in
//! the order of recording. A scalar operation is an [`Operation`]; many variables at once, or a dense
//! layer, are one [`Block`] of consecutive nodes. Between two blocks all nodes are operations.

use super::affine::Affine;
use super::{Element, Var};
use std::sync::atomic::{AtomicU32, Ordering};

/// A scalar operation: its arguments' nodes and the derivatives with respect to them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Operation<T> {
    pub(super) arguments: [u32; 2],
    pub(super) partials: [T; 2],
}

/// Consecutive nodes that belong together.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block {
    /// The first node.
    pub(super) first: usize,
    /// Number of operations that were recorded before.
    pub(super) operations_before: usize,
    pub(super) kind: BlockKind,
}

#[derive(Debug, Clone, Copy)]
pub(super) enum BlockKind {
    /// This many variables.
    Variables(usize),
    Affine(Affine),
}

/// How much of each list is filled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Lengths {
    pub(super) values: usize,
    pub(super) operations: usize,
    pub(super) blocks: usize,
    gathered_nodes: usize,
    gathered_values: usize,
}

/// A record. `pub` for the sealed trait of elements; it cannot be named outside.
#[derive(Debug)]
pub struct Arena<T> {
    /// Which tape this is; 0 for none.
    id: u32,
    /// The value of each node; that of node 0 is not used.
    pub(super) values: Vec<T>,
    pub(super) operations: Vec<Operation<T>>,
    pub(super) blocks: Vec<Block>,
    /// Operands of blocks that do not lie side by side.
    pub(super) gathered_nodes: Vec<u32>,
    pub(super) gathered_values: Vec<T>,
}

/// A number for a tape. After four billion tapes they repeat, which weakens a check and nothing else.
fn next_id() -> u32 {
    static NEXT: AtomicU32 = AtomicU32::new(1);
    NEXT.fetch_add(1, Ordering::Relaxed).max(1)
}

impl<T> Arena<T> {
    /// The arena of a thread on which no tape records.
    pub(super) const fn idle() -> Self {
        Self {
            id: 0,
            values: Vec::new(),
            operations: Vec::new(),
            blocks: Vec::new(),
            gathered_nodes: Vec::new(),
            gathered_values: Vec::new(),
        }
    }
}

impl<T: Element> Arena<T> {
    pub(super) fn new() -> Self {
        Self { id: next_id(), values: vec![T::zero()], ..Self::idle() }
    }

    #[inline]
    pub(super) fn id(&self) -> u32 {
        self.id
    }

    /// Number of nodes but the first.
    pub(super) fn len(&self) -> usize {
        self.values.len().saturating_sub(1)
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.values[..])
            + size_of_val(&self.operations[..])
            + size_of_val(&self.blocks[..])
            + size_of_val(&self.gathered_nodes[..])
            + size_of_val(&self.gathered_values[..])
    }

    pub(super) fn lengths(&self) -> Lengths {
        Lengths {
            values: self.values.len(),
            operations: self.operations.len(),
            blocks: self.blocks.len(),
            gathered_nodes: self.gathered_nodes.len(),
            gathered_values: self.gathered_values.len(),
        }
    }

    pub(super) fn rewind(&mut self, to: Lengths) {
        let now = self.lengths();
        assert!(
            to.values <= now.values && to.operations <= now.operations && to.blocks <= now.blocks,
            "the tape is shorter than at the mark"
        );
        self.values.truncate(to.values);
        self.operations.truncate(to.operations);
        self.blocks.truncate(to.blocks);
        self.gathered_nodes.truncate(to.gathered_nodes);
        self.gathered_values.truncate(to.gathered_values);
    }

    /// Empties the record under a new number, so that old variables are noticed.
    pub(super) fn clear(&mut self) {
        self.id = next_id();
        self.values.truncate(1);
        self.operations.clear();
        self.blocks.clear();
        self.gathered_nodes.clear();
        self.gathered_values.clear();
    }

    /// Records one operation.
    #[inline]
    pub(super) fn push(&mut self, value: T, arguments: [u32; 2], partials: [T; 2]) -> Var<T> {
        let node = node(self.values.len());
        self.values.push(value);
        self.operations.push(Operation { arguments, partials });
        Var::at(value, node, self.id)
    }

    /// Begins a block at the next node.
    pub(super) fn push_block(&mut self, kind: BlockKind) {
        let (first, operations_before) = (self.values.len(), self.operations.len());
        self.blocks.push(Block { first, operations_before, kind });
    }

    pub(super) fn variables(&mut self, values: &[T], vars: &mut [Var<T>]) {
        assert_eq!(values.len(), vars.len(), "one variable for each value");
        let first = self.values.len();
        self.push_block(BlockKind::Variables(values.len()));
        self.values.extend_from_slice(values);
        let _fits = node(self.values.len());
        for (k, (var, &value)) in vars.iter_mut().zip(values).enumerate() {
            *var = Var::at(value, (first + k) as u32, self.id);
        }
    }
}

/// A node's number as it is stored.
#[inline]
pub(super) fn node(index: usize) -> u32 {
    u32::try_from(index).expect("a tape holds fewer than 2^32 results")
}
