//! `colluvium explain`.

use clap::Args;

use super::CommandError;

/// Text of `docs/messages.md`, of which a test holds this copy equal.
const PAGE: &str = include_str!("messages.txt");

#[derive(Args)]
pub struct ExplainArguments {
    /// The code in the brackets of a message, for example `unused-material`.
    code: String,
}

/// Prints the section or the row of a code.
pub fn run(arguments: &ExplainArguments) -> Result<(), CommandError> {
    let code = arguments.code.as_str();
    let Some(text) = section(code).or_else(|| row(code)) else {
        let problem =
            format!("{code:?} is not a code of a message: give the word in the brackets of a message");
        return Err(CommandError::usage("wrong-usage", problem));
    };
    print_line!("{text}");
    Ok(())
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
