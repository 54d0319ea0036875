//! What an experiment tells: tables, checks, plots. The same facts as text and as JSON.

use super::plot::Plot;
use direkt::low_level::stats::sidak::Family;
use direkt::low_level::stats::z_test::z_test;
use serde::{Serialize, Serializer};
use std::fmt::Write;

/// One entry of a table.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A number and how it is shown.
    Number(f64, String),
    /// There is none.
    Empty,
}

impl Cell {
    /// Words.
    pub fn text(text: impl Into<String>) -> Self {
        Self::Text(text.into())
    }

    /// A number with `decimals` digits after the point.
    pub fn fixed(value: f64, decimals: usize) -> Self {
        Self::Number(value, format!("{value:.decimals$}"))
    }

    /// A whole number with separators.
    pub fn count(value: f64) -> Self {
        Self::Number(value, grouped(value))
    }

    /// A number with `digits` significant digits, in powers of ten where it is small.
    pub fn short(value: f64, digits: usize) -> Self {
        Self::Number(value, short(value, digits))
    }

    /// The value and the half width of its interval.
    pub fn with_error(value: f64, half_width: f64, decimals: usize) -> Self {
        Self::Number(
            value,
            format!("{value:.decimals$} ± {half_width:.decimals$}"),
        )
    }

    /// A number shown as `text`.
    pub fn shown(value: f64, text: String) -> Self {
        Self::Number(value, text)
    }

    fn shows(&self) -> &str {
        match self {
            Self::Text(text) | Self::Number(_, text) => text,
            Self::Empty => "–",
        }
    }
}

impl Serialize for Cell {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Text(text) => serializer.serialize_str(text),
            Self::Number(value, _) => serializer.serialize_f64(*value),
            Self::Empty => serializer.serialize_none(),
        }
    }
}

/// `value` rounded to a whole number, with a comma every three digits.
pub fn grouped(value: f64) -> String {
    let digits = format!("{:.0}", value.abs());
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    if value < 0.0 {
        format!("−{out}")
    } else {
        out
    }
}

/// `value` with about `digits` significant digits.
pub fn short(value: f64, digits: usize) -> String {
    let magnitude = value.abs();
    if magnitude <= 0.0 {
        return "0".to_owned();
    }
    if !(1e-3..1e7).contains(&magnitude) {
        return format!("{value:.*e}", digits.saturating_sub(1));
    }
    let whole = magnitude.log10().floor() as i32 + 1;
    let decimals = (digits as i32 - whole).max(0) as usize;
    format!("{value:.decimals$}")
}

/// Rows under headings.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Table {
    /// What it shows.
    pub title: String,
    /// Headings.
    pub columns: Vec<String>,
    /// As many cells each as there are headings.
    pub rows: Vec<Vec<Cell>>,
}

impl Table {
    /// An empty table.
    pub fn new(title: impl Into<String>, columns: &[&str]) -> Self {
        Self {
            title: title.into(),
            columns: columns.iter().map(|&c| c.to_owned()).collect(),
            rows: Vec::new(),
        }
    }

    /// Adds a row.
    pub fn push(&mut self, row: Vec<Cell>) {
        assert_eq!(row.len(), self.columns.len(), "a row has a cell per column");
        self.rows.push(row);
    }

    /// The number in the row whose first cell is `row`, under `column`.
    pub fn number(&self, row: &str, column: &str) -> Option<f64> {
        let column = self.columns.iter().position(|c| c == column)?;
        let row = self.rows.iter().find(|r| r[0].shows() == row)?;
        match row[column] {
            Cell::Number(value, _) => Some(value),
            _ => None,
        }
    }

    fn write(&self, out: &mut String) {
        let width = |i: usize| {
            let cells = self.rows.iter().map(|row| row[i].shows());
            let all = cells.chain([self.columns[i].as_str()]);
            all.map(|s| s.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let line = |out: &mut String, cells: Vec<(&str, bool)>| {
            let mut text = String::from(" ");
            for ((cell, left), width) in cells.into_iter().zip(&widths) {
                let padding = " ".repeat(width - cell.chars().count());
                let (before, after) = if left {
                    ("", &*padding)
                } else {
                    (&*padding, "")
                };
                text += &format!(" {before}{cell}{after} ");
            }
            out.push_str(text.trim_end());
            out.push('\n');
        };
        // A column of words is set from the left.
        let left: Vec<bool> = (0..self.columns.len())
            .map(|i| self.rows.iter().all(|r| matches!(r[i], Cell::Text(_))))
            .collect();
        let _ = writeln!(out, "  {}", self.title);
        let headings = self.columns.iter().map(String::as_str);
        line(out, headings.zip(left.iter().copied()).collect());
        for row in &self.rows {
            let cells = row.iter().map(Cell::shows);
            line(out, cells.zip(left.iter().copied()).collect());
        }
    }
}

/// A measured value beside what it has to be.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// What was measured.
    pub name: String,
    /// The value found.
    pub measured: f64,
    /// The value that it has to be.
    pub expected: f64,
    /// Probability of a result at least as far off when all is right; 0 or 1 where no chance is
    /// involved.
    pub p_value: f64,
}

impl Check {
    /// A mean of known variance; `allowance` is what rounding may add.
    pub fn mean(
        name: impl Into<String>,
        measured: f64,
        expected: f64,
        variance_of_mean: f64,
        allowance: f64,
    ) -> Self {
        Self {
            name: name.into(),
            measured,
            expected,
            p_value: z_test(measured, expected, variance_of_mean, allowance).p_value,
        }
    }

