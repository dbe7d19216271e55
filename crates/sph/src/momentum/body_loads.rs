//! Loads on the surface of bodies, carried by the particles next to it (sheet: mpm §2.11; `colluvium_case::loads::load_vectors`).
//!
//! The force of a load is that of the case on the area next to a particle, whatever the sums over its neighbours make of the
//! surface there: resultants are exact, and the load is smeared over the kernel of the outermost particles.

use colluvium_case::{Case, CaseError};

/// One load, on the body it is on.
#[derive(Clone)]
pub struct BodyLoad<const D: usize> {
    /// Index into `Case::loads`.
    pub number: usize,
    /// Index into `Case::bodies`.
    pub body: u32,
    /// Id of the first particle of the body, whose ids follow each other.
    pub first: u32,
    /// What the particle of each id carries of it.
    pub vectors: Vec<[f64; D]>,
}

impl<const D: usize> BodyLoad<D> {
    /// Whether it follows its surface: what particles carry of it changes then.
    pub fn is_follower(&self, case: &Case) -> bool {
        case.loads[self.number].is_follower()
    }
}

/// A body as loads see it at the start.
pub struct LoadedBody<'a, const D: usize> {
    /// Index into `Case::bodies`.
    pub body: u32,
    /// Whether it is held.
    pub held: bool,
    /// Id of its first particle.
    pub first: u32,
    /// Positions of its particles (m).
    pub positions: &'a [[f64; D]],
}

/// The loads of a case.
#[derive(Clone, Default)]
pub struct BodyLoads<const D: usize> {
    /// Those that lie on a body.
    pub all: Vec<BodyLoad<D>>,
    /// When each load of the case begins (s).
    pub starts: Vec<f64>,
}

impl<const D: usize> BodyLoads<D> {
    /// The loads of `case` on `bodies` whose particles stand `spacing` (m) apart, as they are at the start.
    ///
    /// # Errors
    /// When a load lies on a body that is held, or on nothing.
    pub fn new(case: &Case, bodies: &[LoadedBody<'_, D>], spacing: f64) -> Result<Self, CaseError> {
        let mut all = Vec::new();
        for (number, load) in case.loads.iter().enumerate() {
            let on = |loaded: &&LoadedBody<'_, D>| case.bodies[loaded.body as usize].name == load.body();
            let Some(&LoadedBody { body, held, first, positions }) = bodies.iter().find(on) else { continue };
            if held {
                let problem = format!("the body {:?} is held, whatever acts on it", load.body());
                return Err(CaseError::new(format!("loads[{number}].body"), problem));
            }
            let carried = case.load_vectors(number, positions, &[spacing; D])?;
            all.push(BodyLoad { number, body, first, vectors: carried });
        }
        Ok(Self { all, starts: case.load_starts() })
    }

    /// Begins the loads that begin with a stage, at `start` (s).
    pub fn begin(&mut self, case: &Case, stage: usize, start: f64) {
        case.begin_loads(&mut self.starts, stage, start);
    }

    /// What a checkpoint keeps: when loads begin, and what particles carry of those that follow their surfaces.
    pub fn checkpoint_state(&self) -> (Vec<f64>, Vec<Vec<f64>>) {
        (self.starts.clone(), self.all.iter().map(|on| on.vectors.as_flattened().to_vec()).collect())
    }

    /// Takes what a checkpoint kept; `None` where it does not fit.
    pub fn restore_state(&mut self, (starts, carried): &(Vec<f64>, Vec<Vec<f64>>)) -> Option<()> {
        let fits = |(on, saved): (&BodyLoad<D>, &Vec<f64>)| on.vectors.len() * D == saved.len();
        if starts.len() != self.starts.len()
            || carried.len() != self.all.len()
            || !self.all.iter().zip(carried).all(fits)
        {
            return None;
        }
        self.starts.clone_from(starts);
        for (on, saved) in self.all.iter_mut().zip(carried) {
            on.vectors.as_flattened_mut().copy_from_slice(saved);
        }
        Some(())
    }
}
