//! Pages of the documentation made from the code: the case file reference and the table of laws.

pub(crate) mod case_reference;
pub(crate) mod models_reference;
