//! Citations of the specification sheets: `sheet: mpm §3.3`, `sheet: sph V-40`, and the other forms that `docs/sheets/README.md` lists.

use crate::tidy::RuleViolation;
use crate::tidy::sheet_index::{CitableSheet, SheetIndex, label};
use crate::tidy::source_tree::{SourceFile, SourceTree};

/// Name of the rule.
const RULE_NAME: &str = "citation of a sheet";

/// Violations of the rules of citations: missing sheets, sections and rows, labels that belong to no sheet, and files that mention “the
/// sheet” and cite none.
pub fn citations(tree: &SourceTree, sheets: &SheetIndex) -> Vec<RuleViolation> {
    let mut findings = Vec::new();
    for file in &tree.files {
        // Pages made from the sheets quote them.
        let quotes = file.path == crate::coverage::PAGE_FILE;
        if quotes || file.path.starts_with("docs/sheets/") || file.path.starts_with("xtask/src/tidy/") {
            continue;
        }
        check(file, sheets, &mut findings);
    }
    findings
}

/// Reports citations of a file that no sheet has.
fn check(file: &SourceFile, sheets: &SheetIndex, findings: &mut Vec<RuleViolation>) {
    let text = without_margins(&file.text);
    let mut cited: Vec<&str> = folder_sheets(&file.path).to_vec();
    for start in citation_starts(&text) {
        let line = text[..start].matches('\n').count() + 1;
        let mut citation =
            CitationParser { remaining_text: &text[start..], line, file: &file.path, findings };
        cited.extend(citation.read(sheets));
    }
    if let Some(line) = outdated_form(&text) {
        findings.push(RuleViolation::new(
            RULE_NAME,
            &file.path,
            line,
            "cite a sheet as `sheet: <name> §3.3`".to_owned(),
        ));
    }
    for (line, label) in unprefixed_labels(&text) {
        if !cited.iter().any(|name| sheets.get(name).is_some_and(|sheet| sheet.has_label(label))) {
            let message = format!("{label} is in no sheet that this file cites");
            findings.push(RuleViolation::new(RULE_NAME, &file.path, line, message));
        }
    }
    if cited.is_empty()
        && let Some(at) = text.find("the sheet")
    {
        let line = text[..at].matches('\n').count() + 1;
        findings.push(RuleViolation::new(
            RULE_NAME,
            &file.path,
            line,
            "mentions a sheet without citing it".to_owned(),
        ));
    }
}

/// Sheets on the subject of the files in a folder.
fn folder_sheets(path: &str) -> &'static [&'static str] {
    let folders: Vec<_> = path.split('/').collect();
    let name = match folders[..] {
        ["validation", "open-defects.json"] => return &["mpm", "sph", "dem", "depth-sph", "snow-mpm"],
        ["crates" | "validation", name, ..] | ["xtask", _, "benchmarks", name, ..] => name,
        ["docs", "theory", page] => page.trim_end_matches(".md"),
        _ => return &[],
    };
    match name {
        "constitutive" | "umat" | "element" => &["constitutive"],
        "grid" | "mpm" => &["mpm"],
        "sph" => &["sph"],
        "dem" => &["dem"],
        "depth-sph" | "depth_sph" => &["depth-sph"],
        "snow-mpm" | "snow_mpm" => &["snow-mpm"],
        _ => &[],
    }
}

/// Text without the comment signs at the beginnings of lines, so that a citation may continue on the next line.
fn without_margins(text: &str) -> String {
    let margin = |line: &str| line.trim_start().trim_start_matches(['/', '!', '#', '\\']).to_owned();
    text.lines().map(margin).collect::<Vec<_>>().join("\n")
}

/// Byte positions behind `sheet: `.
fn citation_starts(text: &str) -> impl Iterator<Item = usize> {
    text.match_indices("sheet: ").filter_map(|(at, found)| {
        let before = text[..at].chars().next_back();
        (!before.is_some_and(|c| c.is_alphanumeric() || c == '_')).then_some(at + found.len())
    })
}

/// Line of a citation in the form “sheet: mpm §2.5” or “Sheet V-01”.
fn outdated_form(text: &str) -> Option<usize> {
    let found = text.match_indices("heet ").find(|(at, found)| {
        let rest = &text[at + found.len()..];
        rest.starts_with('§') || label(rest).is_some()
    });
    found.map(|(at, _)| text[..at].matches('\n').count() + 1)
}

