//! Tests of the facade and the command line as users meet them. Tests that need their own process are beside this suite.

mod boulders;
mod check;
mod cli;
mod compare;
mod debris_flow;
mod element_tests;
mod examples;
mod file_kinds;
mod foreign_libraries;
mod granular_cells;
mod invalid_json;
mod messages;
mod methods_agree;
mod point_files;
mod point_transfer;
mod reference_pages;
mod result_warnings;
mod rigid_body_support;
mod run_folders;
mod strength_reduction;
mod wanted_fields;

use std::path::Path;
use std::process::{Command, Output};

/// Command of the program.
fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_colluvium"))
}

/// Exit code, standard output and standard error of a command.
fn output(command: &mut Command) -> (i32, String, String) {
    let Output { status, stdout, stderr } = command.output().expect("the program starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (status.code().unwrap_or(-1), text(stdout), text(stderr))
}

/// Exit code, standard output and standard error of the program in a folder.
fn in_folder(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    output(program().current_dir(folder).args(arguments))
}
