//! Starting files that `colluvium new` writes: cases by topic, an element test, a sweep and a fit, with the files that they name.

pub(crate) mod debris_flow;

/// Contents of a template.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TemplateKind {
    /// Case, for `colluvium run`.
    Case,
    /// Element test, for `colluvium element-test`.
    ElementTest,
    /// Element test of a foreign routine in C, which the user compiles first.
    ForeignLaw,
    /// Sweep of another template, for `colluvium sweep`.
    Sweep,
    /// Fit of a material to tests, for `colluvium fit`.
    Fit,
}

/// Starting file of a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Template {
    /// Name, also that of the file.
    pub name: &'static str,
    /// Topic under which it is listed.
    pub topic: &'static str,
    /// Line that describes it.
    pub summary: &'static str,
    /// Contents.
    pub kind: TemplateKind,
    /// JSON text.
    pub text: &'static str,
    /// Names of the files that it needs beside it.
    pub files: &'static [&'static str],
}

/// Case of a template that needs no other file.
const fn case(
    name: &'static str,
    topic: &'static str,
    summary: &'static str,
    text: &'static str,
) -> Template {
    Template { name, topic, summary, kind: TemplateKind::Case, text, files: &[] }
}

/// Topics, in the order of the list.
const SOIL: &str = "Soil and slopes";
const LIQUIDS: &str = "Liquids";
const FLOWS: &str = "Flows over terrain";
const GRAINS: &str = "Grains";
const SNOW: &str = "Snow";
const STUDIES: &str = "Tests and studies";

/// All templates, by topic.
pub const TEMPLATES: &[Template] = &[
    case(
        "column-collapse",
        SOIL,
        "collapse of a column of dry sand; MPM",
        include_str!("soil/column-collapse.json"),
    ),
    case(
        "oedometer",
        SOIL,
        "elastic column that settles under its own weight to rest; MPM",
        include_str!("soil/oedometer.json"),
    ),
    case(
        "terzaghi",
        SOIL,
        "consolidation of a saturated layer under a load; MPM with pore water",
        include_str!("soil/terzaghi.json"),
    ),
    case(
        "footing",
        SOIL,
        "limit load of a strip footing on undrained clay; MPM",
        include_str!("soil/footing.json"),
    ),
    case(
        "slope",
        SOIL,
        "slope of weak soil that fails when a gate is removed; MPM",
        include_str!("soil/slope.json"),
    ),
    case(
        "factor-of-safety",
        SOIL,
        "factor of safety of a slope by strength reduction; SPH",
        include_str!("soil/factor-of-safety.json"),
    ),
    case("disks", SOIL, "collision of two elastic disks; MPM", include_str!("soil/disks.json")),
    case(
        "dam-break",
        LIQUIDS,
        "water that runs onto a wall, with the force on it; MPM and SPH",
        include_str!("liquids/dam-break.json"),
    ),
    case(
        "heap-on-plane",
        FLOWS,
        "heap of debris on an inclined plane; depth-integrated SPH",
        include_str!("flows/heap-on-plane.json"),
    ),
    Template {
        name: debris_flow::NAME,
        topic: FLOWS,
        summary: "debris flow on a terrain raster from a release area, with hazard rasters; depth-integrated SPH",
        kind: TemplateKind::Case,
        text: include_str!("flows/debris-flow.json"),
        files: &[debris_flow::TERRAIN_FILE, debris_flow::RELEASE_FILE.0],
    },
    Template {
        name: "landslide",
        topic: FLOWS,
        summary: "landslide on a terrain raster; MPM, SPH, DEM and depth-integrated SPH",
        kind: TemplateKind::Case,
        text: include_str!("flows/landslide.json"),
        files: &["landslide-terrain.asc", "landslide-release.geojson"],
    },
    case(
        "two-grains",
        GRAINS,
        "disk that falls on another and rolls off it; DEM",
        include_str!("grains/two-grains.json"),
    ),
    case(
        "biaxial",
        GRAINS,
        "biaxial compression of disks in a periodic cell; DEM",
        include_str!("grains/biaxial.json"),
    ),
    case(
        "angle-of-repose",
        GRAINS,
        "heap of disks behind a gate that is removed; DEM",
        include_str!("grains/angle-of-repose.json"),
    ),
    case(
        "triaxial-sleeve",
        GRAINS,
        "triaxial compression of sand in a flexible sleeve; DEM",
        include_str!("grains/triaxial-sleeve.json"),
    ),
    case("snowball", SNOW, "snowball that hits a floor; snow MPM", include_str!("snow/snowball.json")),
    case(
        "saw-test",
        SNOW,
        "propagation saw test of a slab on a weak layer; snow MPM",
        include_str!("snow/saw-test.json"),
    ),
    case(
        "remote-triggering",
        SNOW,
        "load on the flat that releases the slab on a slope; snow MPM",
        include_str!("snow/remote-triggering.json"),
    ),
    Template {
        name: "element-test",
        topic: STUDIES,
        summary: "drained triaxial test of a law: colluvium element-test element-test.json",
        kind: TemplateKind::ElementTest,
        text: include_str!("studies/element-test.json"),
        files: &[],
    },
    Template {
        name: "umat",
        topic: STUDIES,
        summary: "routine of Abaqus in C, and an element test of it",
        kind: TemplateKind::ForeignLaw,
        text: include_str!("studies/umat.json"),
        files: &["soil.c"],
    },
    Template {
        name: "sweep",
        topic: STUDIES,
        summary: "run-out of column-collapse over two parameters: colluvium sweep sweep.json",
        kind: TemplateKind::Sweep,
        text: include_str!("studies/sweep.json"),
        files: &["column-collapse.json"],
    },
    Template {
        name: "fit",
        topic: STUDIES,
        summary: "parameters of a law from two drained triaxial tests: colluvium fit fit.json",
        kind: TemplateKind::Fit,
        text: include_str!("studies/fit.json"),
        files: &["cd100.csv", "cd300.csv"],
    },
];

/// Names and texts of the files beside templates that are not computed.
const TEXT_FILES: [(&str, &str); 6] = [
    debris_flow::RELEASE_FILE,
    ("landslide-terrain.asc", include_str!("flows/landslide-terrain.asc")),
    ("landslide-release.geojson", include_str!("flows/landslide-release.geojson")),
    ("cd100.csv", include_str!("studies/cd100.csv")),
    ("cd300.csv", include_str!("studies/cd300.csv")),
    ("soil.c", include_str!("studies/soil.c")),
];

impl Template {
    /// Template of a name; `None` if there is none.
    pub fn find(name: &str) -> Option<&'static Self> {
        TEMPLATES.iter().find(|template| template.name == name)
    }

    /// Picture of its result in the repository, which a command of `docs/gallery.md` makes.
    pub fn picture(&self) -> String {
        format!("docs/images/gallery/{}.png", self.name)
    }

    /// Text of a file of [`Template::files`]; `None` for one that is computed.
    pub(crate) fn text_of_file(file: &str) -> Option<&'static str> {
        let case = || Self::find(file.strip_suffix(".json")?).map(|template| template.text);
        TEXT_FILES.iter().find(|(name, _)| *name == file).map(|(_, text)| *text).or_else(case)
    }
}
