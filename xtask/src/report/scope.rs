//! Scope of a report: the benchmarks that it covers.

use std::path::PathBuf;

/// Scope of a report: the benchmarks that it covers.
pub struct ReportScope {
    /// Names that were requested; all benchmarks without them.
    pub filter: Option<String>,
    /// Whether short forms were requested.
    pub quick: bool,
    /// Number of benchmarks in their short form.
    pub short_count: usize,
    /// Number of benchmarks in their full form.
    pub full_count: usize,
    /// Names of benchmarks that are left out: they have no short form, or their full form takes minutes.
    pub skipped_benchmarks: Vec<&'static str>,
}

impl ReportScope {
    /// Folder of the report. A partial report never replaces a complete one.
    pub fn folder(&self) -> PathBuf {
        let folder = crate::root().join("target/validation");
        let Some(filter) = &self.filter else { return folder };
        let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
        let name: String = filter.chars().map(plain).collect();
        folder.join("filtered").join(if self.quick { format!("{name}.quick") } else { name })
    }

    /// Text on the benchmarks of the report and their forms.
    pub fn text(&self) -> String {
        let (run, left) = (self.short_count + self.full_count, self.skipped_benchmarks.len());
        let mut words = match left {
            0 => format!("{run} benchmarks"),
            _ => format!("{run} of {} benchmarks", run + left),
        };
        if let Some(filter) = &self.filter {
            words += &format!(" for “{filter}”");
        }
        words += &match (self.full_count, self.short_count) {
            (_, 0) => ", in full".to_owned(),
            (0, _) => ", in their short form".to_owned(),
            (full, short) => format!(", {full} in full, {short} in their short form"),
        };
        if left > 0 {
            words += &format!("; {left} left out (--long runs them)");
        }
        words
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_report_header_counts_benchmarks_in_full_and_short_form() {
        let scope = |filter: Option<&str>, full_count, short_count, left_out: &[&'static str]| {
            let filter = filter.map(str::to_owned);
            ReportScope {
                filter,
                quick: false,
                short_count,
                full_count,
                skipped_benchmarks: left_out.to_vec(),
            }
            .text()
        };
        assert_eq!(scope(None, 3, 0, &[]), "3 benchmarks, in full");
        assert_eq!(
            scope(None, 36, 14, &["a", "b"]),
            "50 of 52 benchmarks, 36 in full, 14 in their short form; 2 left out (--long runs them)"
        );
        assert_eq!(scope(Some("bar"), 0, 2, &[]), "2 benchmarks for “bar”, in their short form");
    }
}
