/// States and stages that the forward solve stores for the reverse sweep. All choices give the same gradient, bit for
/// bit: steps that are not stored are taken again with the same arithmetic.
///
/// With `n` states, `s` stages and `N` steps:
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Checkpointing {
    /// State and stages of every step: `N (s + 1) n` numbers, nothing is computed twice. For a joint of
    /// four states this is 224 bytes a step with Tsit5, and the right choice.
    #[default]
    AllSave,
    /// State and first derivative at every `m`-th step: `2 n N / m + m (s + 1) n` numbers, every step is
    /// taken twice. `m ≈ √N` needs the least memory.
    Interval(usize),
    /// At most this many snapshots (state and first derivative) at a time, at least one, placed so that
    /// the number of repeated steps is the smallest possible.
    ///
    /// Source: A. Griewank and A. Walther, *Algorithm 799: Revolve*, ACM Transactions on Mathematical
    /// Software 26 (2000) 19–45. The number of steps is known before the first snapshot is placed,
    /// because the accepted grid is: one solve with error control, then one along the grid.
    Binomial {
        /// The largest number of snapshots.
        snapshots: usize,
    },
}

impl Checkpointing {
    /// Name for tables and figures.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::AllSave => "all-save".into(),
            Self::Interval(m) => format!("interval {m}"),
            Self::Binomial { snapshots } => format!("binomial {snapshots}"),
        }
    }

    /// Says what is wrong with a choice that cannot work.
    pub(super) fn check(self) -> Result<(), String> {
        match self {
            Self::Interval(0) | Self::Binomial { snapshots: 0 } => {
                Err(format!("checkpointing \"{}\" stores nothing", self.name()))
            }
            _ => Ok(()),
        }
    }
}
