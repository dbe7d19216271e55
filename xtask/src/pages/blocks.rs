//! Code blocks and pictures of a page, with the comments that say how they are run.

use pulldown_cmark::{CodeBlockKind, Event, Options, Parser, Tag, TagEnd};

/// Part of a page that is run or compared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// Line of the page, from one.
    pub line: usize,
    /// Whether it needs a long run.
    pub is_long: bool,
    /// Program without which it is skipped.
    pub needs: Option<String>,
    /// Action of the block.
    pub action: BlockAction,
}

/// Action of a block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BlockAction {
    /// Commands of a shell, one a line.
    Commands(Vec<String>),
    /// Lines that the commands before must have printed; `…` is any text of a line.
    Output(Vec<String>),
    /// File with this content.
    File { name: String, content: String },
    /// JSON object that is merged into a file (RFC 7396), at the place of a JSON pointer.
    Change { name: String, pointer: String, content: String },
    /// Lines of a file of the repository.
    Example { file: String, content: String },
    /// Program in Python.
    Python(String),
    /// Picture of the page, and the file that a command has written.
    Picture { shown: String, made: String },
}

/// Comment before a block.
#[derive(Default)]
struct Directives {
    /// `<!-- long -->`.
    is_long: bool,
    /// `<!-- needs: PROGRAM -->`.
    needs: Option<String>,
    /// `<!-- not run: REASON -->`.
    is_not_run: bool,
    /// Kind and value of any other: `output`, `file: NAME`, `change: NAME POINTER`, `example: FILE`, `picture: FILE`.
    other: Option<(String, String)>,
}

/// Blocks of a page in their order.
///
/// # Errors
/// A block whose comment is unknown or does not fit, or that has none but needs one.
pub fn blocks(page: &str) -> Result<Vec<Block>, String> {
    let mut found = Vec::new();
    let mut directives = Directives::default();
    let mut code: Option<(String, String)> = None;
    let parser = Parser::new_ext(page, Options::ENABLE_TABLES | Options::ENABLE_MATH);
    for (event, range) in parser.into_offset_iter() {
        let line = page[..range.start].matches('\n').count() + 1;
        let at_line = |problem: String| format!("line {line}: {problem}");
        match event {
            Event::Html(text) => {
                let hidden = directives.read(&text).map_err(at_line)?;
                let action = hidden.map(|command| BlockAction::Commands(vec![command]));
                found.extend(action.map(|action| directives.block(line, action)));
            }
            Event::Start(Tag::CodeBlock(kind)) => code = Some((language(&kind), String::new())),
            Event::Text(text) if code.is_some() => {
                code.as_mut().expect("the guard found it").1.push_str(&text);
            }
            Event::End(TagEnd::CodeBlock) => {
                let (language, text) = code.take().expect("a block that ends has begun");
                let used = std::mem::take(&mut directives);
                let action = used.action(&language, text).map_err(at_line)?;
                found.extend(action.map(|action| used.block(line, action)));
            }
            Event::Start(Tag::Image { dest_url, .. }) => {
                let used = std::mem::take(&mut directives);
                if let Some((_, made)) = used.other.as_ref().filter(|(kind, _)| kind == "picture") {
                    let action = BlockAction::Picture { shown: dest_url.to_string(), made: made.clone() };
                    found.push(used.block(line, action));
                }
            }
            _ => {}
        }
    }
    Ok(found)
}

/// Language of a block: the first word after the fence.
fn language(kind: &CodeBlockKind<'_>) -> String {
    match kind {
        CodeBlockKind::Fenced(info) => info.split([' ', ',']).next().unwrap_or_default().to_owned(),
        CodeBlockKind::Indented => String::new(),
    }
}

