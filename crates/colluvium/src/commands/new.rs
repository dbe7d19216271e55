//! `colluvium new`.

use std::path::{Path, PathBuf};

use clap::Args;
use colluvium::case::output::write_atomically;

use super::CommandError;

#[derive(Args)]
pub struct NewArguments {
    /// Name of the template.
    #[arg(required_unless_present = "list")]
    template: Option<String>,
    /// File to write; `<template>.json` by default.
    file: Option<PathBuf>,
    /// List the templates.
    #[arg(long)]
    list: bool,
}

/// Writes the case file of a template, with the files that it names.
pub fn run(arguments: &NewArguments) -> Result<(), CommandError> {
    let names = colluvium::template_names();
    let Some(name) = arguments.template.as_deref().filter(|_| !arguments.list) else {
        print_line!("{}", names.join("\n"));
        return Ok(());
    };
    let text = colluvium::template(name).ok_or_else(|| {
        CommandError::Usage(format!("{name:?} is not a template; there are: {}", names.join(", ")))
    })?;
    let file = arguments.file.clone().unwrap_or_else(|| format!("{name}.json").into());
    let folder = file.parent().unwrap_or(Path::new(""));
    let beside = colluvium::template_files(name).into_iter().map(|other| folder.join(other));
    for file in beside.chain([file.clone()]) {
        if file.exists() {
            return Err(CommandError::Usage(format!("{} exists already", file.display())));
        }
    }
    colluvium::write_template_files(name, folder)?;
    write_atomically(&file, text.as_bytes())?;
    for other in colluvium::template_files(name) {
        print_line!("wrote {}", folder.join(other).display());
    }
    print_line!("wrote {0}; try: colluvium check {0}", file.display());
    Ok(())
}