    /// A variance estimated from `count` independent values of the given kurtosis (3 for normal
    /// ones), with the relative `allowance` of rounding. Cube roots of such estimates are closest
    /// to normal (Wilson & Hilferty 1931): with v = (kurtosis − 1)/count the root's mean is 1 − v/9
    /// and its variance v/9.
    pub fn variance(
        name: impl Into<String>,
        measured: f64,
        expected: f64,
        (kurtosis, count): (f64, f64),
        allowance: f64,
    ) -> Self {
        let p_value = if expected > 0.0 {
            let v = (kurtosis - 1.0).max(0.0) / count;
            let root = (measured / expected).cbrt();
            z_test(root, 1.0 - v / 9.0, v / 9.0, allowance / 3.0).p_value
        } else {
            z_test(measured, 0.0, 0.0, allowance).p_value
        };
        Self {
            name: name.into(),
            measured,
            expected,
            p_value,
        }
    }

    /// A value that is right up to rounding, without chance.
    pub fn exact(name: impl Into<String>, measured: f64, expected: f64, allowance: f64) -> Self {
        Self::mean(name, measured, expected, 0.0, allowance)
    }
}

/// An experiment's result.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// Its name on the command line.
    pub name: &'static str,
    /// What it is about.
    pub title: &'static str,
    /// The numbers.
    pub tables: Vec<Table>,
    /// What to read out of them.
    pub notes: Vec<String>,
    /// Everything that has to hold.
    pub checks: Vec<Check>,
    /// Pictures, as data.
    pub plots: Vec<Plot>,
}

impl Report {
    /// An empty one.
    pub fn new(name: &'static str, title: &'static str) -> Self {
        Self {
            name,
            title,
            tables: Vec::new(),
            notes: Vec::new(),
            checks: Vec::new(),
            plots: Vec::new(),
        }
    }

    /// The checks that fail, each at the level that the family of all of this experiment's checks
    /// gives it.
    pub fn failures(&self) -> Vec<&Check> {
        let family = Family::new(self.checks.len().max(1));
        let checks = self.checks.iter();
        checks.filter(|c| family.rejects(c.p_value)).collect()
    }

    /// Whether everything agrees with what it has to be.
    pub fn agrees(&self) -> bool {
        self.failures().is_empty()
    }

    /// For the terminal.
    pub fn text(&self) -> String {
        let mut out = format!("{}: {}\n\n", self.name, self.title);
        for table in &self.tables {
            table.write(&mut out);
            out.push('\n');
        }
        // Writing to a String cannot fail.
        for note in &self.notes {
            let _ = writeln!(out, "  · {note}");
        }
        let smallest = self.checks.iter().map(|c| c.p_value).fold(1.0, f64::min);
        let level = Family::new(self.checks.len().max(1)).test_level();
        let failures = self.failures();
        let _ = writeln!(
            out,
            "  {} of {} measured values agree with the exact ones (smallest p-value {smallest:.1e}, level of each {level:.1e})",
            self.checks.len() - failures.len(),
            self.checks.len(),
        );
        for check in failures {
            let _ = writeln!(
                out,
                "  DIFFERS: {}: {} measured, {} exact, p = {:.1e}",
                check.name,
                short(check.measured, 7),
                short(check.expected, 7),
                check.p_value
            );
        }
        out.push('\n');
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_for_readers() {
        assert_eq!(grouped(887_510.6), "887,511");
        assert_eq!(grouped(1.0), "1");
        assert_eq!(grouped(-1234.0), "−1,234");
        assert_eq!(short(0.0, 3), "0");
        assert_eq!(short(56.800_678, 4), "56.80");
        assert_eq!(short(0.000_012_34, 3), "1.23e-5");
    }

    #[test]
    fn tables_are_aligned_and_can_be_asked() {
        let mut table = Table::new("t", &["name", "n"]);
        table.push(vec![Cell::text("π"), Cell::fixed(3.25, 2)]);
        table.push(vec![Cell::text("long"), Cell::count(12_345.0)]);
        let mut out = String::new();
        table.write(&mut out);
        assert_eq!(out, "  t\n  name       n\n  π       3.25\n  long  12,345\n");
        assert_eq!(table.number("π", "n"), Some(3.25));
        assert_eq!(table.number("π", "m"), None);
    }

    #[test]
    fn one_wrong_value_is_enough() {
        let mut report = Report::new("x", "y");
        report
            .checks
            .push(Check::mean("right", 1.0, 1.01, 1e-4, 0.0));
        assert!(report.agrees());
        report.checks.push(Check::exact("wrong", 1.02, 1.0, 1e-3));
        assert!(!report.agrees());
        assert!(report.text().contains("DIFFERS: wrong: 1.020000 measured"));
    }

    #[test]
    fn variances_are_checked_on_both_sides() {
        let p = |measured| Check::variance("", measured, 2.0, (3.0, 100_000.0), 0.0).p_value;
        assert!(p(2.0) > 0.9 && p(2.01) > 0.1);
        assert!(p(2.1) < 1e-6 && p(1.9) < 1e-6);
        assert!(Check::variance("", 0.1, 0.0, (3.0, 9.0), 0.0).p_value <= 0.0);
    }
}
