//! `colluvium completions`.

use std::io::{ErrorKind, Write};

use clap::{Args, Command};
use clap_complete::Shell;

use super::CommandError;

#[derive(Args)]
#[command(
    after_help = "Usual call:\n  colluvium completions bash > ~/.local/share/bash-completion/completions/colluvium"
)]
pub struct CompletionsArguments {
    /// The shell.
    shell: Shell,
}

/// Prints the script for a shell.
pub fn run(arguments: &CompletionsArguments, command: &mut Command) -> Result<(), CommandError> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, command, "colluvium", &mut script);
    match std::io::stdout().write_all(&script) {
        // Nobody reads on, as behind `head`.
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => {
            written.map_err(|error| CommandError::message("output", format!("standard output: {error}")))
        }
    }
}
