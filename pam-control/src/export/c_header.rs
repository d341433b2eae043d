use super::{row, step_s};
use crate::synthesis::Plan;
use pam_embedded::table::COLUMNS;
use std::fmt::Write;

/// A plan as a C header: the table as a constant array of `float`, and a function that reads it along
/// straight lines. C99, no library.
#[must_use]
pub fn c_header(plan: &Plan) -> String {
    let rows = plan.targets.len();
    let mut text = format!(
        "/* Commands of a plan, made by pam. One row every PAM_TABLE_STEP_S seconds. */\n\
         #ifndef PAM_TABLE_H\n#define PAM_TABLE_H\n\n\
         #define PAM_TABLE_ROWS {rows}\n\
         #define PAM_TABLE_COLUMNS {}\n\
         #define PAM_TABLE_STEP_S {:?}f\n\n",
        COLUMNS.len(),
        step_s(plan) as f32
    );
    for (index, name) in COLUMNS.iter().enumerate() {
        let _ = writeln!(text, "#define PAM_{} {index}", name.to_ascii_uppercase());
    }
    text += "\nstatic const float pam_table[PAM_TABLE_ROWS][PAM_TABLE_COLUMNS] = {\n";
    for sample in 0..rows {
        let cells: Vec<String> =
            row(plan, sample).iter().map(|v| format!("{:?}f", *v as f32)).collect();
        let _ = writeln!(text, "    {{{}}},", cells.join(", "));
    }
    text += "};\n\n\
        /* A column at a time in seconds; the first and the last row hold outside. */\n\
        static inline float pam_table_at(int column, float time_s) {\n\
        \x20   float place = time_s / PAM_TABLE_STEP_S;\n\
        \x20   int row;\n\
        \x20   if (!(place > 0.0f)) return pam_table[0][column];\n\
        \x20   if (place >= PAM_TABLE_ROWS - 1) return pam_table[PAM_TABLE_ROWS - 1][column];\n\
        \x20   row = (int)place;\n\
        \x20   return pam_table[row][column]\n\
        \x20       + (place - row) * (pam_table[row + 1][column] - pam_table[row][column]);\n\
        }\n\n#endif\n";
    text
}
