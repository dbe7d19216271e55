//! Sections of the reference of the case file: keys, those that most cases use, and introduction of each page.

/// Keys that a section describes.
pub(crate) enum SectionKeys {
    /// Keys at the top of a case.
    OfCase(&'static [&'static str]),
    /// Options of a method.
    Method(&'static str),
}

/// Section of the reference, a page.
pub(crate) struct Section {
    /// Name of the page without its extension.
    pub page: &'static str,
    /// Title of the page.
    pub title: &'static str,
    /// Keys that the page describes.
    pub keys: SectionKeys,
    /// Keys that most cases use, in the order of the page.
    pub common: &'static [&'static str],
    /// Introduction in Markdown, with a working snippet of a case: the contents of an object.
    pub introduction: &'static str,
}

impl Section {
    /// Path of the keys of the section.
    pub fn path(&self) -> String {
        match self.keys {
            SectionKeys::OfCase(_) => String::new(),
            SectionKeys::Method(name) => format!("methods.{name}"),
        }
    }
}

/// Pages of the reference, in their order.
pub(crate) const SECTIONS: &[Section] = &[
    Section {
        page: "domain",
        title: "Space, domain and gravity",
        keys: SectionKeys::OfCase(&["space", "domain", "gravity", "title", "notes", "$schema"]),
        common: &["title", "space", "domain", "gravity"],
        introduction: include_str!("domain.md"),
    },
    Section {
        page: "bodies",
        title: "Bodies",
        keys: SectionKeys::OfCase(&["bodies"]),
        common: &["bodies"],
        introduction: include_str!("bodies.md"),
    },
    Section {
        page: "materials",
        title: "Materials",
        keys: SectionKeys::OfCase(&["materials"]),
        common: &["materials"],
        introduction: include_str!("materials.md"),
    },
    Section {
        page: "boundaries",
        title: "Walls",
        keys: SectionKeys::OfCase(&["boundaries"]),
        common: &["boundaries"],
        introduction: include_str!("boundaries.md"),
    },
    Section {
        page: "obstacles",
        title: "Obstacles and terrain",
        keys: SectionKeys::OfCase(&["obstacles"]),
        common: &["obstacles"],
        introduction: include_str!("obstacles.md"),
    },
    Section {
        page: "loads",
        title: "Loads, patches and cuts",
        keys: SectionKeys::OfCase(&["loads", "patches", "removal_shapes"]),
        common: &["loads", "patches", "removal_shapes"],
        introduction: include_str!("loads.md"),
    },
    Section {
        page: "stages",
        title: "Stages",
        keys: SectionKeys::OfCase(&["stages"]),
        common: &["stages"],
        introduction: include_str!("stages.md"),
    },
    Section {
        page: "measures",
        title: "Measures",
        keys: SectionKeys::OfCase(&["measures"]),
        common: &["measures"],
        introduction: include_str!("measures.md"),
    },
    Section {
        page: "output",
        title: "Output",
        keys: SectionKeys::OfCase(&["output"]),
        common: &["output"],
        introduction: include_str!("output.md"),
    },
    Section {
        page: "mpm",
        title: "Options of MPM",
        keys: SectionKeys::Method("mpm"),
        common: &["cell_size", "points_per_cell", "shape", "volumetric_strain", "transfer", "contacts"],
        introduction: include_str!("methods/mpm.md"),
    },
    Section {
        page: "sph",
        title: "Options of SPH",
        keys: SectionKeys::Method("sph"),
        common: &["spacing", "kernel", "smoothing", "viscosity_linear", "density_diffusion", "tensile"],
        introduction: include_str!("methods/sph.md"),
    },
    Section {
        page: "snow-mpm",
        title: "Options of snow MPM",
        keys: SectionKeys::Method("snow-mpm"),
        common: &["cell_size", "points_per_cell", "shape", "transfer", "flip_ratio", "courant_elastic"],
        introduction: include_str!("methods/snow-mpm.md"),
    },
    Section {
        page: "dem",
        title: "Options of DEM",
        keys: SectionKeys::Method("dem"),
        common: &["grains", "pairs", "bodies", "stages", "step_fraction", "seed"],
        introduction: include_str!("methods/dem.md"),
    },
    Section {
        page: "depth-sph",
        title: "Options of depth-integrated SPH",
        keys: SectionKeys::Method("depth-sph"),
        common: &["spacing", "basal", "phases", "column", "erosion", "inflows"],
        introduction: include_str!("methods/depth-sph.md"),
    },
];
