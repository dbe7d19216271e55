//! `colluvium schema`.

use clap::Args;

use super::CommandError;

#[derive(Args)]
#[command(after_help = "Usual call:\n  colluvium schema > case.schema.json")]
pub struct SchemaArguments {
    /// Print the reference of the case file as Markdown instead, page after page.
    #[arg(long)]
    markdown: bool,
    /// Print the schema of a sweep's file instead.
    #[arg(long, conflicts_with = "markdown")]
    sweep: bool,
    /// Print the schema of a fit's file instead.
    #[arg(long, conflicts_with_all = ["markdown", "sweep"])]
    fit: bool,
}

/// Prints the JSON Schema of a case, a sweep or a fit, or the case reference.
pub fn run(arguments: &SchemaArguments) -> Result<(), CommandError> {
    if arguments.markdown {
        for (_, text) in crate::case_reference() {
            print_line!("{text}");
        }
    } else {
        let schema = match (arguments.sweep, arguments.fit) {
            (true, _) => crate::sweep::Sweep::schema(),
            (_, true) => crate::fit::Fit::schema(),
            _ => crate::case_schema(),
        };
        let text = serde_json::to_string_pretty(&schema);
        print_line!("{}", text.map_err(|error| CommandError::message("output", error.to_string()))?);
    }
    Ok(())
}
