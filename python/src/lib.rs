//! Native part of the Python package `colluvium`.
//!
//! Cases cross the border as JSON text, arrays as memory of a frame without a copy. The convenient part is in the Python modules beside
//! this crate.

mod cases;
mod channel;
mod compare;
mod element_tests;
mod errors;
mod frames;
mod law_errors;
mod laws;
mod pages;
mod pool;
mod runs;
mod sweeps;
mod tables;
mod tasks;

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the command line with its arguments, the first of which is the name of the program, and returns the exit code.
#[pyfunction]
fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| colluvium::cli::exit_code(arguments))
}

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    colluvium::register_materials();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<compare::CompareData>()?;
    module.add_class::<frames::DatasetData>()?;
    module.add_class::<frames::FrameData>()?;
    module.add_class::<frames::RasterData>()?;
    module.add_class::<pages::RecordedData>()?;
    module.add_class::<runs::RunData>()?;
    module.add_class::<sweeps::SweepData>()?;
    module.add_class::<tasks::Task>()?;
    module.add_function(wrap_pyfunction!(main, module)?)?;
    module.add_function(wrap_pyfunction!(cases::case_warnings, module)?)?;
    module.add_function(wrap_pyfunction!(cases::check, module)?)?;
    module.add_function(wrap_pyfunction!(cases::methods, module)?)?;
    module.add_function(wrap_pyfunction!(cases::outlines, module)?)?;
    module.add_function(wrap_pyfunction!(cases::plan, module)?)?;
    module.add_function(wrap_pyfunction!(cases::schema, module)?)?;
    module.add_function(wrap_pyfunction!(cases::template, module)?)?;
    module.add_function(wrap_pyfunction!(cases::template_files, module)?)?;
    module.add_function(wrap_pyfunction!(cases::templates, module)?)?;
    module.add_function(wrap_pyfunction!(cases::write_template_files, module)?)?;
    module.add_function(wrap_pyfunction!(element_tests::check_element_test, module)?)?;
    module.add_function(wrap_pyfunction!(element_tests::run_element_test, module)?)?;
    module.add_function(wrap_pyfunction!(laws::register_law, module)?)?;
    module.add_function(wrap_pyfunction!(pages::draw_map, module)?)?;
    module.add_function(wrap_pyfunction!(pages::open_run, module)?)?;
    module.add_function(wrap_pyfunction!(pages::raster_label, module)?)?;
    module.add_function(wrap_pyfunction!(pages::read_raster, module)?)?;
    module.add_function(wrap_pyfunction!(pages::write_raster, module)?)?;
    module.add_function(wrap_pyfunction!(pages::write_report, module)?)?;
    Ok(())
}
