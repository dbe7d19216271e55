//! `colluvium new`.

use std::path::{Path, PathBuf};

use crate::case::CaseErrorKind;
use crate::case::output::write_atomically;
use crate::{TEMPLATES, Template, TemplateKind};
use clap::Args;

use super::CommandError;

#[derive(Args)]
#[command(after_help = "Usual calls:\n  colluvium new\n  colluvium new column-collapse")]
pub struct NewArguments {
    /// Name of the template; a list of all when absent.
    template: Option<String>,
    /// File to write; `<template>.json` by default.
    file: Option<PathBuf>,
    /// List the templates.
    #[arg(long)]
    list: bool,
}

/// Writes the case file of a template, with the files that it names.
pub fn run(arguments: &NewArguments) -> Result<(), CommandError> {
    let Some(name) = arguments.template.as_deref().filter(|_| !arguments.list) else {
        return print_list();
    };
    let template = Template::find(name).ok_or_else(|| {
        let names: Vec<&str> = TEMPLATES.iter().map(|template| template.name).collect();
        let problem = CaseErrorKind::unknown_name(name, &names, "the name of a template");
        CommandError::usage("wrong-usage", format!("{problem}; there are: {}", names.join(", ")))
    })?;
    let file = arguments.file.clone().unwrap_or_else(|| format!("{name}.json").into());
    let folder = file.parent().unwrap_or(Path::new(""));
    let beside = crate::template_files(name).into_iter().map(|other| folder.join(other));
    for file in beside.chain([file.clone()]) {
        if file.exists() {
            return Err(CommandError::usage("wrong-usage", format!("{} exists already", file.display())));
        }
    }
    crate::write_template_files(name, folder)?;
    write_atomically(&file, template.text.as_bytes())?;
    for other in crate::template_files(name) {
        print_line!("wrote {}", folder.join(other).display());
    }
    let command = match template.kind {
        TemplateKind::Case => return print_check(template, &file),
        TemplateKind::ElementTest => "element-test",
        TemplateKind::ForeignLaw => {
            print_line!(
                "wrote {0}; try: cc -shared -fPIC -O2 -o libsoil.so soil.c -lm && colluvium element-test {0} --allow-library",
                file.display()
            );
            return Ok(());
        }
        TemplateKind::Sweep => "sweep --check",
        TemplateKind::Fit => "fit",
    };
    print_line!("wrote {0}; try: colluvium {command} {0}", file.display());
    Ok(())
}

/// Prints the command that checks the case of a template; one with several methods needs the name of one.
fn print_check(template: &Template, file: &Path) -> Result<(), CommandError> {
    let case = serde_json::from_str::<serde_json::Value>(template.text).unwrap_or_default();
    let mut names = case["methods"].as_object().into_iter().flat_map(|methods| methods.keys());
    let method = match (names.next(), names.next()) {
        (Some(first), Some(_)) => format!(" --method {first}"),
        _ => String::new(),
    };
    print_line!("wrote {0}; try: colluvium check {0}{method}", file.display());
    Ok(())
}

/// Prints the templates by topic, each with a line.
fn print_list() -> Result<(), CommandError> {
    for group in TEMPLATES.chunk_by(|a, b| a.topic == b.topic) {
        print_line!("{}", group[0].topic);
        for template in group {
            print_line!("  {:<18} {}", template.name, template.summary);
            print_line!("  {:<18} picture: {}", "", template.picture());
        }
    }
    print_line!("\nWrite one with: colluvium new NAME");
    Ok(())
}
