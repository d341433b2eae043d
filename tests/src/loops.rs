//! Loops of force over displacement in the columns of a CSV file.

/// What is compared between the real run and the rigs, cycle by cycle.
#[derive(Debug, Clone, Copy, Default)]
pub struct Loop {
    /// Smallest and largest displacement, mm.
    pub displacement_mm: [f64; 2],
    /// Displacement where the force passes zero upwards and downwards, mm.
    pub rest_mm: [f64; 2],
    /// Work of the force in a cycle, mJ.
    pub area_mj: f64,
    /// Range of the flexor's and the extensor's pressure, kPa.
    pub pressure_range_kpa: [f64; 2],
    /// Share of time below 0.3 mm/s.
    pub slow_share: f64,
}

/// Columns of a CSV file below its header lines.
///
/// # Panics
/// If a cell is no number.
#[must_use]
pub fn columns(csv: &str) -> Vec<Vec<f64>> {
    let rows: Vec<Vec<f64>> = csv
        .lines()
        .filter(|l| !l.starts_with('#'))
        .skip(1)
        .map(|l| l.split(',').map(|c| c.parse().expect("a number")).collect())
        .collect();
    (0..rows[0].len()).map(|c| rows.iter().map(|r| r[c]).collect()).collect()
}

/// The mean loop between upward zero crossings of the force that are at least `shortest_s` apart, from `from_s` to `to_s`.
///
/// # Panics
/// If there is no whole cycle.
#[must_use]
pub fn mean_loop(columns: &[Vec<f64>], from_s: f64, to_s: f64, shortest_s: f64) -> Loop {
    let [t, x, v, pf, pe, f] = columns else { panic!("six columns") };
    let within = |i: &usize| (from_s..=to_s).contains(&t[*i]);
    let mut starts: Vec<usize> = Vec::new();
    for i in (1..t.len()).filter(within) {
        if f[i - 1] < 0.0 && f[i] >= 0.0 && starts.last().is_none_or(|s| t[i] - t[*s] > shortest_s)
        {
            starts.push(i);
        }
    }
    let cycles = starts.len() - 1;
    assert!(cycles > 0, "a whole cycle");
    let mut sum = Loop::default();
    let range = |values: &[f64]| {
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        [low, values.iter().copied().fold(f64::NEG_INFINITY, f64::max)]
    };
    let share = 1.0 / cycles as f64;
    for pair in starts.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let middle = (a + (b - a) / 4..b).find(|i| f[i - 1] > 0.0 && f[*i] <= 0.0).unwrap_or(a);
        let [low, high] = range(&x[a..b]);
        sum.displacement_mm[0] += share * low;
        sum.displacement_mm[1] += share * high;
        sum.rest_mm[0] += share * x[a];
        sum.rest_mm[1] += share * x[middle];
        sum.area_mj +=
            share * (a..b).map(|i| 0.5 * (f[i] + f[i + 1]) * (x[i + 1] - x[i])).sum::<f64>();
        for (place, p) in sum.pressure_range_kpa.iter_mut().zip([pf, pe]) {
            let [low, high] = range(&p[a..b]);
            *place += share * (high - low);
        }
        let slow = v[a..b].iter().filter(|v| v.abs() < 0.3).count();
        sum.slow_share += share * slow as f64 / (b - a) as f64;
    }
    sum
}
