use crate::execution::Pulse;

/// Pulses at peak, centre and trough of a sine `sin(2π t / period)`, in each of `cycles` cycles of every
/// one of `levels` levels. Within a level the direction changes from cycle to cycle; in every other pair of
/// cycles the centre is that of the way down.
#[must_use]
pub fn cycling_pulses(period_s: f64, levels: usize, cycles: usize) -> Vec<Pulse> {
    (0..levels * cycles)
        .flat_map(|cycle| {
            let within = cycle % cycles.max(1);
            let direction = if within.is_multiple_of(2) { 1.0 } else { -1.0 };
            // The way up passes the centre at the end of a cycle, the way down in its middle.
            let centre = if (within / 2).is_multiple_of(2) { 0.98 } else { 0.5 };
            let mut places = [(0.25_f64, "peak"), (centre, "centre"), (0.75, "trough")];
            places.sort_by(|a, b| a.0.total_cmp(&b.0));
            places.map(|(phase, place)| Pulse {
                time_s: (cycle as f64 + phase) * period_s,
                direction,
                place,
            })
        })
        .collect()
}

/// Pulses in both directions on each of `steps` levels that are held for `hold_s`: `pairs` pairs, evenly
/// spread over the second half of a level.
#[must_use]
pub fn staircase_pulses(steps: usize, hold_s: f64, pairs: usize) -> Vec<Pulse> {
    (0..steps)
        .flat_map(|step| {
            (0..2 * pairs).map(move |k| Pulse {
                time_s: hold_s * (step as f64 + 0.5 + 0.5 * k as f64 / (2 * pairs) as f64),
                direction: if k % 2 == 0 { 1.0 } else { -1.0 },
                place: "rest",
            })
        })
        .collect()
}
