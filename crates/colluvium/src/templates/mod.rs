//! Starting cases that `colluvium new` writes, as JSON files, and the generated terrain of one.

pub(crate) mod debris_flow;
