//! The published operating conditions.

/// The 29 training conditions (psi gauge, flexor and extensor) in the order of the published
/// curriculum (Wang and Realmuto 2026, table II).
pub const TRAINING_PSI: [[u8; 2]; 29] = [
    [10, 10],
    [45, 45],
    [80, 80],
    [40, 50],
    [50, 40],
    [30, 60],
    [60, 30],
    [20, 70],
    [70, 20],
    [10, 80],
    [80, 10],
    [45, 30],
    [45, 60],
    [30, 45],
    [60, 45],
    [45, 20],
    [45, 70],
    [20, 45],
    [70, 45],
    [45, 10],
    [45, 80],
    [10, 45],
    [80, 45],
    [20, 20],
    [30, 30],
    [40, 40],
    [50, 50],
    [60, 60],
    [70, 70],
];

/// The name of a recording at sealed pressures, `nn_FFEE`.
#[must_use]
pub fn name_of([flexor, extensor]: [u8; 2]) -> String {
    format!("nn_{flexor:02}{extensor:02}")
}

/// Names of the recordings at the training conditions.
#[must_use]
pub fn training_names() -> Vec<String> {
    TRAINING_PSI.map(name_of).to_vec()
}
