//! Runs the commands and snippets of the documentation as a reader would.
//!
//! A page runs in an empty folder, block by block. A comment before a block says how: `docs/contributing.md` lists them.

mod blocks;
mod page_run;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use clap::Args;

use crate::root;
use page_run::PageRun;

#[derive(Args)]
pub struct PagesArguments {
    /// Run pages whose path contains one of these words; all pages by default.
    names: Vec<String>,
    /// Run also the blocks that take minutes.
    #[arg(long)]
    long: bool,
    /// Write the pictures of the documentation anew.
    #[arg(long)]
    pictures: bool,
}

/// Runs the blocks of the pages. True where all pass.
pub fn run(arguments: &PagesArguments) -> Result<bool, String> {
    let programs = build_program()?;
    let mut all_pass = true;
    let mut skipped = 0;
    for page in pages()? {
        let name = page.strip_prefix(root()).unwrap_or(&page).display().to_string();
        let is_chosen =
            arguments.names.is_empty() || arguments.names.iter().any(|word| name.contains(word.as_str()));
        if !is_chosen {
            continue;
        }
        let start = Instant::now();
        match run_page(&page, &programs, arguments) {
            Ok(None) => {}
            Ok(Some(count)) => {
                skipped += count;
                println!("pass {:7.1} s  {name}", start.elapsed().as_secs_f64());
            }
            Err(problem) => {
                all_pass = false;
                println!("FAIL {:7.1} s  {name}: {problem}", start.elapsed().as_secs_f64());
            }
        }
    }
    if skipped > 0 {
        println!("{skipped} blocks were not run: a program or a module of Python is not installed");
    }
    Ok(all_pass)
}

/// Runs the blocks of a page; `None` if it has none, else the number of skipped ones.
fn run_page(page: &Path, programs: &Path, arguments: &PagesArguments) -> Result<Option<usize>, String> {
    let text = std::fs::read_to_string(page).map_err(|error| error.to_string())?;
    let mut blocks = blocks::blocks(&text)?;
    blocks.retain(|block| arguments.long || !block.is_long);
    if blocks.is_empty() {
        return Ok(None);
    }
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let mut run = PageRun::new(page, folder.path(), programs.to_owned(), arguments.pictures);
    for block in &blocks {
        run.run(block).map_err(|problem| format!("line {}: {problem}", block.line))?;
    }
    Ok(Some(run.skipped))
}

/// Builds the program and returns its folder.
fn build_program() -> Result<PathBuf, String> {
    let mut build = Command::new(env!("CARGO"));
    build.current_dir(root()).args([
        "build",
        "--release",
        "--quiet",
        "--package",
        "colluvium",
        "--package",
        "xtask",
    ]);
    let status = build.status().map_err(|error| format!("cargo: {error}"))?;
    if !status.success() {
        return Err("the program does not build".to_owned());
    }
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from);
    std::path::absolute(target.join("release")).map_err(|error| error.to_string())
}

/// README and all pages of the documentation, without specification sheets, which quote sources, and the generated case reference, whose
/// snippets are tested by the crate `colluvium`.
fn pages() -> Result<Vec<PathBuf>, String> {
    let mut found = markdown_files(root().join("docs"), &["docs/sheets", "docs/case"])?;
    found.push(root().join("README.md"));
    found.sort();
    Ok(found)
}

/// Markdown files below a folder in the order of their paths, without those in `skipped` folders.
pub(crate) fn markdown_files(folder: PathBuf, skipped: &[&str]) -> Result<Vec<PathBuf>, String> {
    let (mut found, mut folders) = (Vec::new(), vec![folder]);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))? {
            let path = entry.map_err(|error| error.to_string())?.path();
            if path.is_dir() && !skipped.iter().any(|skip| path.ends_with(skip)) {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "md") {
                found.push(path);
            }
        }
    }
    found.sort();
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::pages;
    use crate::benchmarks::all_benchmarks;

    /// Words that follow `before` in a text.
    fn words_after<'a>(text: &'a str, before: &'a str) -> impl Iterator<Item = &'a str> {
        let is_part = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '/');
        text.split(before).skip(1).map(move |rest| rest.split(|c| !is_part(c)).next().unwrap_or_default())
    }

    #[test]
    fn pages_name_templates_and_benchmarks_that_exist() {
        for page in pages().unwrap() {
            let text = std::fs::read_to_string(&page).unwrap();
            for name in
                words_after(&text, "colluvium new ").filter(|name| name.starts_with(char::is_lowercase))
            {
                assert!(colluvium::template(name).is_some(), "{}: no template {name:?}", page.display());
            }
            for name in words_after(&text, "cargo xtask validate ").filter(|name| name.contains('/')) {
                let exists = all_benchmarks().any(|benchmark| benchmark.id.starts_with(name));
                assert!(exists, "{}: no benchmark {name:?}", page.display());
            }
        }
    }

    #[test]
    fn blocks_of_all_pages_say_how_they_are_run() {
        for page in pages().unwrap() {
            let text = std::fs::read_to_string(&page).unwrap();
            if let Err(problem) = super::blocks::blocks(&text) {
                panic!("{}: {problem}", page.display());
            }
        }
    }
}