/// Labels of rows in the form of the sheets of soils, `V-40`, with their lines.
fn unprefixed_labels(text: &str) -> Vec<(usize, &str)> {
    let mut labels = Vec::new();
    for (number, line) in text.lines().enumerate() {
        for (at, _) in line.match_indices('-') {
            let Some(first) = at.checked_sub(1).filter(|first| line.is_char_boundary(*first)) else {
                continue;
            };
            let before = line[..first].chars().next_back();
            let alone = !before.is_some_and(|c| c.is_alphanumeric() || c == '-' || c == '_');
            let digits = line[at + 1..].chars().take_while(char::is_ascii_digit).count();
            let after = line[at + 1..].chars().nth(digits);
            let ends = !after.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == '-');
            if alone && digits == 2 && ends && ["V", "A", "B", "P", "S"].contains(&&line[first..at]) {
                labels.push((number + 1, &line[first..at + 3]));
            }
        }
    }
    labels
}

/// Parser of the text after `sheet: `.
struct CitationParser<'a, 'f> {
    remaining_text: &'a str,
    line: usize,
    file: &'a str,
    findings: &'f mut Vec<RuleViolation>,
}

impl<'a> CitationParser<'a, '_> {
    /// Reads names and items; returns the cited sheets. A name without an item is not a citation but a variable of a program.
    fn read(&mut self, sheets: &SheetIndex) -> Vec<&'a str> {
        let mut cited = Vec::new();
        loop {
            let name = self.next_word();
            if name.is_empty() || !self.at_item(name.len()) {
                if sheets.get(name).is_some() {
                    self.report_violation(format!("sheet {name} is cited without a section or row"));
                }
                return cited;
            }
            self.advance(name.len());
            let Some(sheet) = sheets.get(name) else {
                let names = sheets.names().join(", ");
                self.report_violation(format!("there is no sheet {name}: {names}"));
                return cited;
            };
            cited.push(name);
            self.items(sheet, name);
            // `; sph B-09` names the next sheet.
            let next = self.remaining_text.strip_prefix(';').map(str::trim_start);
            let Some(next) =
                next.filter(|next| sheets.names().iter().any(|name| starts_with_word(next, name)))
            else {
                return cited;
            };
            self.remaining_text = next;
        }
    }

    /// Reads the items of a citation.
    fn items(&mut self, sheet: &CitableSheet, name: &str) {
        let mut section = String::new();
        loop {
            self.item(sheet, name, &mut section);
            if !self.next_item() {
                return;
            }
        }
    }

    /// Reads one item of a citation: a section or a label.
    fn item(&mut self, sheet: &CitableSheet, name: &str, section: &mut String) {
        if let Some(rest) = self.remaining_text.strip_prefix('§') {
            let number = number(rest);
            self.remaining_text = &rest[number.len()..];
            if !sheet.has_section(number) {
                self.report_violation(format!("sheet {name} has no §{number}"));
            }
            number.clone_into(section);
            self.section_detail(sheet, name, number);
        } else if let Some(label) = label(self.remaining_text) {
            self.advance(label.len());
            if !sheet.has_label(&label) {
                self.report_violation(format!("sheet {name} has no {label}"));
            }
        }
    }

    /// Reads a letter, a row or a set after the number of a section.
    fn section_detail(&mut self, sheet: &CitableSheet, name: &str, number: &str) {
        for word in ["row ", "set "] {
            if let Some(rest) = self.remaining_text.strip_prefix(' ').and_then(|rest| rest.strip_prefix(word))
            {
                let row: String = rest.chars().take_while(char::is_ascii_alphanumeric).collect();
                let known =
                    if word == "row " { sheet.has_row(number, &row) } else { sheet.has_set(number, &row) };
                if !known {
                    self.report_violation(format!("sheet {name} has no {word}{row} in §{number}"));
                }
                self.remaining_text = &rest[row.len()..];
                return;
            }
        }
        let attached = self.remaining_text.strip_prefix(' ').unwrap_or(self.remaining_text);
        let mut characters = attached.chars();
        if let Some(letter) = characters.next().filter(|c| ('a'..='h').contains(c))
            && !characters.next().is_some_and(|c| c.is_alphanumeric() || c == '\'')
        {
            // “§2.5 a” might be an article in running text: a letter that the section lacks counts only where it is attached.
            let known = sheet.has_letter(number, letter);
            if known || attached.len() == self.remaining_text.len() {
                if !known {
                    self.report_violation(format!("sheet {name} has no ({letter}) in §{number}"));
                }
                self.remaining_text = &attached[1..];
            }
        }
    }

    /// Moves to the item that follows `,`, `;`, `and`, `to` or a dash. Returns false where there is none.
    fn next_item(&mut self) -> bool {
        let trimmed = self.remaining_text.trim_start();
        for joint in [",", ";", "and ", "to ", "–", "…", "..."] {
            if let Some(rest) = trimmed.strip_prefix(joint) {
                let rest = rest.trim_start();
                let rest = rest.strip_prefix("and ").unwrap_or(rest).trim_start();
                let is_range = joint == "–" && rest.starts_with(|c: char| c.is_ascii_digit());
                if is_range {
                    // `§2.8–2.11`: the end of a range of sections has no section sign.
                    let number = number(rest);
                    self.remaining_text = &rest[number.len()..];
                    return self.next_item();
                }
                if rest.starts_with('§') || label(rest).is_some() {
                    self.remaining_text = rest;
                    return true;
                }
            }
        }
        false
    }

    /// Word at the start of the remaining text.
    fn next_word(&self) -> &'a str {
        let end = self
            .remaining_text
            .find(|c: char| !(c.is_ascii_lowercase() || c == '-'))
            .unwrap_or(self.remaining_text.len());
        &self.remaining_text[..end]
    }

    /// Whether an item follows after `length` bytes.
    fn at_item(&self, length: usize) -> bool {
        let rest = &self.remaining_text[length..];
        let trimmed = rest.trim_start();
        trimmed.len() < rest.len() && (trimmed.starts_with('§') || label(trimmed).is_some())
    }

    /// Skips bytes of the remaining text, and blanks after them.
    fn advance(&mut self, bytes: usize) {
        self.remaining_text = self.remaining_text[bytes..].trim_start_matches([' ', '\n']);
    }

    /// Adds a violation at the line of the citation.
    fn report_violation(&mut self, message: String) {
        self.findings.push(RuleViolation::new(RULE_NAME, self.file, self.line, message));
    }
}

