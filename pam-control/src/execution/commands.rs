use crate::synthesis::Plan;

/// A table of pressure commands and their targets, one row per sample.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Commands {
    /// Time between rows, s.
    pub step_s: f64,
    /// Wanted displacement, mm.
    pub displacement_mm: Vec<f64>,
    /// Wanted stiffness, N/mm.
    pub stiffness_n_mm: Vec<f64>,
    /// Pressures of flexor and extensor, kPa absolute.
    pub pressures_kpa: Vec<[f64; 2]>,
}

impl From<&Plan> for Commands {
    fn from(plan: &Plan) -> Self {
        let step_s = match plan.targets[..] {
            [first, second, ..] => second.time_s - first.time_s,
            _ => super::SAMPLE_S,
        };
        Self {
            step_s,
            displacement_mm: plan.targets.iter().map(|t| t.displacement_mm).collect(),
            stiffness_n_mm: plan.targets.iter().map(|t| t.stiffness_n_mm).collect(),
            pressures_kpa: plan.pressures_kpa.clone(),
        }
    }
}

impl Commands {
    /// Time from the first to the last row, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.pressures_kpa.len().saturating_sub(1) as f64 * self.step_s
    }

    fn place(&self, time_s: f64) -> (usize, f64) {
        let last = self.pressures_kpa.len() - 1;
        let place = (time_s / self.step_s).clamp(0.0, last as f64);
        let row = (place as usize).min(last.saturating_sub(1));
        (row, place - row as f64)
    }

    /// A column at a time, along straight lines; the ends hold.
    fn read(&self, time_s: f64, value: impl Fn(usize) -> f64) -> f64 {
        let (row, share) = self.place(time_s);
        let here = value(row);
        if share == 0.0 { here } else { here + share * (value(row + 1) - here) }
    }

    /// Wanted displacement at a time, mm.
    #[must_use]
    pub fn displacement_mm(&self, time_s: f64) -> f64 {
        self.read(time_s, |row| self.displacement_mm[row])
    }

    /// Wanted stiffness at a time, N/mm: that of the row before.
    #[must_use]
    pub fn stiffness_n_mm(&self, time_s: f64) -> f64 {
        let last = self.stiffness_n_mm.len() - 1;
        self.stiffness_n_mm[((time_s / self.step_s + 1e-6).max(0.0) as usize).min(last)]
    }

    /// Pressures at a time, kPa absolute.
    #[must_use]
    pub fn pressures_kpa(&self, time_s: f64) -> [f64; 2] {
        [0, 1].map(|i| self.read(time_s, |row| self.pressures_kpa[row][i]))
    }
}
