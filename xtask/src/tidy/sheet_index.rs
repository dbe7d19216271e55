//! Citable items of the specification sheets: sections, numbered rows and items of a section, and labelled rows.

use std::collections::{BTreeMap, BTreeSet};

use crate::tidy::source_tree::SourceTree;

/// Sheets under `docs/sheets/`, by name.
pub struct SheetIndex {
    by_name: BTreeMap<String, CitableSheet>,
}

/// Citable items of a sheet.
#[derive(Default)]
pub struct CitableSheet {
    /// Text of each section and its subsections, by number (`2.5`, `3`).
    sections: BTreeMap<String, String>,
    /// Labels at the beginning of a line, a row of a table or a passage in bold (`V-40`, `A-27`, `B2`).
    labels: BTreeSet<String>,
}

impl SheetIndex {
    /// Reads the sheets of `tree`.
    pub fn from_tree(tree: &SourceTree) -> Self {
        let mut by_name = BTreeMap::new();
        for page in tree.pages() {
            let name = page.path.strip_prefix("docs/sheets/").and_then(|name| name.strip_suffix(".md"));
            if let Some(name) = name.filter(|name| *name != "README") {
                by_name.insert(name.to_owned(), CitableSheet::from_text(&page.text));
            }
        }
        Self { by_name }
    }

    /// Sheet of a name.
    pub fn get(&self, name: &str) -> Option<&CitableSheet> {
        self.by_name.get(name)
    }

    /// Names of all sheets.
    pub fn names(&self) -> Vec<&str> {
        self.by_name.keys().map(String::as_str).collect()
    }
}

impl CitableSheet {
    /// Sections, rows and labels of the text of a sheet.
    fn from_text(text: &str) -> Self {
        let mut sheet = Self::default();
        let mut open: Vec<String> = Vec::new();
        for line in text.lines() {
            if let Some(number) = section_number(line) {
                open.retain(|above| number.starts_with(&format!("{above}.")));
                open.push(number);
            }
            for section in &open {
                let body = sheet.sections.entry(section.clone()).or_default();
                body.push_str(line);
                body.push('\n');
            }
            sheet.labels.extend(label(line.trim_start_matches(['|', '#', '-', '*', ' ', '>'])));
            sheet.labels.extend(line.split("**").skip(1).filter_map(label));
        }
        sheet
    }

    /// Whether there is a section of this number, or an item `b` of a section `a` for `a.b`.
    pub fn has_section(&self, number: &str) -> bool {
        self.sections.contains_key(number)
            || number.rsplit_once('.').is_some_and(|(section, item)| self.has_row(section, item))
    }

    /// Whether `section` has the numbered item or row `row`.
    pub fn has_row(&self, section: &str, row: &str) -> bool {
        self.sections.get(section).is_some_and(|body| {
            let starts =
                [format!("{row}. "), format!("| {row} |"), format!("* {row}. "), format!("- {row}. ")];
            body.lines().any(|line| starts.iter().any(|start| line.starts_with(start.as_str())))
        })
    }

    /// Whether `section` has a part with this letter: `(b)`, `b)`, or `**b` at its beginning.
    pub fn has_letter(&self, section: &str, letter: char) -> bool {
        self.sections.get(section).is_some_and(|body| {
            body.contains(&format!("({letter})")) || body.lines().any(|line| begins_with_letter(line, letter))
        })
    }

    /// Whether a row begins with `label`.
    pub fn has_label(&self, label: &str) -> bool {
        self.labels.contains(label)
    }

    /// Whether `section` mentions the set of this name.
    pub fn has_set(&self, section: &str, set: &str) -> bool {
        self.sections.get(section).is_some_and(|body| body.contains(&format!("Set {set}")))
    }
}

/// Whether an item of a list has a letter as its label.
fn begins_with_letter(line: &str, letter: char) -> bool {
    let line = line.trim_start_matches(['|', '*', '#', '-', ' ']);
    let mut characters = line.chars();
    characters.next() == Some(letter) && matches!(characters.next(), Some(')' | '.'))
}

/// Section number at the beginning of a heading.
fn section_number(line: &str) -> Option<String> {
    let heading = line.strip_prefix('#')?.trim_start_matches('#').trim_start();
    let number: String = heading.chars().take_while(|c| c.is_ascii_digit() || *c == '.').collect();
    let number = number.trim_end_matches('.');
    (!number.is_empty()).then(|| number.to_owned())
}

/// Label at the beginning of `text`: capitals, a dash or none, digits, a small letter or none.
pub fn label(text: &str) -> Option<String> {
    let capitals = text.chars().take_while(char::is_ascii_uppercase).count();
    if !(1..=3).contains(&capitals) {
        return None;
    }
    let rest = &text[capitals..];
    let dash = usize::from(rest.starts_with('-'));
    let digits = rest[dash..].chars().take_while(char::is_ascii_digit).count();
    if !(1..=3).contains(&digits) {
        return None;
    }
    let mut end = capitals + dash + digits;
    let mut after = text[end..].chars();
    let next = after.next();
    if next.is_some_and(|c| c.is_ascii_lowercase()) && !after.next().is_some_and(char::is_alphanumeric) {
        end += 1;
    } else if next.is_some_and(char::is_alphanumeric) {
        return None;
    }
    Some(text[..end].to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# Sheet\n## 2. Model\n### 2.5 Shapes\n(b) linear\n### 2.10 More\n## 4. List\n| 58 | row |\n\
                        ## 6. Pitfalls\n27. **Modes**\n**V-40 Slope** and **V-42 Cut**\n| B-01 | drum |\n### B6 Disk\n**Set S** of bars\n";

    #[test]
    fn sections_rows_letters_and_labels_are_found() {
        let sheet = CitableSheet::from_text(TEXT);
        for number in ["2", "2.5", "2.10", "6.27"] {
            assert!(sheet.has_section(number), "{number}");
        }
        assert!(!sheet.has_section("2.1") && !sheet.has_section("6.2"));
        assert!(sheet.has_row("4", "58") && !sheet.has_row("4", "5") && !sheet.has_row("2", "58"));
        assert!(sheet.has_letter("2.5", 'b') && !sheet.has_letter("2.10", 'b'));
        assert!(
            sheet.has_label("V-40")
                && sheet.has_label("V-42")
                && sheet.has_label("B-01")
                && sheet.has_label("B6")
        );
        assert!(!sheet.has_label("V-41") && sheet.has_set("6", "S"));
    }

    #[test]
    fn labels_of_sheets_are_parsed_to_their_end() {
        let found = |text| label(text).unwrap_or_default();
        assert_eq!(found("V-40: the slope"), "V-40");
        assert_eq!(found("V18b, more"), "V18b");
        assert_eq!(found("V-40's"), "V-40");
        assert_eq!(found("B-spline"), "");
        assert_eq!(found("MPM"), "");
        assert_eq!(found("H2O"), "");
    }
}
