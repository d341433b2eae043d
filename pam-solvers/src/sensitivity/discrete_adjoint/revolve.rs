//! Where the next snapshot goes.

/// `β(s, r) = (s + r)! / (s! r!)`, the most steps that `s` snapshots reverse when no step is repeated
/// more than `r` times; saturates far beyond any number of steps.
fn reach(snapshots: usize, repeats: usize) -> usize {
    let mut product: u128 = 1;
    for i in 1..=snapshots.min(repeats) as u128 {
        product = product * (snapshots.max(repeats) as u128 + i) / i;
        if product > usize::MAX as u128 {
            return usize::MAX;
        }
    }
    product as usize
}

/// The number of steps to advance before the next snapshot is taken, when `steps ≥ 2` are to be
/// reversed and `snapshots ≥ 2` may be held, that at the start included.
///
/// The total of repeated steps is then the least possible, `r N − β(s + 1, r − 1)` with the smallest `r`
/// for which `β(s, r) ≥ N` (Griewank and Walther, proposition 1; the choice among the equally good
/// advances is that of their code).
pub(super) fn advance(steps: usize, snapshots: usize) -> usize {
    let s = snapshots;
    let mut repeats = 1;
    while reach(s, repeats) < steps {
        repeats += 1;
    }
    // Parts of β(s, r): what is left after one, two snapshots, one repeat less.
    let whole = reach(s, repeats);
    let later = reach(s, repeats - 1);
    let fewer = reach(s - 1, repeats - 1);
    let fewest = if s >= 2 { reach(s - 2, repeats - 1) } else { 0 };
    let shortest = if repeats >= 2 { reach(s, repeats - 2) } else { 0 };
    let spare = if s >= 3 { reach(s - 3, repeats) } else { 0 };
    let next = if steps <= later.saturating_add(fewest) {
        shortest
    } else if steps >= whole - spare {
        later
    } else {
        steps - fewer - fewest
    };
    next.clamp(1, steps - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps taken again under the schedule, besides the one that fills the stages of each step.
    fn scheduled(steps: usize, snapshots: usize) -> usize {
        if steps <= 1 {
            0
        } else if snapshots == 1 {
            steps * (steps - 1) / 2
        } else {
            let mid = advance(steps, snapshots);
            mid + scheduled(steps - mid, snapshots - 1) + scheduled(mid, snapshots)
        }
    }

    /// The schedule reaches the minimum over all schedules, found by dynamic programming.
    #[test]
    fn no_schedule_repeats_fewer_steps() {
        let (longest, most) = (80, 9);
        let mut best = vec![vec![0_usize; longest + 1]; most + 1];
        for s in 1..=most {
            for n in 2..=longest {
                best[s][n] = if s == 1 {
                    n * (n - 1) / 2
                } else {
                    (1..n).map(|m| m + best[s - 1][n - m] + best[s][m]).min().unwrap()
                };
                assert_eq!(scheduled(n, s), best[s][n], "{n} steps, {s} snapshots");
            }
        }
    }

    #[test]
    fn the_reach_is_binomial() {
        assert_eq!(reach(3, 2), 10);
        assert_eq!(reach(5, 0), 1);
        assert_eq!(reach(1, 7), 8);
        assert_eq!(reach(400, 400), usize::MAX);
    }
}
