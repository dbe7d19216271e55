//! Frames as VTK XML files: the arrays, their encoding, and the collection.

pub(crate) mod encoding;
pub(crate) mod frames;
pub(crate) mod xml;
