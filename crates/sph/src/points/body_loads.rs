//! Surface loads of bodies, applied to the particles near the surface (sheet: mpm §2.11; `colluvium_case::loads::load_vectors`).
//!
//! The force of a load is that of the case on the area next to a particle, independent of the kernel sums at the surface:
//! resultants are exact, and the load is smeared over the kernel of the outermost particles.

use std::sync::Arc;

use colluvium_case::{BodyForce, Case, CaseError};

/// Load of the case on the particles of a body.
#[derive(Clone)]
pub struct BodyLoad<const D: usize> {
    /// Index into `Case::loads`.
    pub number: usize,
    /// Index into `Case::bodies`.
    pub body: u32,
    /// Id of the first particle of the body; the ids of a body are consecutive.
    pub first: u32,
    /// Load vector of the particle of each id.
    pub vectors: Vec<[f64; D]>,
}

impl<const D: usize> BodyLoad<D> {
    /// Whether the load follows its surface, so that the load vectors change.
    pub fn is_follower(&self, case: &Case) -> bool {
        case.loads[self.number].is_follower()
    }
}

/// Body at the start, for the distribution of loads.
pub struct LoadedBody<'a, const D: usize> {
    /// Index into `Case::bodies`.
    pub body: u32,
    /// Whether the body has a prescribed motion.
    pub is_held: bool,
    /// Id of the first particle.
    pub first: u32,
    /// Positions of the particles (m).
    pub positions: &'a [[f64; D]],
}

/// All loads of a case with their bodies, and the body force of a program.
#[derive(Clone, Default)]
pub struct BodyLoads<const D: usize> {
    /// Loads on bodies.
    pub loads: Vec<BodyLoad<D>>,
    /// Start time of each load of the case (s).
    pub start_times: Vec<f64>,
    /// Body force of the program.
    pub body_force: Option<Arc<BodyForce<D>>>,
}

impl<const D: usize> BodyLoads<D> {
    /// Loads of a case on its bodies, for a particle spacing (m).
    ///
    /// # Errors
    /// When a load acts on a held body, or on nothing.
    pub fn new(case: &Case, bodies: &[LoadedBody<'_, D>], spacing: f64) -> Result<Self, CaseError> {
        let mut loads = Vec::new();
        for (number, load) in case.loads.iter().enumerate() {
            let on = |loaded: &&LoadedBody<'_, D>| case.bodies[loaded.body as usize].name == load.body();
            let Some(&LoadedBody { body, is_held, first, positions }) = bodies.iter().find(on) else {
                continue;
            };
            if is_held {
                let problem = format!("the body {:?} is held, and loads do not act on it", load.body());
                return Err(CaseError::new(format!("loads[{number}].body"), problem));
            }
            let carried = case.load_vectors(number, positions, &[spacing; D])?;
            loads.push(BodyLoad { number, body, first, vectors: carried });
        }
        Ok(Self { loads, start_times: case.load_starts(), body_force: None })
    }

    /// Begins the loads of a stage that starts at `start` (s).
    pub fn begin_stage(&mut self, case: &Case, stage: usize, start: f64) {
        case.begin_loads(&mut self.start_times, stage, start);
    }

    /// State of the loads for a checkpoint: start times, and vectors of follower loads.
    pub fn checkpoint_state(&self) -> (Vec<f64>, Vec<Vec<f64>>) {
        (self.start_times.clone(), self.loads.iter().map(|on| on.vectors.as_flattened().to_vec()).collect())
    }

    /// Restores the state of a checkpoint; `None` if it does not match the loads.
    pub fn restore_state(&mut self, (starts, carried): &(Vec<f64>, Vec<Vec<f64>>)) -> Option<()> {
        let fits = |(on, saved): (&BodyLoad<D>, &Vec<f64>)| on.vectors.len() * D == saved.len();
        if starts.len() != self.start_times.len()
            || carried.len() != self.loads.len()
            || !self.loads.iter().zip(carried).all(fits)
        {
            return None;
        }
        self.start_times.clone_from(starts);
        for (on, saved) in self.loads.iter_mut().zip(carried) {
            on.vectors.as_flattened_mut().copy_from_slice(saved);
        }
        Some(())
    }
}
