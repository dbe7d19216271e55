//! Material laws written in Python.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, PoisonError};

use colluvium::constitutive::driver::PATH_COLUMNS;
use colluvium::constitutive::{
    Corotational, InitialCondition, Law, Material, MaterialError, MaterialFactory, Motion, Point, PointLaw,
    SmallStrain, SymTensor, register_material,
};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use serde_json::{Map, Value};

use crate::errors::value_error;
use crate::law_errors::{has_first, is_testing, keep_exception, keep_first};

/// Names of laws and of their internal variables, which live as long as the program.
static NAMES: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());

/// Name that lives as long as the program; equal ones share their memory.
fn static_name(name: &str) -> &'static str {
    let mut known = NAMES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(own) = known.get(name) {
        return own;
    }
    let own = String::leak(name.to_owned());
    known.insert(own);
    own
}

/// Fields of points that every method has.
const FIELDS: [&str; 12] = [
    "id",
    "body",
    "position",
    "extent",
    "velocity",
    "displacement",
    "stress",
    "pressure",
    "deviatoric_stress",
    "mass",
    "volume",
    "density",
];

/// Law of a Python object with the attribute `state` and the methods `wave_modulus` and `update`.
struct PythonLaw {
    name: &'static str,
    object: Py<PyAny>,
    /// Names of the internal variables.
    names: Vec<&'static str>,
    /// Their initial values.
    start: Vec<f64>,
    /// Whether the law is that of an element test.
    is_tested: bool,
}

impl PythonLaw {
    /// Dictionary of the internal variables.
    fn state<'py>(&self, py: Python<'py>, values: &[f64]) -> PyResult<Bound<'py, PyDict>> {
        let state = PyDict::new(py);
        for (name, value) in self.names.iter().zip(values) {
            state.set_item(name, value)?;
        }
        Ok(state)
    }

    /// Stress and internal variables that `update` of the object returns.
    fn call_update(
        &self,
        py: Python<'_>,
        strain: &SymTensor,
        dt: f64,
        old: &Point<Vec<f64>>,
    ) -> PyResult<Point<Vec<f64>>> {
        let array = |tensor: &SymTensor| PyArray1::from_slice(py, &tensor.0);
        let arguments = (array(strain), array(&old.stress), self.state(py, &old.state)?, dt);
        let found = self.object.bind(py).call_method1("update", arguments)?;
        let problem = "update returns (stress, state): six numbers, and a mapping of the internal variables";
        let pair = found
            .cast::<PyTuple>()
            .ok()
            .filter(|pair| pair.len() == 2)
            .ok_or_else(|| value_error(&problem))?;
        let stress: [f64; 6] = pair.get_item(0)?.extract().map_err(|_| value_error(&problem))?;
        let state = pair.get_item(1)?;
        let value = |name: &&'static str| -> PyResult<f64> {
            let missing = |_| value_error(&format!("update returns a state without {name:?}"));
            state.get_item(*name).map_err(missing)?.extract()
        };
        let state = self.names.iter().map(value).collect::<PyResult<Vec<f64>>>()?;
        if !stress.iter().chain(&state).all(|number| number.is_finite()) {
            return Err(value_error(&"update returns numbers that are not finite"));
        }
        Ok(Point { stress: SymTensor(stress), state })
    }
}

impl Law for PythonLaw {
    fn name(&self) -> &'static str {
        self.name
    }

    fn is_time_dependent(&self) -> bool {
        true
    }

    fn is_hypoelastic(&self) -> bool {
        true
    }

    fn output_names(&self) -> &[&'static str] {
        &self.names
    }
}

impl PointLaw for PythonLaw {
    type State = Vec<f64>;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<Vec<f64>>, MaterialError> {
        Ok(Point { stress: initial.stress, state: self.start.clone() })
    }

    fn wave_modulus(&self, point: &Point<Vec<f64>>) -> f64 {
        let called = Python::attach(|py| -> PyResult<f64> {
            let arguments = (PyArray1::from_slice(py, &point.stress.0), self.state(py, &point.state)?);
            self.object.bind(py).call_method1("wave_modulus", arguments)?.extract()
        });
        // A step of zero length ends the run; the next update raises the exception again.
        called.unwrap_or(f64::NAN)
    }

