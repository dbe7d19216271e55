//! `cargo xtask book`: the site of the documentation.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Component, Path, PathBuf};
use std::process::Command;

use clap::Args;
use pulldown_cmark::{Event, Parser, Tag};

use crate::pages::markdown_files;
use crate::root;

/// Folder of the site below the root of the repository. The pages are in its folder `docs`, beside the source files that they link.
const SITE: &str = "target/site";

#[derive(Args)]
pub struct BookArguments {
    /// Open the site in a browser.
    #[arg(long)]
    open: bool,
}

/// Builds the site with mdBook, with the files outside the documentation to which its pages link.
pub fn run(arguments: &BookArguments) -> Result<bool, String> {
    let mut command = Command::new("mdbook");
    command.current_dir(root()).args(["build", "docs"]);
    if arguments.open {
        command.arg("--open");
    }
    let status = command
        .status()
        .map_err(|error| format!("mdbook: {error}; install it with `cargo install mdbook mdbook-katex`"))?;
    if !status.success() {
        return Ok(false);
    }
    for linked in linked_outside(&root().join("docs"))? {
        copy_into_site(&linked)?;
    }
    println!("the site is {SITE}/docs/index.html");
    Ok(true)
}

/// Files and folders outside `docs` to which pages of `docs` link, relative to the root of the repository.
fn linked_outside(docs: &Path) -> Result<BTreeSet<PathBuf>, String> {
    let mut found = BTreeSet::new();
    for page in markdown_files(docs.to_path_buf(), &[])? {
        let text = fs::read_to_string(&page).map_err(|error| format!("{}: {error}", page.display()))?;
        let folder = page.parent().unwrap_or(docs);
        let folder = folder.strip_prefix(root()).unwrap_or(folder);
        found.extend(links(&text).filter_map(|link| outside_path(folder, &link)));
    }
    Ok(found)
}

/// Targets of the links of a page.
fn links(text: &str) -> impl Iterator<Item = String> {
    Parser::new(text).filter_map(|event| match event {
        Event::Start(Tag::Link { dest_url, .. }) => Some(dest_url.to_string()),
        _ => None,
    })
}

/// Path of a link's target relative to the root of the repository, where it is a file outside `docs`. `folder` is that of the page.
fn outside_path(folder: &Path, link: &str) -> Option<PathBuf> {
    let target = link.split('#').next().filter(|target| target.starts_with("../"))?;
    let mut path = PathBuf::new();
    for part in folder.join(target).components() {
        match part {
            Component::ParentDir => {
                path.pop();
            }
            other => path.push(other),
        }
    }
    (!path.starts_with("docs")).then_some(path)
}

/// Copies a file, or the files of a folder, to the same place in the site.
fn copy_into_site(path: &Path) -> Result<(), String> {
    let (from, to) = (root().join(path), root().join(SITE).join(path));
    let failed = |error: std::io::Error| format!("{}: {error}", path.display());
    if from.is_dir() {
        fs::create_dir_all(&to).map_err(failed)?;
        for entry in fs::read_dir(&from).map_err(failed)? {
            let entry = entry.map_err(failed)?.path();
            if let (true, Some(name)) = (entry.is_file(), entry.file_name()) {
                fs::copy(&entry, to.join(name)).map_err(failed)?;
            }
        }
        return Ok(());
    }
    fs::create_dir_all(to.parent().unwrap_or(&to)).map_err(failed)?;
    fs::copy(&from, &to).map_err(failed)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_out_of_the_documentation_are_found_by_their_place_in_the_repository() {
        let text =
            "[a](../../crates/mpm/src/lib.rs) [b](../laws/snow.md#x) [c](https://example.org) [d](#here)";
        let folder = Path::new("docs/theory");
        let found: Vec<PathBuf> = links(text).filter_map(|link| outside_path(folder, &link)).collect();
        assert_eq!(found, [PathBuf::from("crates/mpm/src/lib.rs")]);
    }
}
