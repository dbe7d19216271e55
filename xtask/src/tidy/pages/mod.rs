//! Rules for the pages of the documentation: links and sentences.

pub(super) mod links;
pub(super) mod sentences;
