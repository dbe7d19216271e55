//! Granular cell as a material law: a periodic cell of grains that continua and the element driver deform, with its stress
//! (sheet: dem §3.7–3.9; Sun 2020, “hierarchical multiscale”).
//!
//! Each point has a cell of its own, as the bytes of a checkpoint that points share until they deform. A step deforms the cell
//! by the motion of the point, in as many grain steps as keep the inertial number below a bound, and returns the mean stress
//! of its contacts. For the cost see `docs/theory/dem.md`.
//!
//! Disks carry stress in the plane; the out-of-plane stress is the mean of the two normal stresses, so that the mean pressure is that
//! in the plane, and out-of-plane strain is refused. Grains without cohesion have no stress once they lose contact: such a point is
//! stiff again only after it is compressed until its grains are in contact.

mod cell_operations;
mod porosity_search;
mod spec;

#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use colluvium_constitutive::{
    InitialCondition, Law, Material, MaterialError, MaterialFactory, Motion, Point, PointLaw, StressUpdate,
    SymTensor, Tangent, UpdateCost,
};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::{Map, Value};

pub use spec::{CellContact, GranularCellSpec, Preparation};

use crate::DemSolver;
use crate::material::cell_operations::CellCase;

const NAME: &str = "granular-cell";

/// Provider of `{"model": "external", "law": "granular-cell"}` for case files (see [`colluvium_constitutive::register_material`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GranularCells;

impl MaterialFactory for GranularCells {
    fn name(&self) -> &'static str {
        NAME
    }

    fn build(&self, _: f64, parameters: &Map<String, Value>) -> Result<Arc<dyn Material>, MaterialError> {
        let spec: GranularCellSpec = serde_json::from_value(Value::Object(parameters.clone()))
            .map_err(|error| spec::parameter_error("", error.to_string()))?;
        spec.validate()?;
        Ok(if spec.dimension == 3 {
            Arc::new(GranularCell::<3, 3>::new(spec)?)
        } else {
            Arc::new(GranularCell::<2, 1>::new(spec)?)
        })
    }
}

/// Cell state of a material point.
#[derive(Clone, Serialize, Deserialize)]
pub struct CellState {
    bytes: SharedBytes,
    /// Bound on the P-wave modulus (Pa).
    modulus: f64,
    /// Porosity, void volume over total volume.
    porosity: f64,
    /// Contacts per grain.
    coordination: f64,
    /// Mean unbalanced force over mean contact force.
    unbalanced_ratio: f64,
    /// Friction coefficient of the preparation.
    friction: f64,
}

/// Bytes shared by points until they deform.
#[derive(Clone)]
struct SharedBytes(Arc<[u8]>);

impl Serialize for SharedBytes {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        self.0.as_ref().serialize(to)
    }
}

impl<'de> Deserialize<'de> for SharedBytes {
    fn deserialize<T: Deserializer<'de>>(from: T) -> Result<Self, T::Error> {
        Vec::<u8>::deserialize(from).map(|bytes| Self(bytes.into()))
    }
}

type PreparedCell = Result<(SymTensor, CellState), MaterialError>;

/// Granular-cell law, for cells of `D` dimensions whose grains have rotations of `R` components.
pub struct GranularCell<const D: usize, const R: usize> {
    spec: GranularCellSpec,
    case: CellCase,
    update_cost: UpdateCost,
    /// Solvers that are not in use by a thread.
    idle_solvers: Mutex<Vec<DemSolver<D, R>>>,
    /// Specimen under its preparation pressure.
    prepared_cell: OnceLock<PreparedCell>,
    /// Cells loaded to the initial stresses of points, by the bits of those stresses.
    initial_cells: Mutex<HashMap<[u64; 6], PreparedCell>>,
}

