//! Colluvium: point-based numerical methods for geomechanics.
//!
//! This crate joins the others and contains the command line. A [`case::Case`] describes a problem once; a [`case::Method`] turns it into a
//! [`case::Solver`]; [`case::run_method()`] runs it.
//!
//! ```
//! use colluvium::case::{Case, Method, RunOptions, run};
//!
//! let case = Case::from_json(colluvium::template("column-collapse").unwrap())?;
//! let method = colluvium::method("mpm").unwrap();
//! let plan = method.plan(&case)?;
//! assert!(plan.points > 1000);
//!
//! # let mut case = case;
//! # case.stages[0].duration = 0.01;
//! let report = run(&case, method.build(&case)?, &RunOptions::default())?;
//! println!("run-out {:?}", report.table.last("run_out"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Library users disable the default feature `cli`, which brings the command line. Each method is a feature of its name (`mpm`, `sph`,
//! `dem`, `depth-sph`, `snow-mpm`), and `methods` brings all; `reports` brings pictures and reports of runs, sweeps and fits.

#[cfg(feature = "cli")]
pub mod cli;
#[cfg(feature = "reports")]
pub mod compare;
#[cfg(feature = "reports")]
pub mod fit;
#[cfg(feature = "cli")]
pub mod machine;
mod method_choice;
#[cfg(feature = "reports")]
pub mod output;
#[cfg(feature = "reports")]
mod parallel_runs;
mod reference;
#[cfg(feature = "reports")]
pub mod report;
#[cfg(feature = "reports")]
pub mod run_progress;
#[cfg(feature = "reports")]
pub mod sweep;
mod templates;

pub use colluvium_case as case;
pub use colluvium_constitutive as constitutive;
#[cfg(feature = "dem")]
pub use colluvium_dem as dem;
#[cfg(feature = "depth-sph")]
pub use colluvium_depth_sph as depth_sph;
pub use colluvium_grid as grid;
#[cfg(feature = "mpm")]
pub use colluvium_mpm as mpm;
#[cfg(feature = "reports")]
pub use colluvium_plots as plots;
pub use colluvium_points as points;
#[cfg(feature = "snow-mpm")]
pub use colluvium_snow_mpm as snow_mpm;
#[cfg(feature = "sph")]
pub use colluvium_sph as sph;
pub use colluvium_terrain as terrain;

pub use crate::method_choice::{MethodChoiceError, select_method};
pub use crate::reference::case_reference::case_reference;

use case::{Case, CaseError, CaseErrors, Method};
use constitutive::driver::{DriverError, ElementTest};
use serde_json::Value;

use crate::templates::debris_flow;
pub use crate::templates::{TEMPLATES, Template, TemplateKind};

/// Commit from which the program was built; `None` without git.
pub const COMMIT: Option<&str> = option_env!("COLLUVIUM_COMMIT");

/// Registers the materials of the methods for case files; [`methods`] and [`element_test`] do so as well.
pub fn register_materials() {
    #[cfg(feature = "dem")]
    constitutive::register_material(&dem::material::GranularCells);
}

/// All methods of this build, by the features of this crate.
pub fn methods() -> &'static [&'static dyn Method] {
    register_materials();
    &[
        #[cfg(feature = "mpm")]
        &mpm::Mpm,
        #[cfg(feature = "sph")]
        &sph::Sph,
        #[cfg(feature = "dem")]
        &dem::Dem,
        #[cfg(feature = "depth-sph")]
        &depth_sph::DepthSph,
        #[cfg(feature = "snow-mpm")]
        &snow_mpm::SnowMpm,
    ]
}

/// Returns the method called `name`.
pub fn method(name: &str) -> Option<&'static dyn Method> {
    methods().iter().copied().find(|method| method.name() == name)
}

/// JSON Schema of a case file, with the options of all methods.
pub fn case_schema() -> Value {
    let options: Vec<_> = methods().iter().map(|method| (method.name(), method.options_schema())).collect();
    Case::schema(&options)
}

/// Reads an element test from the text of its file.
///
/// ```
/// let text = r#"{
///     "title": "oedometer",
///     "material": { "model": "linear-elastic", "density": 2000, "youngs_modulus": 2e7, "poissons_ratio": 0.3 },
///     "stages": [{ "path": { "kind": "oedometer", "axial_compression": 0.01 }, "steps": 10 }]
/// }"#;
/// let path = colluvium::element_test(text)?.run()?;
/// assert!((path.last("stress_zz") / -269_230.769 - 1.0).abs() < 1e-8);
///
/// let error = colluvium::element_test(&text.replace("0.3", "0.7")).unwrap_err();
/// assert!(error.to_string().starts_with("material.poissons_ratio: 0.7 "));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// All errors of the file, each with its JSON path.
pub fn element_test(text: &str) -> Result<ElementTest, CaseErrors> {
    check_element_test(case::files::json::read(text)?)
}

/// Reads an element test from a file.
///
/// # Errors
/// As [`element_test`], with the file for errors of syntax, and when the file cannot be read.
pub fn load_element_test(file: &std::path::Path) -> Result<ElementTest, CaseErrors> {
    check_element_test(case::files::json::read_file(file)?)
}

/// Checks an element test, with errors in the form of those of a case.
fn check_element_test(test: ElementTest) -> Result<ElementTest, CaseErrors> {
    register_materials();
    match test.validate() {
        Ok(()) => Ok(test),
        Err(DriverError::Invalid(problems)) => {
            Err(CaseErrors(problems.into_iter().map(|p| CaseError::new(p.path, p.problem)).collect()))
        }
        Err(other) => Err(CaseErrors::from_error(CaseError::new("stages", other.to_string()))),
    }
}

/// Names of the templates of cases.
pub fn template_names() -> Vec<&'static str> {
    let cases = TEMPLATES.iter().filter(|template| template.kind == TemplateKind::Case);
    cases.map(|template| template.name).collect()
}

/// JSON text of the template called `name`.
pub fn template(name: &str) -> Option<&'static str> {
    Template::find(name).map(|template| template.text)
}

/// Names of the files that the template called `name` needs beside it.
pub fn template_files(name: &str) -> Vec<&'static str> {
    Template::find(name).map_or(Vec::new(), |template| template.files.to_vec())
}

/// Writes the files that the template called `name` needs into a folder.
///
/// # Errors
/// When a file cannot be written.
pub fn write_template_files(name: &str, folder: &std::path::Path) -> Result<(), case::output::OutputError> {
    use case::output::{OutputError, write_atomically};
    for file in template_files(name) {
        let path = folder.join(file);
        if file == debris_flow::TERRAIN_FILE {
            terrain::write_raster(&path, &debris_flow::terrain())
                .map_err(|error| OutputError::new(&path, error.problem))?;
        } else {
            let text = Template::text_of_file(file)
                .ok_or_else(|| OutputError::new(&path, "is not a file of a template"))?;
            write_atomically(&path, text.as_bytes())?;
        }
    }
    Ok(())
}

/// Page `README.md`, whose examples are tests of the documentation.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