    fn outputs(&self, point: &Point<Vec<f64>>, out: &mut [f64]) {
        out.copy_from_slice(&point.state);
    }
}

impl SmallStrain for PythonLaw {
    fn update(
        &self,
        strain: &SymTensor,
        motion: &Motion,
        old: &Point<Vec<f64>>,
    ) -> Result<Point<Vec<f64>>, MaterialError> {
        let failed = |reason: String| MaterialError::Update { law: self.name.to_owned(), reason };
        if self.is_tested && has_first() {
            return Err(failed("an exception has ended the test".to_owned()));
        }
        Python::attach(|py| self.call_update(py, strain, motion.dt, old)).map_err(|error| {
            if self.is_tested {
                let text = error.to_string();
                keep_first(error);
                return failed(text);
            }
            failed(keep_exception(error))
        })
    }

    fn max_strain_increment(&self) -> f64 {
        f64::INFINITY
    }
}

/// Factory of the laws of a Python class.
struct PythonFactory {
    name: &'static str,
    class: Py<PyAny>,
}

impl PythonFactory {
    /// Law of an object that the class makes from parameters.
    fn law(&self, py: Python<'_>, parameters: &Map<String, Value>) -> PyResult<PythonLaw> {
        let json = py.import("json")?;
        let text = Value::Object(parameters.clone()).to_string();
        let parameters = json.call_method1("loads", (text,))?.cast_into::<PyDict>()?;
        let object = self.class.bind(py).call((), Some(&parameters))?;
        for method in ["update", "wave_modulus"] {
            if !object.getattr(method).is_ok_and(|found| found.is_callable()) {
                return Err(value_error(&format!("the law {:?} has no method {method}", self.name)));
            }
        }
        let state: Vec<(String, f64)> = match object.getattr("state") {
            Ok(state) => state
                .call_method0("items")?
                .try_iter()?
                .map(|pair| pair?.extract())
                .collect::<PyResult<_>>()?,
            Err(_) => Vec::new(),
        };
        let checked = object.call_method1(
            "wave_modulus",
            (PyArray1::from_slice(py, &[0.0; 6]), state.iter().cloned().collect::<BTreeMap<_, _>>()),
        )?;
        let modulus: f64 = checked.extract()?;
        if !(modulus.is_finite() && modulus > 0.0) {
            return Err(value_error(&format!(
                "wave_modulus returns {modulus}: it must be a positive number (Pa)"
            )));
        }
        for (name, _) in &state {
            if PATH_COLUMNS.iter().any(|(column, _)| column == name) || FIELDS.contains(&name.as_str()) {
                return Err(value_error(&format!(
                    "state: {name:?} is a field or a column of all results: rename it"
                )));
            }
        }
        let names = state.iter().map(|(name, _)| static_name(name));
        Ok(PythonLaw {
            name: self.name,
            is_tested: is_testing(),
            names: names.collect(),
            start: state.iter().map(|(_, value)| *value).collect(),
            object: object.unbind(),
        })
    }
}

impl MaterialFactory for PythonFactory {
    fn name(&self) -> &'static str {
        self.name
    }

    fn build(&self, _: f64, parameters: &Map<String, Value>) -> Result<Arc<dyn Material>, MaterialError> {
        let law = Python::attach(|py| self.law(py, parameters)).map_err(|error| {
            MaterialError::IncompatibleOptions {
                model: "",
                field: String::new(),
                rule: keep_exception(error),
            }
        })?;
        Ok(Arc::new(Corotational(law)))
    }
}

/// Makes a class a law, which cases select by `{"model": "external", "law": name, "parameters": {...}}`. A later class of the name replaces
/// it.
#[pyfunction]
pub fn register_law(name: &str, class_: Py<PyAny>) {
    let name = static_name(name);
    register_material(Box::leak(Box::new(PythonFactory { name, class: class_ })));
}