/// Whether a text begins with a word and a blank.
fn starts_with_word(text: &str, name: &str) -> bool {
    text.strip_prefix(name).is_some_and(|rest| rest.starts_with(' '))
}

/// Digits and dots at the beginning, without a full stop at the end.
fn number(text: &str) -> &str {
    let end = text.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(text.len());
    text[..end].trim_end_matches('.')
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHEET: &str = "# A sheet\n### 2.5 Shapes\n(b) linear\n### 3.3 Step\n## 4. List\n| 58 | row |\n**A-27 Column**\n**A-28 Cylinder**\n";

    fn messages(path: &str, text: &str) -> Vec<String> {
        let tree = SourceTree::from_files(&[
            ("docs/sheets/mpm.md", SHEET),
            ("docs/sheets/sph.md", "**B-09 Columns**"),
            (path, text),
        ]);
        citations(&tree, &SheetIndex::from_tree(&tree)).into_iter().map(|finding| finding.message).collect()
    }

    #[test]
    fn citations_of_existing_sheet_labels_are_accepted() {
        for text in [
            "//! The step (sheet: mpm §3.3).",
            "/// Shapes (sheet: mpm §2.5b, §3.3,\n/// A-27; after somebody).",
            "// sheet: mpm §4 row 58.",
            "// sheet: mpm A-27 to A-28: columns; A-28 again",
            "source: \"sheet: mpm A-27; sph B-09\"",
            "fn agrees(found: f64, sheet: f64, digits: i32)",
            "// sheet: mpm §2.5–3.3 and A-27. V is a volume.",
            "// `sheet: mpm §3.3` a letter that is none",
        ] {
            assert_eq!(messages("crates/case/src/x.rs", text), [""; 0], "{text}");
        }
    }

    #[test]
    fn citations_of_missing_sheet_labels_are_reported() {
        for (text, expected) in [
            ("// sheet: mpm §3.4", "sheet mpm has no §3.4"),
            ("// sheet: mpm §3.3, A-29", "sheet mpm has no A-29"),
            ("// sheet: mpm §2.5c", "sheet mpm has no (c) in §2.5"),
            ("// sheet: mpm §4 row 59", "sheet mpm has no row 59 in §4"),
            ("// sheet: dem §3.3", "there is no sheet dem: mpm, sph"),
            ("// sheet: mpm: the step", "sheet mpm is cited without a section or row"),
            ("// sheet: mpm A-27; sph B-10", "sheet sph has no B-10"),
        ] {
            let found = messages("crates/case/src/x.rs", text);
            assert!(found.iter().any(|message| message == expected), "{text}: {found:?}");
        }
    }

    #[test]
    fn a_label_belongs_to_a_sheet_that_the_file_or_its_folder_is_about() {
        assert_eq!(messages("crates/mpm/src/x.rs", "// A-27 once more"), [""; 0]);
        assert_eq!(messages("crates/mpm/src/x.rs", "// A-30"), ["A-30 is in no sheet that this file cites"]);
        assert_eq!(messages("crates/case/src/x.rs", "// A-27"), ["A-27 is in no sheet that this file cites"]);
        assert_eq!(messages("crates/case/src/x.rs", "let x = A-27_f64;"), [""; 0]);
    }

    #[test]
    fn a_sheet_without_a_name_and_the_old_form_are_found() {
        assert_eq!(
            messages("crates/case/src/x.rs", "// as the sheet says"),
            ["mentions a sheet without citing it"]
        );
        assert_eq!(
            messages("crates/mpm/src/x.rs", concat!("// MPM", " sheet §3.3")),
            ["cite a sheet as `sheet: <name> §3.3`"]
        );
    }
}