impl Directives {
    /// Reads a comment; returns the command of `<!-- run: COMMAND -->`, which the page does not show.
    fn read(&mut self, html: &str) -> Result<Option<String>, String> {
        let Some(text) = html.trim().strip_prefix("<!--").and_then(|rest| rest.strip_suffix("-->")) else {
            return Ok(None);
        };
        let (kind, value) = text.trim().split_once(':').unwrap_or((text.trim(), ""));
        match kind {
            "run" => return Ok(Some(value.trim().to_owned())),
            "long" => self.is_long = true,
            "needs" => self.needs = Some(value.trim().to_owned()),
            "not run" => {
                if value.trim().is_empty() {
                    return Err("`not run` needs a reason".to_owned());
                }
                self.is_not_run = true;
            }
            "output" | "file" | "change" | "example" | "picture" => {
                self.other = Some((kind.to_owned(), value.trim().to_owned()));
            }
            // Marks of generated parts of a page.
            _ => {}
        }
        Ok(None)
    }

    /// Block with an action.
    fn block(&self, line: usize, action: BlockAction) -> Block {
        Block { line, is_long: self.is_long, needs: self.needs.clone(), action }
    }

    /// Action of a block of this language; `None` where it is not run.
    fn action(&self, language: &str, text: String) -> Result<Option<BlockAction>, String> {
        let lines = |text: &str| text.lines().map(str::to_owned).collect();
        if self.is_not_run {
            return Ok(None);
        }
        let (kind, value) = self.other.clone().unwrap_or_default();
        Ok(Some(match (kind.as_str(), language) {
            ("output", _) => BlockAction::Output(lines(&text)),
            ("file", _) => BlockAction::File { name: value, content: text },
            ("change", "json") => {
                let (name, pointer) = value.split_once(' ').unwrap_or((&value, ""));
                BlockAction::Change { name: name.to_owned(), pointer: pointer.to_owned(), content: text }
            }
            ("example", _) => BlockAction::Example { file: value, content: text },
            ("", "sh") => BlockAction::Commands(lines(&text.replace("\\\n", " "))),
            ("", "python") => BlockAction::Python(text),
            ("", "rust" | "toml" | "text" | "") if has_command(&text) => {
                return Err("commands need a block of the language `sh`".to_owned());
            }
            // Doctests of the crate `colluvium` run the Rust of the README.
            ("", "rust" | "toml" | "text" | "") => return Ok(None),
            ("", _) => return Err(format!("a block of {language:?} needs a comment before it")),
            _ => return Err(format!("`{kind}` does not fit a block of {language:?}")),
        }))
    }
}

/// Whether a line of a block begins with a command of the program.
fn has_command(text: &str) -> bool {
    text.lines().any(|line| line.starts_with("colluvium ") && !line.starts_with("colluvium ="))
}

#[cfg(test)]
mod tests {
    use super::{BlockAction, blocks};

    #[test]
    fn blocks_have_the_actions_of_their_comments() {
        let page = "Text.\n\n```sh\ncolluvium new \\\nslope # a comment\n```\n\n<!-- output -->\n```text\nwrote …\n```\n\n\
            <!-- long -->\n<!-- change: slope.json /bodies/0 -->\n```json\n{ \"a\": 1 }\n```\n\n\
            <!-- not run: needs a network -->\n```sh\ncargo install x\n```\n\n<!-- picture: a/b.png -->\n![b](images/b.png)\n";
        let found = blocks(page).unwrap();
        assert_eq!(found.len(), 4, "{found:?}");
        assert_eq!(
            found[0].action,
            BlockAction::Commands(vec!["colluvium new  slope # a comment".to_owned()])
        );
        assert_eq!((found[1].line, found[1].is_long), (9, false));
        assert!(found[2].is_long);
        let pointer = |action: &BlockAction| match action {
            BlockAction::Change { pointer, .. } => Some(pointer.clone()),
            _ => None,
        };
        assert_eq!(pointer(&found[2].action).as_deref(), Some("/bodies/0"));
        let picture = BlockAction::Picture { shown: "images/b.png".to_owned(), made: "a/b.png".to_owned() };
        assert_eq!(found[3].action, picture);
    }

    #[test]
    fn blocks_that_nothing_would_run_are_errors() {
        assert!(blocks("```text\ncolluvium new slope\n```\n").unwrap_err().starts_with("line 1: commands"));
        assert!(blocks("```json\n{}\n```\n").unwrap_err().contains("needs a comment"));
        assert!(blocks("<!-- not run: -->\n```json\n{}\n```\n").is_err());
    }
}
