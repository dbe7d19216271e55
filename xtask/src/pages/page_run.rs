//! A run of the blocks of a page in a folder of its own.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use super::blocks::{Block, BlockAction};
use crate::root;

/// Number of characters of an output that an error shows.
const SHOWN_CHARACTERS: usize = 2000;

/// State of the run of a page.
pub struct PageRun<'a> {
    /// File of the page.
    page: &'a Path,
    /// Folder in which the blocks run.
    folder: &'a Path,
    /// Folder of the program.
    programs: PathBuf,
    /// Whether pictures of the documentation are written anew.
    writes_pictures: bool,
    /// Output of the last commands.
    output: String,
    /// Blocks that were not run for want of a program or of a module of Python.
    pub skipped: usize,
}

impl<'a> PageRun<'a> {
    /// Run of a page in `folder`.
    pub fn new(page: &'a Path, folder: &'a Path, programs: PathBuf, writes_pictures: bool) -> Self {
        Self { page, folder, programs, writes_pictures, output: String::new(), skipped: 0 }
    }

    /// Runs a block.
    ///
    /// # Errors
    /// A command that fails, output that lacks a line, a file or picture that does not exist.
    pub fn run(&mut self, block: &Block) -> Result<(), String> {
        if block.needs.as_deref().is_some_and(|program| !is_installed(program)) {
            self.skipped += 1;
            return Ok(());
        }
        match &block.action {
            BlockAction::Commands(lines) => self.run_commands(lines),
            BlockAction::Output(lines) => self.compare_output(lines),
            BlockAction::File { name, content } => self.write(name, content),
            BlockAction::Change { name, pointer, content } => self.change(name, pointer, content),
            BlockAction::Example { file, content } => compare_example(file, content),
            BlockAction::Python(text) => self.run_python(text),
            BlockAction::Picture { shown, made } => self.check_picture(shown, made),
        }
    }

    /// Runs commands one after another.
    fn run_commands(&mut self, lines: &[String]) -> Result<(), String> {
        self.output.clear();
        for line in lines.iter().filter(|line| !line.trim().is_empty()) {
            self.execute(line, Command::new("sh").arg("-ec").arg(line))?;
        }
        Ok(())
    }

    /// Runs a command in the folder and keeps its output.
    fn execute(&mut self, name: &str, command: &mut Command) -> Result<(), String> {
        let path = std::env::var("PATH").unwrap_or_default();
        let path = format!("{}:{path}", self.programs.display());
        let output = command
            .current_dir(self.folder)
            .env("PATH", path)
            .output()
            .map_err(|error| format!("{name}: {error}"))?;
        for stream in [&output.stdout, &output.stderr] {
            self.output.push_str(&String::from_utf8_lossy(stream));
        }
        if output.status.success() {
            return Ok(());
        }
        let skipped = self.output.chars().count().saturating_sub(SHOWN_CHARACTERS);
        let end: String = self.output.chars().skip(skipped).collect();
        Err(format!("{name}: {}\n{end}", output.status))
    }

    /// Compares lines with the output, in their order.
    fn compare_output(&self, lines: &[String]) -> Result<(), String> {
        let mut printed = self.output.lines();
        for line in lines.iter().filter(|line| !matches!(line.trim(), "" | "…")) {
            if !printed.any(|other| matches_line(line.trim(), other.trim())) {
                return Err(format!(
                    "the output lacks the line {line:?}, or it is out of order:\n{}",
                    self.output
                ));
            }
        }
        Ok(())
    }

    /// Writes a file of the reader.
    fn write(&self, name: &str, content: &str) -> Result<(), String> {
        let path = self.folder.join(name);
        fs::write(&path, content).map_err(|error| format!("{name}: {error}"))
    }

    /// Merges an object into a JSON file.
    fn change(&self, name: &str, pointer: &str, content: &str) -> Result<(), String> {
        let path = self.folder.join(name);
        let text = fs::read_to_string(&path).map_err(|error| format!("{name}: {error}"))?;
        let mut file: Value = serde_json::from_str(&text).map_err(|error| format!("{name}: {error}"))?;
        let change = serde_json::from_str(content).map_err(|error| format!("the change: {error}"))?;
        let place = file.pointer_mut(pointer).ok_or_else(|| format!("{name} has no {pointer}"))?;
        merge(place, change);
        self.write(name, &serde_json::to_string_pretty(&file).map_err(|error| error.to_string())?)
    }

