use crate::grid::Grid;
use crate::tableau::{InterpolantTable, Tableau};

/// All accepted steps of one trajectory, for its adjoint and its dense output.
#[derive(Debug, Clone, Default)]
pub struct StoredTrajectory<K = ()> {
    state_len: usize,
    stages: usize,
    pub(super) grid: Grid,
    /// States at step ends, one more than steps.
    states: Vec<f64>,
    /// Stage derivatives of each step, the FSAL stage last.
    k: Vec<f64>,
    /// For each step, `true` if its FSAL stage was evaluated.
    pub(super) has_fsal: Vec<bool>,
    /// Numbers that the evaluations left for their linearisation, `[points, kept_len]` in the order of the
    /// adjoint's points; empty if they exceed the memory for them.
    pub(super) kept: Vec<K>,
    pub(super) keeps: bool,
    /// Rejected steps.
    pub rejected: usize,
    /// Evaluations of the field that this trajectory needed. (It takes part in a few more where other
    /// members of its batch need one.)
    pub evaluations: usize,
}

impl<K: Copy> StoredTrajectory<K> {
    /// Empties the trajectory and starts it anew; keeps its memory.
    pub(super) fn restart(&mut self, stages: usize, t0: f64, y0: &[f64], keeps: bool) {
        self.state_len = y0.len();
        self.stages = stages;
        self.grid.restart(t0);
        self.states.clear();
        self.k.clear();
        self.has_fsal.clear();
        self.kept.clear();
        self.keeps = keeps;
        self.rejected = 0;
        self.evaluations = 0;
        self.states.extend_from_slice(y0);
    }

    /// Adds a step; `k` are its stage derivatives.
    pub(super) fn push<'k>(
        &mut self,
        t_new: f64,
        y_new: &[f64],
        k: impl Iterator<Item = &'k [f64]>,
        restarts: bool,
        has_fsal: bool,
    ) {
        self.grid.push(t_new, restarts);
        self.states.extend_from_slice(y_new);
        for k in k {
            self.k.extend_from_slice(k);
        }
        self.has_fsal.push(has_fsal);
    }

    /// Keeps what one evaluation of the last step left, as long as all of it is within `limit` bytes.
    pub(super) fn keep(&mut self, kept: &[K], limit: usize) {
        if !self.keeps {
            return;
        }
        if (self.kept.len() + kept.len()) * size_of::<K>() > limit {
            self.kept = Vec::new();
            self.keeps = false;
        } else {
            self.kept.extend_from_slice(kept);
        }
    }

    /// Number of steps.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.grid.steps()
    }

    /// Step ends from the start on, s.
    #[must_use]
    pub fn times_s(&self) -> &[f64] {
        self.grid.times_s()
    }

    /// The state at step end `index`; 0 is the start.
    #[must_use]
    pub fn state(&self, index: usize) -> &[f64] {
        &self.states[index * self.state_len..(index + 1) * self.state_len]
    }

    /// The stage derivatives of a step, one after the other, the FSAL stage last.
    pub(super) fn derivatives(&self, step: usize) -> &[f64] {
        let width = self.stages * self.state_len;
        &self.k[step * width..(step + 1) * width]
    }

    /// Bytes that the steps take.
    #[must_use]
    pub fn bytes(&self) -> usize {
        8 * (self.times_s().len() + self.states.len() + self.k.len())
            + 2 * self.steps()
            + size_of_val(&self.kept[..])
    }

    /// Writes the states at `times_s` (increasing) to `out`, `[times, states]`. Times past the end of a
    /// trajectory that stopped early are left as they are; the number of written times is returned.
    /// `tableau` is the method of the solve.
    pub fn observe(&self, tableau: &Tableau, times_s: &[f64], out: &mut [f64]) -> usize {
        // The number of states as a constant keeps the few numbers of a state in registers.
        match self.state_len {
            1 => self.observe_states::<1>(tableau, times_s, out),
            2 => self.observe_states::<2>(tableau, times_s, out),
            3 => self.observe_states::<3>(tableau, times_s, out),
            4 => self.observe_states::<4>(tableau, times_s, out),
            _ => self.observe_states::<0>(tableau, times_s, out),
        }
    }

    /// [`observe`](Self::observe) for `N` states, or any number if `N` is zero.
    fn observe_states<const N: usize>(
        &self,
        tableau: &Tableau,
        times_s: &[f64],
        out: &mut [f64],
    ) -> usize {
        let n = if N == 0 { self.state_len } else { N };
        let (ends, steps) = (self.grid.times_s(), self.steps());
        let mut step = 0;
        let table = InterpolantTable::new(tableau);
        let mut weights = vec![0.0; table.len()];
        for (i, (&t, out)) in times_s.iter().zip(out.chunks_exact_mut(n)).enumerate() {
            while step < steps && ends[step + 1] < t {
                step += 1;
            }
            if t == ends[step] {
                out.copy_from_slice(&self.states[step * n..(step + 1) * n]);
                continue;
            }
            if step == steps {
                return i;
            }
            if t == ends[step + 1] {
                out.copy_from_slice(&self.states[(step + 1) * n..(step + 2) * n]);
                continue;
            }
            let (start, h) = (ends[step], ends[step + 1] - ends[step]);
            table.weights_into((t - start) / h, h, &mut weights);
            out.copy_from_slice(&self.states[step * n..(step + 1) * n]);
            let width = self.stages * n;
            let k = &self.k[step * width..(step + 1) * width];
            for (k, &w) in k.chunks_exact(n).zip(&weights) {
                for (o, &k) in out.iter_mut().zip(k) {
                    *o += w * k;
                }
            }
        }
        times_s.len()
    }
}
