use super::{row, step_s};
use crate::synthesis::Plan;
use pam_embedded::table::{COLUMNS, MAGIC, VERSION};

/// A plan as the bytes of a [`pam_embedded::Table`].
#[must_use]
pub fn table_bytes(plan: &Plan) -> Vec<u8> {
    let rows = plan.targets.len();
    let mut bytes = Vec::with_capacity(24 + rows * COLUMNS.len() * 4);
    bytes.extend_from_slice(MAGIC);
    for number in [VERSION, rows as u32, COLUMNS.len() as u32] {
        bytes.extend_from_slice(&number.to_le_bytes());
    }
    bytes.extend_from_slice(&step_s(plan).to_le_bytes());
    for sample in 0..rows {
        for value in row(plan, sample) {
            bytes.extend_from_slice(&(value as f32).to_le_bytes());
        }
    }
    bytes
}
