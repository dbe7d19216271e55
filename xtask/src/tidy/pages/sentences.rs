//! Lengths of the sentences of the documentation.

use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};

use crate::tidy::RuleViolation;
use crate::tidy::source_tree::{SourceFile, SourceTree};

/// Largest number of words of a sentence.
const MAX_WORDS: usize = 35;

/// Largest mean number of words of the sentences of a page.
const MAX_MEAN_WORDS: f64 = 20.0;

/// Abbreviations whose full stop does not end a sentence, also before a capital letter.
const ABBREVIATIONS: [&str; 8] = ["e.g.", "i.e.", "al.", "cf.", "Fig.", "Eq.", "No.", "vs."];

/// Sentence of a page.
#[derive(Debug, PartialEq, Eq)]
struct Sentence {
    /// Line of its paragraph, from one.
    line: usize,
    /// First words.
    beginning: String,
    /// Number of words.
    words: usize,
}

/// Violations by sentences that are too long, and by pages with too long ones in the mean. Specification sheets, which quote
/// sources, are left out.
pub fn long_sentences(tree: &SourceTree) -> Vec<RuleViolation> {
    let is_prose = |page: &&SourceFile| {
        let is_page = page.path.starts_with("docs/") || page.path == "README.md";
        is_page && !page.path.starts_with("docs/sheets/")
    };
    let mut findings = Vec::new();
    for page in tree.pages().filter(is_prose) {
        let sentences = sentences(&page.text);
        for sentence in sentences.iter().filter(|sentence| sentence.words > MAX_WORDS) {
            let message = format!("{} words: {} …", sentence.words, sentence.beginning);
            findings.push(RuleViolation::new("long sentence", &page.path, sentence.line, message));
        }
        let words: usize = sentences.iter().map(|sentence| sentence.words).sum();
        let mean = words as f64 / sentences.len().max(1) as f64;
        if mean > MAX_MEAN_WORDS {
            let message =
                format!("its sentences have {mean:.1} words in the mean, more than {MAX_MEAN_WORDS}");
            findings.push(RuleViolation::new("long sentences in the mean", &page.path, 0, message));
        }
    }
    findings
}

/// Sentences of the paragraphs and list entries of a page, without tables, headings, code and formulas.
fn sentences(page: &str) -> Vec<Sentence> {
    let options = Options::ENABLE_TABLES | Options::ENABLE_MATH | Options::ENABLE_FOOTNOTES;
    let mut found = Vec::new();
    let (mut text, mut line, mut ignored) = (String::new(), 0, 0_u32);
    for (event, range) in Parser::new_ext(page, options).into_offset_iter() {
        match event {
            Event::Start(Tag::CodeBlock(_) | Tag::Table(_) | Tag::Heading { .. } | Tag::Image { .. }) => {
                ignored += 1;
            }
            Event::End(TagEnd::CodeBlock | TagEnd::Table | TagEnd::Heading(_) | TagEnd::Image) => {
                ignored -= 1;
            }
            // Lists without blank lines have entries without paragraphs.
            Event::Start(Tag::Paragraph | Tag::Item | Tag::List(_))
            | Event::End(TagEnd::Item | TagEnd::Paragraph) => {
                found.extend(split_sentences(&std::mem::take(&mut text), line));
            }
            _ if ignored > 0 => {}
            Event::Text(words) => {
                if text.is_empty() {
                    line = page[..range.start].matches('\n').count() + 1;
                }
                text.push_str(&words);
            }
            // One word each.
            Event::Code(_) | Event::InlineMath(_) | Event::DisplayMath(_) => text.push_str("Symbol"),
            Event::SoftBreak | Event::HardBreak => text.push(' '),
            _ => {}
        }
    }
    found.extend(split_sentences(&text, line));
    found
}

/// Sentences of a paragraph that begins in a line: they end in `.`, `!` or `?` before a capital letter or the end.
fn split_sentences(paragraph: &str, line: usize) -> Vec<Sentence> {
    let words: Vec<&str> = paragraph.split_whitespace().collect();
    let begins = |word: &&&str| word.chars().find(|c| c.is_alphanumeric()).is_some_and(char::is_uppercase);
    let mut sentences = Vec::new();
    let mut own: Vec<&str> = Vec::new();
    for (number, word) in words.iter().enumerate() {
        own.push(word);
        let bare = word.trim_end_matches(['"', '”', ')', '*']);
        let is_end = bare.ends_with(['.', '!', '?']) && !ABBREVIATIONS.contains(&bare);
        let next = words.get(number + 1);
        if next.is_none() || (is_end && next.filter(begins).is_some()) {
            let count = own.iter().filter(|word| word.chars().any(char::is_alphanumeric)).count();
            let beginning = own[..own.len().min(6)].join(" ");
            sentences.push(Sentence { line, beginning, words: count });
            own.clear();
        }
    }
    sentences
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_are_those_of_paragraphs_and_list_entries() {
        let page = "# A heading of five words\n\nGrains fall (Lube et al. 2005) at $v_0$. They stop, e.g. on `sand`!\n\n\
                    - One entry\n- Another one. And more\n\n```text\nnot prose\n```\n\n| no | prose |\n|---|---|\n| in | it |\n";
        let found: Vec<(usize, usize)> = sentences(page).iter().map(|own| (own.line, own.words)).collect();
        assert_eq!(found, [(3, 8), (3, 5), (5, 2), (6, 2), (6, 2)]);
    }

    #[test]
    fn long_sentences_and_pages_are_found() {
        let long = "word ".repeat(36) + "\n";
        let short = "A word is here. ".repeat(30) + "\n";
        let tree = SourceTree::from_files(&[
            ("docs/a.md", &long),
            ("docs/b.md", &(short + &long)),
            ("docs/sheets/c.md", &long),
        ]);
        let found: Vec<String> =
            long_sentences(&tree).iter().map(|own| format!("{} {}", own.file, own.rule_name)).collect();
        assert_eq!(
            found,
            ["docs/a.md long sentence", "docs/a.md long sentences in the mean", "docs/b.md long sentence"]
        );
    }
}
