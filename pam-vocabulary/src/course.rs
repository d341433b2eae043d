//! When an effect acts: from a time on, up to a time, growing over a time.

use crate::ParameterInfo;

/// The times that an effect may have besides its own parameters.
///
/// Its share `g(t)` of the whole effect rises from 0 to 1 about `onset_s` and falls to 0 about `end_s`. Both are the times at
/// which half of it is there. The rise takes `ramp_s`, or [`LEAST_RAMP_S`] where that is not given; the end takes
/// [`LEAST_RAMP_S`]. All are counted from the beginning of the excitation, the first sample of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, PartialOrd, Ord)]
pub struct ActivityWindow {
    /// Whether it begins at `onset_s`; otherwise it is there from the start.
    pub onset: bool,
    /// Whether the beginning takes `ramp_s`.
    pub ramp: bool,
    /// Whether it ends at `end_s`.
    pub end: bool,
}

/// Time in which an effect comes or goes where no other is given, s: short beside any motion of the joint, and five steps of
/// its simulation, so that derivatives by the times are those of a smooth function.
pub const LEAST_RAMP_S: f64 = 0.02;

/// Latest time, s.
const LATEST_S: f64 = 1e6;

/// The time at which half of an effect is there, s.
pub const ONSET: ParameterInfo = ParameterInfo::linear("onset_s", [0.0, LATEST_S])
    .off_at(None)
    .meaning("time at which half of it is there, since the first sample");
/// The time in which it grows, s.
pub const RAMP: ParameterInfo = ParameterInfo::scale("ramp_s", [LEAST_RAMP_S, LATEST_S])
    .meaning("time in which it grows, half of it before the onset");
/// The time at which half of it is gone, s.
pub const END: ParameterInfo = ParameterInfo::linear("end_s", [0.0, LATEST_S])
    .off_at(None)
    .meaning("time at which half of it is gone, since the first sample");

/// All times.
pub const ALL: [ParameterInfo; 3] = [ONSET, RAMP, END];

impl ActivityWindow {
    /// Always there.
    pub const ALWAYS: Self = Self { onset: false, ramp: false, end: false };
    /// From a time on.
    pub const BEGINS: Self = Self { onset: true, ..Self::ALWAYS };
    /// Up to a time.
    pub const ENDS: Self = Self { end: true, ..Self::ALWAYS };
    /// From a time to another.
    pub const PASSES: Self = Self { end: true, ..Self::BEGINS };
    /// Growing about a time.
    pub const GROWS: Self = Self { ramp: true, ..Self::BEGINS };

    /// The times in their order: onset, ramp, end.
    pub fn parameters(self) -> impl Iterator<Item = ParameterInfo> {
        let all = [(self.onset, ONSET), (self.ramp, RAMP), (self.end, END)];
        all.into_iter().filter_map(|(has, info)| has.then_some(info))
    }

    /// Number of the times.
    #[must_use]
    pub fn time_len(self) -> usize {
        self.parameters().count()
    }

    /// The course with these times among its names; other names are left alone. `None` for a ramp without an onset.
    #[must_use]
    pub fn of_names<'n>(names: impl IntoIterator<Item = &'n str>) -> Option<Self> {
        let mut course = Self::ALWAYS;
        for name in names {
            course.onset |= name == ONSET.name;
            course.ramp |= name == RAMP.name;
            course.end |= name == END.name;
        }
        (course.onset || !course.ramp).then_some(course)
    }

    /// Whether a name is that of a time.
    #[must_use]
    pub fn is_time(name: &str) -> bool {
        ALL.iter().any(|p| p.name == name)
    }
}
