//! `colluvium explain`.

use clap::Args;

use super::CommandError;

/// Text of `docs/messages.md`, of which a test holds this copy equal.
const PAGE: &str = include_str!("messages.txt");

#[derive(Args)]
pub struct ExplainArguments {
    /// The code in the brackets of a message, for example `unused-material`, or the message itself; without it all codes are listed.
    code: Option<String>,
}

/// Prints the section or the row of a code, or all codes.
pub fn run(arguments: &ExplainArguments) -> Result<(), CommandError> {
    let Some(text) = &arguments.code else {
        print_line!("{}", all_codes().join("\n"));
        return Ok(());
    };
    let code = code_of_message(text);
    let Some(text) = section(&code).or_else(|| row(&code)) else {
        let problem = format!(
            "{code:?} is not a code of a message: give the word in the brackets of a message; `colluvium explain` \
             lists all"
        );
        return Err(CommandError::usage("wrong-usage", problem));
    };
    print_line!("{text}");
    Ok(())
}

/// Code in the brackets of a message; a text without brackets is the code itself.
fn code_of_message(text: &str) -> String {
    let inside = text.split_once('[').and_then(|(_, rest)| rest.split(']').next());
    inside.unwrap_or(text).trim().to_lowercase()
}

/// Codes of all messages in alphabetical order.
fn all_codes() -> Vec<&'static str> {
    let of_section = PAGE.lines().filter_map(|line| line.strip_prefix("### "));
    let first_cells = PAGE.lines().filter_map(|line| line.strip_prefix("| `")?.split('|').next());
    let of_rows = first_cells.flat_map(|cell| cell.split('`').filter(|part| is_code(part)));
    let mut codes: Vec<&str> = of_section.chain(of_rows).filter(|code| is_code(code)).collect();
    codes.sort_unstable();
    codes.dedup();
    codes
}

/// Whether a text has the form of a code: small letters and hyphens.
fn is_code(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|c| c.is_ascii_lowercase() || c == '-')
}

/// Section under the heading of a code.
fn section(code: &str) -> Option<String> {
    let heading = format!("\n### {code}\n");
    let (_, rest) = PAGE.split_once(&heading)?;
    let text = rest.split("\n#").next().unwrap_or_default();
    Some(format!("{code}\n\n{}", without_links(text.trim())))
}

/// Row of a table for a code, with the headings of the columns.
fn row(code: &str) -> Option<String> {
    let mut headings: Vec<&str> = Vec::new();
    for line in PAGE.lines() {
        let cells = || line.trim_matches('|').split('|').map(str::trim).collect::<Vec<_>>();
        if line.starts_with("| code ") {
            headings = cells();
        } else if !line.starts_with('|') {
            headings.clear();
        } else if !headings.is_empty() && line.contains(&format!("`{code}`")) {
            let cells = cells();
            if !cells[0].contains(&format!("`{code}`")) {
                continue;
            }
            let parts = headings.iter().zip(&cells).skip(1).filter(|(_, cell)| **cell != "–");
            let lines = parts.map(|(heading, cell)| format!("{heading}: {}", without_links(cell)));
            return Some(format!("{code}\n\n{}", lines.collect::<Vec<_>>().join("\n")));
        }
    }
    None
}

/// Text without the targets of its links and without marks of code.
fn without_links(text: &str) -> String {
    let mut plain = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("](") {
        let (begin, name) = before.rsplit_once('[').unwrap_or((before, ""));
        plain.push_str(begin);
        plain.push_str(name);
        rest = after.split_once(')').map_or("", |(_, after)| after);
    }
    plain.push_str(rest);
    plain.replace('`', "")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_listed_code_has_an_explanation() {
        let codes = all_codes();
        assert!(codes.contains(&"unknown-key") && codes.contains(&"unused-material"), "{codes:?}");
        for code in codes {
            assert!(section(code).or_else(|| row(code)).is_some(), "{code}");
        }
    }

    #[test]
    fn a_whole_message_names_its_code() {
        assert_eq!(code_of_message("error[no-equilibrium]: step 3"), "no-equilibrium");
        assert_eq!(code_of_message("Unknown-Key"), "unknown-key");
    }
}
