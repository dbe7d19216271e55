//! Methods with typed options, and the typed solvers that they build.

use std::path::Path;
use std::sync::Arc;

use crate::description::MethodOptions;
use crate::simulation::Simulation;
use crate::solver::{Method, Solver};
use crate::{Case, CaseError, CaseErrors};

/// Method whose solvers have a type of their own in each dimension.
pub trait TypedMethod: Method + Default {
    /// Options of the method.
    type Options: MethodOptions;
    /// Solver in `D` dimensions.
    type Solver<const D: usize>: Solver;

    /// Solver of a case of `D` dimensions whose features the method supports, before the first stage.
    ///
    /// # Errors
    /// See [`Method::build`].
    fn typed_solver<const D: usize>(&self, case: &Case) -> Result<Self::Solver<D>, CaseError>;
}

/// Method with its options.
#[derive(Clone, Debug)]
pub struct ConfiguredMethod<M: TypedMethod> {
    options: M::Options,
}

impl<M: TypedMethod> ConfiguredMethod<M> {
    /// Method with options.
    pub fn new(options: M::Options) -> Self {
        Self { options }
    }

    /// Options of the method.
    pub fn options(&self) -> &M::Options {
        &self.options
    }

    /// Solver of a case at the start of its first stage. The case is checked as its file would be, with these options in place of those
    /// that it has for the method. Names of files are relative to the current folder.
    ///
    /// # Errors
    /// All errors of the case, each with its path in a case file; the first part that the method does not support; a case that has not `D`
    /// dimensions.
    pub fn solver<const D: usize>(&self, case: &Case) -> Result<Simulation<M::Solver<D>>, CaseErrors> {
        let case = case.clone().method(&self.options).checked(Path::new(""))?;
        let refuse = |path: String, problem: String| CaseErrors::from_error(CaseError::new(path, problem));
        if case.dimension() != D {
            let problem = format!("has {} dimensions, and a solver of {D} was requested", case.dimension());
            return Err(refuse("space".to_owned(), problem));
        }
        if let Some(number) = case.stages.iter().position(|stage| stage.weakening.is_some()) {
            let problem = "is available in a run only, not in a solver that a program steps";
            return Err(refuse(format!("stages[{number}].weakening"), problem.to_owned()));
        }
        let method = M::default();
        let build = || {
            let notes = method.capabilities(&case)?.check(&case)?;
            Ok((method.typed_solver::<D>(&case)?, notes))
        };
        let (solver, notes) = build().map_err(CaseErrors::from_error)?;
        Simulation::new(Arc::new(case), solver, notes)
    }
}
