//! Plans and models in the forms that controllers read.
//!
//! | file | for |
//! |---|---|
//! | `table.csv` | people, spreadsheets, `pam track --table` |
//! | `table.bin` | [`pam_embedded::Table`] |
//! | `table.h` | C |
//! | `network.bin` | [`pam_embedded::Network`] |

mod binary;
mod c_header;
mod csv;
mod network;

pub use binary::table_bytes;
pub use c_header::c_header;
pub use csv::table_csv;
pub use network::{Precision, network_bytes};

use crate::synthesis::Plan;

/// The numbers of a row, in the order of [`pam_embedded::table::COLUMNS`].
#[must_use]
pub fn row(plan: &Plan, sample: usize) -> [f64; 8] {
    let (target, solution) = (&plan.targets[sample], &plan.solutions[sample]);
    let [flexor_kpa, extensor_kpa] = plan.pressures_kpa[sample];
    [
        target.displacement_mm,
        target.velocity_mm_s,
        target.stiffness_n_mm,
        solution.stiffness_n_mm,
        solution.masses.flexor_g,
        solution.masses.extensor_g,
        flexor_kpa,
        extensor_kpa,
    ]
}

/// Time between rows, s.
fn step_s(plan: &Plan) -> f64 {
    match plan.targets[..] {
        [first, .., last] => (last.time_s - first.time_s) / (plan.targets.len() - 1) as f64,
        _ => 1.0,
    }
}