    /// Runs a program in Python if its modules are installed.
    fn run_python(&mut self, text: &str) -> Result<(), String> {
        let is_import = |line: &&str| line.starts_with("import ") || line.starts_with("from ");
        let imports: Vec<&str> = text.lines().filter(is_import).collect();
        let output = Command::new("python3").args(["-c", &imports.join("\n")]).output();
        if !output.is_ok_and(|output| output.status.success()) {
            self.skipped += 1;
            return Ok(());
        }
        self.output.clear();
        self.execute("python3", Command::new("python3").env("MPLBACKEND", "agg").arg("-c").arg(text))
    }

    /// Checks that a command has made a picture of the page, and copies it to the documentation if that was asked for.
    fn check_picture(&self, shown: &str, made: &str) -> Result<(), String> {
        let source = self.folder.join(made);
        let target = self.page.parent().unwrap_or(Path::new("")).join(shown);
        if !source.is_file() {
            return Err(format!("no command has written {made}"));
        }
        if self.writes_pictures {
            fs::copy(&source, &target).map_err(|error| format!("{}: {error}", target.display()))?;
        }
        if target.is_file() {
            Ok(())
        } else {
            Err(format!("{shown} is not in the documentation: use --pictures"))
        }
    }
}

/// Whether the shell finds a program.
fn is_installed(program: &str) -> bool {
    let output = Command::new("sh").args(["-c", "command -v \"$0\"", program]).output();
    output.is_ok_and(|output| output.status.success())
}

/// Whether a printed line is that of a page, in which `…` is any text.
fn matches_line(expected: &str, printed: &str) -> bool {
    let parts: Vec<&str> = expected.split('…').collect();
    let (first, last) = (parts[0], parts[parts.len() - 1]);
    if parts.len() == 1 {
        return expected == printed;
    }
    let Some(mut rest) = printed.strip_prefix(first).and_then(|rest| rest.strip_suffix(last)) else {
        return false;
    };
    parts[1..parts.len() - 1].iter().all(|part| match rest.find(part) {
        Some(place) => {
            rest = &rest[place + part.len()..];
            true
        }
        None => false,
    })
}

/// Merges a change into a value (RFC 7396).
fn merge(value: &mut Value, change: Value) {
    let Value::Object(change) = change else {
        *value = change;
        return;
    };
    if !value.is_object() {
        *value = Value::Object(serde_json::Map::new());
    }
    let object = value.as_object_mut().expect("it was made one");
    for (key, change) in change {
        if change.is_null() {
            object.remove(&key);
        } else {
            merge(object.entry(key).or_insert(Value::Null), change);
        }
    }
}

/// Compares a block with the lines of a file of the repository.
fn compare_example(file: &str, content: &str) -> Result<(), String> {
    let text = fs::read_to_string(root().join(file)).map_err(|error| format!("{file}: {error}"))?;
    if text.contains(content.trim_end()) {
        Ok(())
    } else {
        Err(format!("{file} does not contain these lines"))
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::{matches_line, merge};

    #[test]
    fn an_ellipsis_is_any_text_of_a_line() {
        assert!(matches_line("factor 1.34… in …", "factor 1.3402 in 3 s"));
        assert!(matches_line("a … b … c", "a 1 b 2 c"));
        assert!(!matches_line("a … b … c", "a 1 c 2 c"));
        assert!(!matches_line("factor 1.34", "factor 1.3402"));
        assert!(!matches_line("ab…ba", "aba"));
    }

    #[test]
    fn a_change_merges_objects_and_removes_null() {
        let mut value = json!({ "a": { "b": 1, "c": 2 }, "d": [1, 2] });
        merge(&mut value, json!({ "a": { "b": null, "e": 3 }, "d": [4] }));
        assert_eq!(value, json!({ "a": { "c": 2, "e": 3 }, "d": [4] }));
    }
}
