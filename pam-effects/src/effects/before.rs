//! The measured history before a part of a recording, along which memory states and air are integrated.

/// The measured motion of a recording before a part of it, at equal distances, up to its first point.
#[derive(Debug, Clone, PartialEq)]
pub struct Before {
    /// Time from the start of the excitation to the first point, s.
    pub since_start_s: f64,
    /// Time between two points, s.
    pub step_s: f64,
    /// The points, at least two.
    pub points: Vec<MeasuredPoint>,
}

/// The measured channels at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredPoint {
    /// Displacement, mm.
    pub displacement_mm: f64,
    /// Velocity, mm/s.
    pub velocity_mm_s: f64,
    /// Pressures of flexor and extensor, kPa absolute.
    pub pressures_kpa: [f64; 2],
    /// Recorded force of the drive, mN.
    pub force_mn: f64,
}

impl Before {
    /// The points with the time from the start of the excitation to each, s.
    pub fn timed(&self) -> impl Iterator<Item = (f64, MeasuredPoint)> + '_ {
        let time_s = |k: usize| self.since_start_s + self.step_s * k as f64;
        self.points.iter().enumerate().map(move |(k, point)| (time_s(k), *point))
    }

    /// Displacement at the first point, mm.
    #[must_use]
    pub fn start_mm(&self) -> f64 {
        self.points[0].displacement_mm
    }
}
