//! `colluvium schema`.

use clap::Args;

use super::Failure;

#[derive(Args)]
pub struct Arguments {
    /// Print the case-file reference as Markdown instead.
    #[arg(long)]
    markdown: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.markdown {
        say!("{}", colluvium::case_reference().trim_end());
    } else {
        let text = serde_json::to_string_pretty(&colluvium::case_schema());
        say!("{}", text.map_err(|error| Failure::Other(error.to_string()))?);
    }
    Ok(())
}
