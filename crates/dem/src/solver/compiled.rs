//! Functions of the solver that are compiled with this crate only.
//!
//! A crate that calls a generic function compiles it again, with all that it calls. The solver is generic over the dimension. Its
//! long functions are therefore pointers, which are set where a solver is made; the public functions call these.

use std::io::{self, Read, Write};

use colluvium_case::measure::Reading;
use colluvium_case::{Advance, Budget, Frame, SolverError, Wanted};

use super::DemSolver;
use crate::contact::{Contact, Met};

/// The long functions of a solver.
#[derive(Clone, Copy)]
pub struct Compiled<const D: usize, const R: usize> {
    pub step: fn(&mut DemSolver<D, R>, f64) -> Result<Advance, SolverError>,
    pub enter_stage: fn(&mut DemSolver<D, R>, bool) -> Result<(), SolverError>,
    pub contacts: fn(&DemSolver<D, R>) -> Vec<Contact<D>>,
    pub met: fn(&DemSolver<D, R>) -> Met<D>,
    pub chains: fn(&DemSolver<D, R>) -> Vec<Vec<usize>>,
    pub readings: fn(&DemSolver<D, R>) -> Vec<Reading>,
    pub frame: fn(&DemSolver<D, R>, Wanted) -> Frame,
    pub budget: fn(&DemSolver<D, R>) -> Budget,
    pub stored: fn(&DemSolver<D, R>) -> String,
    pub write: fn(&DemSolver<D, R>, &mut dyn Write) -> io::Result<()>,
    pub read: fn(&mut DemSolver<D, R>, &mut dyn Read) -> io::Result<()>,
}

impl<const D: usize, const R: usize> Compiled<D, R> {
    /// Those of this crate. The crate that names them compiles them.
    pub const HERE: Self = Self {
        step: DemSolver::take_step,
        enter_stage: DemSolver::enter_stage,
        contacts: DemSolver::take_contact_list,
        met: DemSolver::take_met,
        chains: DemSolver::take_chains,
        readings: DemSolver::take_readings,
        frame: DemSolver::take_frame,
        budget: DemSolver::take_budget,
        stored: DemSolver::stored,
        write: DemSolver::write,
        read: DemSolver::read,
    };
}
