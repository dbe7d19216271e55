//! Bed of a case: terrain, zones of strength, dams, and heights of steep faces.

pub(crate) mod bed_zones;
pub(crate) mod case_bed;
pub(crate) mod dams;
pub(crate) mod face_heights;
pub(crate) mod terrain_holes;
