//! Methods with typed options, and the typed solvers that they build.

use std::path::Path;
use std::sync::Arc;

use crate::description::MethodOptions;
use crate::simulation::Simulation;
use crate::solver::{Method, Solver};
use crate::{Case, CaseError, CaseErrors};

/// Method with typed options.
pub trait ConfigurableMethod: Method + Default + 'static {
    /// Options of the method.
    type Options: MethodOptions;

    /// Method, for runs that outlive their caller.
    fn instance() -> &'static Self;

    /// Number of space dimensions of a solver of the case: those of the plan in depth-integrated methods.
    fn dimension(&self, case: &Case) -> usize {
        case.dimension()
    }
}

/// Method with a type of solver for `D` dimensions.
pub trait TypedMethod<const D: usize>: ConfigurableMethod {
    /// Solver in `D` dimensions.
    type Solver: Solver;

    /// Solver of a case of `D` dimensions whose features the method supports, before the first stage.
    ///
    /// # Errors
    /// See [`Method::build`].
    fn typed_solver(&self, case: &Case) -> Result<Self::Solver, CaseError>;

    /// Solver as a trait object. Through it the steps are compiled in the crate of the method, and not again in that of the program.
    fn as_solver(solver: &Self::Solver) -> &dyn Solver;

    /// Solver as a trait object that can be changed.
    fn as_solver_mut(solver: &mut Self::Solver) -> &mut dyn Solver;
}

/// Implements [`TypedMethod`] in each dimension of a method, by a function that builds the solver of a case.
#[macro_export]
macro_rules! typed_method {
    ($method:ty, $build:path, $($dimension:literal => $solver:ty),+) => {$(
        impl $crate::TypedMethod<$dimension> for $method {
            type Solver = $solver;

            fn typed_solver(&self, case: &$crate::Case) -> Result<$solver, $crate::CaseError> {
                $build(case)
            }

            fn as_solver(solver: &$solver) -> &dyn $crate::Solver {
                solver
            }

            fn as_solver_mut(solver: &mut $solver) -> &mut dyn $crate::Solver {
                solver
            }
        }
    )+};
}

/// Method with its options.
#[derive(Clone, Debug)]
pub struct ConfiguredMethod<M: ConfigurableMethod> {
    method: M,
    options: M::Options,
}

impl<M: ConfigurableMethod> ConfiguredMethod<M> {
    /// Method with options.
    pub fn new(options: M::Options) -> Self {
        Self { method: M::default(), options }
    }

    /// Method.
    pub fn method(&self) -> &M {
        &self.method
    }

    /// Options of the method.
    pub fn options(&self) -> &M::Options {
        &self.options
    }

    /// Case with the options of the method, checked as its file would be.
    pub(crate) fn checked_case(&self, case: &Case) -> Result<Case, CaseErrors> {
        case.clone().method(&self.options).checked(Path::new(""))
    }

    /// Solver of a case at the start of its first stage. The case is checked as its file would be, with these options in place of those
    /// that it has for the method. Names of files are relative to the current folder.
    ///
    /// # Errors
    /// All errors of the case, each with its path in a case file; the first part that the method does not support; a case that has not `D`
    /// dimensions.
    pub fn solver<const D: usize>(&self, case: &Case) -> Result<Simulation<M::Solver>, CaseErrors>
    where
        M: TypedMethod<D>,
    {
        let (method, case) = (&self.method, self.checked_case(case)?);
        let refuse = |path: String, problem: String| CaseErrors::from_error(CaseError::new(path, problem));
        let dimension = method.dimension(&case);
        if dimension != D {
            let problem = format!("gives a solver of {dimension} dimensions, and one of {D} was requested");
            return Err(refuse("space".to_owned(), problem));
        }
        if let Some(number) = case.stages.iter().position(|stage| stage.weakening.is_some()) {
            let problem = "is available in a run only, not in a solver that a program steps";
            return Err(refuse(format!("stages[{number}].weakening"), problem.to_owned()));
        }
        let build = || {
            let notes = method.capabilities(&case)?.check(&case)?;
            Ok((TypedMethod::<D>::typed_solver(method, &case)?, notes))
        };
        let (solver, notes) = build().map_err(CaseErrors::from_error)?;
        Simulation::new(Arc::new(case), solver, (M::as_solver, M::as_solver_mut), notes)
    }
}
