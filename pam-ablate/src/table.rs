//! The results of a sweep as a table: one row per cell.
//!
//! Columns: `cell`, one for each axis, `seed`, `status` (`done`, `failed`, `missing`), one for each
//! metric, `error`. CSV and, with the feature `parquet`, Parquet hold the same; with equal configurations, seeds and data they are the
//! same bytes every time. Times are in a table of their own.

use crate::folder::{CellRecord, Planned, Quantity, Status};
use crate::sweep::Sweep;

/// The values of a column; `None` where there is none.
#[derive(Debug, Clone, PartialEq)]
pub enum Column {
    /// Text.
    Text(Vec<Option<String>>),
    /// Whole numbers.
    Integer(Vec<i64>),
    /// Numbers.
    Number(Vec<Option<f64>>),
}

/// A table: columns of equal length with their names.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// The columns.
    pub columns: Vec<(String, Column)>,
}

impl Table {
    /// The results of cells: their metrics, or their times.
    #[must_use]
    pub fn of(
        sweep: &Sweep,
        planned: &[Planned],
        records: &[Option<CellRecord>],
        of: Quantity,
    ) -> Self {
        let text =
            |f: &dyn Fn(usize) -> Option<String>| Column::Text((0..planned.len()).map(f).collect());
        let mut columns = vec![("cell".to_owned(), text(&|i| Some(planned[i].id.clone())))];
        for (a, axis) in sweep.axes.iter().enumerate() {
            let choice = |i: usize| &planned[i].cell.choices[a];
            let numbers: Option<Vec<Option<f64>>> =
                (0..planned.len()).map(|i| choice(i).number.map(Some)).collect();
            let column =
                numbers.map_or_else(|| text(&|i| Some(choice(i).label.clone())), Column::Number);
            columns.push((axis.name.clone(), column));
        }
        let seeds = planned.iter().map(|p| p.cell.seed as i64).collect();
        columns.push(("seed".into(), Column::Integer(seeds)));
        let status = |i: usize| {
            let text = match records[i].as_ref().map(|r| r.status) {
                None => "missing",
                Some(Status::Done) => "done",
                Some(Status::Failed) => "failed",
            };
            Some(text.to_owned())
        };
        columns.push(("status".into(), text(&status)));
        for name in CellRecord::names(records, of) {
            let value = |r: &Option<CellRecord>| r.as_ref()?.value(of, &name);
            let values = records.iter().map(value).collect();
            columns.push((name.clone(), Column::Number(values)));
        }
        if of == Quantity::Metrics {
            let error = |i: usize| records[i].as_ref().and_then(|r| r.error.clone());
            columns.push(("error".into(), text(&error)));
        }
        Self { columns }
    }

    /// The column of a name.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|(n, _)| n == name).map(|(_, c)| c)
    }

    fn len(&self) -> usize {
        self.columns.first().map_or(0, |(_, c)| match c {
            Column::Text(v) => v.len(),
            Column::Integer(v) => v.len(),
            Column::Number(v) => v.len(),
        })
    }

    /// The table as CSV (RFC 4180); numbers have the fewest digits that distinguish them.
    ///
    /// # Panics
    /// Never: writing into memory cannot fail.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let written = "writing into memory cannot fail";
        writer.write_record(self.columns.iter().map(|(name, _)| name)).expect(written);
        for row in 0..self.len() {
            let cell = |(_, column): &(String, Column)| match column {
                Column::Text(v) => v[row].clone().unwrap_or_default(),
                Column::Integer(v) => v[row].to_string(),
                Column::Number(v) => v[row].map_or_else(String::new, |v| v.to_string()),
            };
            writer.write_record(self.columns.iter().map(cell)).expect(written);
        }
        String::from_utf8(writer.into_inner().expect(written)).expect("the text is UTF-8")
    }
}
