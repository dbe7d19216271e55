//! `cargo xtask book`: the site of the documentation.

use std::process::Command;

use clap::Args;

use crate::root;

#[derive(Args)]
pub struct BookArguments {
    /// Open the site in a browser.
    #[arg(long)]
    open: bool,
}

/// Builds the site with mdBook.
pub fn run(arguments: &BookArguments) -> Result<bool, String> {
    let mut command = Command::new("mdbook");
    command.current_dir(root()).args(["build", "docs"]);
    if arguments.open {
        command.arg("--open");
    }
    let status = command
        .status()
        .map_err(|error| format!("mdbook: {error}; install it with `cargo install mdbook mdbook-katex`"))?;
    if status.success() {
        println!("the site is target/book/index.html");
    }
    Ok(status.success())
}