fn lock<T>(lock: &Mutex<T>) -> MutexGuard<'_, T> {
    lock.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<const D: usize, const R: usize> GranularCell<D, R> {
    /// Creates the law of a cell of grains.
    ///
    /// # Errors
    /// The first parameter that the discrete element method refuses.
    pub fn new(spec: GranularCellSpec) -> Result<Self, MaterialError> {
        let frame = CellCase::new(&spec)?;
        let first = frame.solver()?;
        Ok(Self {
            update_cost: cell_operations::update_cost(&first, &spec),
            spec,
            case: frame,
            idle_solvers: Mutex::new(vec![first]),
            prepared_cell: OnceLock::new(),
            initial_cells: Mutex::default(),
        })
    }

    /// Calls `use_it` with a solver in the cell state `state`.
    fn with_solver<T>(
        &self,
        state: &CellState,
        use_it: impl FnOnce(&mut DemSolver<D, R>) -> Result<T, MaterialError>,
    ) -> Result<T, MaterialError> {
        let idle = lock(&self.idle_solvers).pop();
        let mut solver = idle.map_or_else(|| self.case.solver(), Ok)?;
        cell_operations::restore(&mut solver, &state.bytes.0)?;
        let result = use_it(&mut solver);
        lock(&self.idle_solvers).push(solver);
        result
    }

    fn state(&self, solver: &DemSolver<D, R>) -> Result<CellState, MaterialError> {
        let base = self.prepared_cell.get().and_then(|prepared| prepared.as_ref().ok());
        let (smallest, friction) = base.map_or((0.0, 0.0), |(_, base)| (base.modulus, base.friction));
        Ok(CellState {
            bytes: SharedBytes(cell_operations::bytes(solver)?.into()),
            modulus: cell_operations::modulus(solver).max(smallest),
            porosity: 1.0 - cell_operations::solid_fraction(solver),
            coordination: cell_operations::coordination(solver),
            unbalanced_ratio: solver.view().unbalanced_ratio(),
            friction,
        })
    }

    fn prepare_cell(&self) -> PreparedCell {
        let with_friction = |friction: f64| {
            let mut solver = self.case.solver()?;
            cell_operations::prepare(&mut solver, &self.spec, friction)?;
            let state = CellState { friction, ..self.state(&solver)? };
            let found = Ok((cell_operations::stress(&solver), state));
            lock(&self.idle_solvers).push(solver);
            found
        };
        let preparation = self.spec.preparation;
        let prepare = || match preparation.porosity {
            Some(porosity) => porosity_search::friction(porosity, with_friction, |(_, state)| state.porosity),
            None => with_friction(preparation.friction.unwrap_or(0.0)),
        };
        self.prepared_cell.get_or_init(prepare).clone()
    }

    fn initial_cell(&self, target: &SymTensor) -> PreparedCell {
        let key = target.0.map(f64::to_bits);
        if let Some(known) = lock(&self.initial_cells).get(&key) {
            return known.clone();
        }
        let (_, base) = self.prepare_cell()?;
        let made = self.with_solver(&base, |solver| {
            cell_operations::load(solver, &self.spec, target)?;
            Ok((cell_operations::stress(solver), self.state(solver)?))
        });
        lock(&self.initial_cells).entry(key).or_insert(made).clone()
    }

    fn deform_cell(
        &self,
        motion: &Motion,
        old: &Point<CellState>,
    ) -> Result<Point<CellState>, MaterialError> {
        self.with_solver(&old.state, |solver| {
            cell_operations::deform(solver, &self.spec, &motion.deformation, &old.stress)?;
            Ok(Point { stress: cell_operations::stress(solver), state: self.state(solver)? })
        })
    }
}

/// Strain increment of the finite-difference tangent: small against the strain to failure, large against noise.
const PROBE_STRAIN: f64 = 1e-4;

impl<const D: usize, const R: usize> Law for GranularCell<D, R> {
    fn name(&self) -> &'static str {
        NAME
    }

    /// Returns false: a cell of few grains has a fabric, and its periods a direction.
    fn is_isotropic(&self) -> bool {
        false
    }

    fn stress_tolerance(&self) -> f64 {
        self.spec.tolerance
    }

    fn update_cost(&self) -> Option<UpdateCost> {
        Some(self.update_cost)
    }

    fn requires_plane_strain(&self) -> bool {
        D == 2
    }

    fn output_names(&self) -> &[&'static str] {
        &["porosity", "coordination", "unbalanced_force", "preparation_friction"]
    }
}

impl<const D: usize, const R: usize> PointLaw for GranularCell<D, R> {
    type State = CellState;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<CellState>, MaterialError> {
        cell_operations::check_initial::<D>(&initial.stress)?;
        let (stress, state) = self.initial_cell(&initial.stress)?;
        Ok(Point { stress, state })
    }

    fn wave_modulus(&self, point: &Point<CellState>) -> f64 {
        point.state.modulus
    }

    fn outputs(&self, point: &Point<CellState>, out: &mut [f64]) {
        let CellState { porosity, coordination, unbalanced_ratio, friction, .. } = point.state;
        out.copy_from_slice(&[porosity, coordination, unbalanced_ratio, friction]);
    }
}

impl<const D: usize, const R: usize> StressUpdate for GranularCell<D, R> {
    fn update(&self, motion: &Motion, old: &Point<CellState>) -> Result<Point<CellState>, MaterialError> {
        cell_operations::check_motion::<D>(motion)?;
        if motion.deformation == colluvium_constitutive::Mat3::IDENTITY {
            return Ok(old.clone());
        }
        self.deform_cell(motion, old)
    }

    fn state_size(&self) -> usize {
        let bytes = self.prepared_cell.get().and_then(|prepared| prepared.as_ref().ok());
        size_of::<CellState>() + bytes.map_or(self.case.bytes, |(_, state)| state.bytes.0.len())
    }

    /// Tangent by forward differences of a strain of 1e-4; for disks in their plane, with a stiffness of equal size out of it.
    fn tangent(&self, motion: &Motion, old: &Point<CellState>) -> Result<Tangent, MaterialError> {
        let here = StressUpdate::update(self, motion, old)?.stress;
        let mut tangent = [[0.0; 6]; 6];
        for (k, &(i, j)) in [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)].iter().enumerate() {
            if i >= D || j >= D {
                tangent[k][k] = old.state.modulus;
                continue;
            }
            let mut gradient = motion.velocity_gradient_dt;
            gradient.0[i][j] += 0.5 * PROBE_STRAIN;
            gradient.0[j][i] += 0.5 * PROBE_STRAIN;
            let velocity = gradient * (1.0 / motion.dt);
            let probe = Motion::from_velocity_gradient(&velocity, motion.dt, motion.density, motion.size)
                .ok_or(MaterialError::Motion { model: NAME, reason: "the step is singular" })?;
            let there = StressUpdate::update(self, &probe, old)?.stress;
            for (row, entries) in tangent.iter_mut().enumerate() {
                entries[k] = (there[row] - here[row]) / PROBE_STRAIN;
            }
        }
        Ok(Tangent(tangent))
    }
}
