//! Colluvium: point-based numerical methods for geomechanics.
//!
//! This crate gathers the others and holds the command line. A [`case::Case`] describes a problem
//! once; a [`case::Method`] turns it into a [`case::Solver`]; [`case::run()`] runs it.
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

pub use colluvium_case as case;
pub use colluvium_constitutive as constitutive;
pub use colluvium_grid as grid;
pub use colluvium_mpm as mpm;
pub use colluvium_points as points;

mod reference;

pub use reference::case_reference;

use case::{Case, Method};
use serde_json::Value;

/// All methods.
pub fn methods() -> &'static [&'static dyn Method] {
    &[&mpm::Mpm]
}

/// The method called `name`.
pub fn method(name: &str) -> Option<&'static dyn Method> {
    methods().iter().copied().find(|method| method.name() == name)
}

/// JSON Schema of a case file, with the options of all methods.
pub fn case_schema() -> Value {
    let options: Vec<_> = methods().iter().map(|method| (method.name(), method.options_schema())).collect();
    Case::schema(&options)
}

/// Starting cases: name and JSON text.
pub const TEMPLATES: [(&str, &str); 4] = [
    ("column-collapse", include_str!("templates/column-collapse.json")),
    ("oedometer", include_str!("templates/oedometer.json")),
    ("disks", include_str!("templates/disks.json")),
    ("slope", include_str!("templates/slope.json")),
];

/// The starting case called `name`.
pub fn template(name: &str) -> Option<&'static str> {
    TEMPLATES.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
