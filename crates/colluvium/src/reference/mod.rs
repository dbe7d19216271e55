//! Pages of the documentation made from the code: the reference of the case file, and the list of laws.

pub(crate) mod case_reference;
pub(crate) mod models_reference;
mod schema_types;
mod sections;
