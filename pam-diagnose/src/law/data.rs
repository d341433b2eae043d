//! The data from which a law is learned, and those to which it is fitted.

use crate::fit::Member;
use crate::remainder::Ground;
use crate::terms::TermSpace;

/// All data, and those of them from which corrections are learned and laws chosen.
#[derive(Clone, Copy)]
pub(crate) struct Data<'a> {
    /// All recordings.
    pub(crate) whole: (&'a dyn TermSpace, &'a Ground<'a>),
    /// Pieces of them, or all.
    pub(crate) chosen: (&'a dyn TermSpace, &'a Ground<'a>),
    /// Whether those are all.
    pub(crate) is_whole: bool,
    /// Whether all are few enough to learn from, where an error is slow and no piece shows it.
    pub(crate) is_short: bool,
}

impl<'a> Data<'a> {
    /// All data, from which everything is learned.
    pub(crate) fn whole(space: &'a dyn TermSpace, ground: &'a Ground<'a>) -> Self {
        Self { whole: (space, ground), chosen: (space, ground), is_whole: true, is_short: true }
    }

    /// Causes with the times that they have in all recordings.
    pub(crate) fn in_whole(&self, members: &[Member]) -> Vec<Member> {
        timed_as_in(self.whole.1, members)
    }

    /// Causes with the times that they have in the chosen data.
    pub(super) fn in_chosen(&self, members: &[Member]) -> Vec<Member> {
        timed_as_in(self.chosen.1, members)
    }
}

/// Causes with the schedules of those of a ground; what it does not know stays.
fn timed_as_in(ground: &Ground<'_>, members: &[Member]) -> Vec<Member> {
    let known = |m: &Member| {
        ground.named.iter().chain(&ground.rivals).find(|own| own.candidate == m.candidate)
    };
    let with = |m: &Member| Member {
        schedule: known(m).map_or_else(|| m.schedule.clone(), |own| own.schedule.clone()),
        ..m.clone()
    };
    members.iter().map(with).collect()
}
