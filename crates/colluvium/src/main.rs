//! The program `colluvium`: the command line of the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    colluvium::cli::main(std::env::args_os())
}
