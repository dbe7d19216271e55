//! Descriptions of map projections: PROJ strings, well-known text, and `.prj` files.

pub(crate) mod map_projection;
pub(crate) mod prj_file;
pub(crate) mod proj_string;
pub(crate) mod well_known_text;
