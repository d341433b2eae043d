use super::colour_bar::colour;
use super::style::tick_label;
use maud::{Markup, html};

/// Values of named rows and columns as a table of coloured cells, each with its names and value as tooltip.
///
/// ```
/// use pam_report::figure::HeatTable;
///
/// let table = HeatTable {
///     corner: "hidden".into(),
///     rows: vec!["leak".into()],
///     columns: vec!["creep".into(), "leak".into()],
///     values: vec![vec![Some(0.25), None]],
///     limits: (0.0, 1.0),
/// };
/// let html = table.to_html().into_string();
/// assert!(html.contains("leak, creep: 0.25") && html.matches("<td").count() == 2);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct HeatTable {
    /// What the rows are.
    pub corner: String,
    /// Names of the rows.
    pub rows: Vec<String>,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Values, row by row; cells without one are empty.
    pub values: Vec<Vec<Option<f64>>>,
    /// Values at the ends of the colour scale; values outside take the end's colour.
    pub limits: (f64, f64),
}

impl HeatTable {
    /// The table as HTML, with the colours at the ends of the scale below it.
    #[must_use]
    pub fn to_html(&self) -> Markup {
        let (low, high) = self.limits;
        let cell = |row: &str, column: &str, value: Option<f64>| {
            let Some(value) = value.filter(|v| v.is_finite()) else {
                return html! { td {} };
            };
            let style = format!(
                "background:{};width:1.1em;height:1.1em;padding:0",
                colour(value, self.limits)
            );
            let number = tick_label(value, 0.1 * (high - low));
            html! { td style=(style) title=(format!("{row}, {column}: {number}")) {} }
        };
        let end = |value: f64| {
            html! {
                span style=(format!("display:inline-block;width:1em;height:1em;background:{}", colour(value, self.limits))) {}
                " " (tick_label(value, high - low))
            }
        };
        html! {
            div style="overflow-x:auto" {
                table style="border-collapse:separate;border-spacing:1px;width:auto" {
                    thead {
                        tr {
                            th style="text-align:right" { (self.corner) }
                            @for column in &self.columns {
                                th style="writing-mode:vertical-rl;transform:rotate(180deg);text-align:left;font-weight:normal;padding:2px 0" { (column) }
                            }
                        }
                    }
                    tbody {
                        @for (row, values) in self.rows.iter().zip(&self.values) {
                            tr {
                                th style="text-align:right;font-weight:normal;white-space:nowrap;padding:0 6px" { (row) }
                                @for (column, value) in self.columns.iter().zip(values) { (cell(row, column, *value)) }
                            }
                        }
                    }
                }
            }
            p { (end(low)) " – " (end(high)) }
        }
    }
}
