//! `colluvium schema`.

use clap::Args;

use super::Failure;

#[derive(Args)]
pub struct Arguments {
    /// Print the case-file reference as Markdown instead.
    #[arg(long)]
    markdown: bool,
    /// Print the schema of a sweep's file instead.
    #[arg(long, conflicts_with = "markdown")]
    sweep: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.markdown {
        say!("{}", colluvium::case_reference().trim_end());
    } else {
        let schema =
            if arguments.sweep { colluvium::sweep::Sweep::schema() } else { colluvium::case_schema() };
        let text = serde_json::to_string_pretty(&schema);
        say!("{}", text.map_err(|error| Failure::Other(error.to_string()))?);
    }
    Ok(())
}
