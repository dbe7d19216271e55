//! Operations on the cell of a material point: preparation, loading, deformation, stress.

use colluvium_case::{Case, Solver};
use colluvium_constitutive::{Mat3, MaterialError, Motion, SymTensor, UpdateCost};
use serde_json::json;

use crate::DemSolver;
use crate::config::{CellControl, CellEntry, Friction};
use crate::material::NAME;
use crate::material::spec::{GranularCellSpec, parameter_error};
use crate::points::grains::volume;
use crate::setup;

/// Stages of the case of a cell: compression with the preparation friction, relaxation with the contact friction, deformation.
const STAGES: [&str; 3] = ["prepare", "settle", "deform"];
/// Index of the stage in which the cell is deformed.
const DEFORM: usize = 2;

/// Number of steps after which the search for equilibrium fails.
const MAX_STEPS: usize = 2_000_000;
/// Steps between checks of the equilibrium.
const STEPS_PER_CHECK: usize = 100;
/// Unbalanced force ratio at which grains are regarded as at rest (sheet: dem §3.1). Without friction a packing passes through states at
/// several times this ratio before it yields once more; a packing stopped there is looser than one at rest. The kinetic energy is a worse
/// measure: grains without contacts keep theirs.
const REST_RATIO: f64 = 1e-3;
/// Pressure over the preparation pressure below which a cell is unloaded by expansion. It is also a lower bound in the choice of rates.
const MIN_PRESSURE_RATIO: f64 = 0.05;
/// Largest change of the deformation gradient in a step of the grains.
const MAX_DEFORMATION_STEP: f64 = 1e-2;

/// Case of a cell of grains, from which all cells of the material are made.
pub struct CellCase {
    case: Case,
    /// Approximate size of a cell in bytes.
    pub bytes: usize,
}

impl CellCase {
    /// Case of a periodic cell of grains, with the stages of its preparation and deformation.
    pub fn new(spec: &GranularCellSpec) -> Result<Self, MaterialError> {
        let d = spec.dimension;
        let unit = volume(d, 0.5) * spec.diameter.mean_power(d, d as i32);
        let side = (spec.grains as f64 * unit / spec.solid_fraction()).powf(1.0 / d as f64);
        let (axes, zero, full) = (&["x", "y", "z"][..d], vec![0.0; d], vec![side; d]);
        let contact = &spec.contact;
        let mut pair = json!({
            "between": ["grain", "grain"], "normal": contact.normal, "tangential": contact.tangential,
            "friction": contact.friction,
        });
        if let Some(rolling) = contact.rolling {
            pair["rolling"] = json!(rolling);
        }
        let stage = |name: &str| json!({ "name": name, "duration": 1.0, "damping": spec.damping });
        let case = json!({
            "title": "A cell of grains",
            "space": if d == 3 { "3d" } else { "plane-strain" },
            "domain": { "min": zero, "max": full, "periodic": axes },
            "gravity": zero,
            "materials": { "grain": {
                "model": "linear-elastic", "density": spec.grain_density, "youngs_modulus": 1e9, "poissons_ratio": 0.0
            } },
            "bodies": [{ "name": "cell", "material": "grain", "shape": { "kind": "box", "min": zero, "max": full } }],
            "stages": STAGES.map(stage),
            "methods": { "dem": {
                "grains": { "grain": {
                    "density": spec.grain_density, "diameter": spec.diameter,
                    "fill": { "kind": "random", "solid_fraction": spec.solid_fraction() }
                } },
                "pairs": [pair],
                "seed": spec.seed,
                "stages": {
                    "prepare": { "pairs": [{ "between": ["grain", "grain"], "friction": { "coefficient": 0.0 } }] },
                    "settle": { "reset_contacts": true },
                    "deform": {}
                }
            } }
        });
        let case = Case::from_json(&case.to_string()).map_err(|error| cell_error(&error.to_string()))?;
        Ok(Self { case, bytes: 600 * spec.grains })
    }

    /// Creates a solver with the initial random packing.
    pub fn solver<const D: usize, const R: usize>(&self) -> Result<DemSolver<D, R>, MaterialError> {
        setup::solver(&self.case).map_err(|error| cell_error(&error.to_string()))
    }
}

/// Converts an error of the case of a cell to an error of the parameters.
fn cell_error(problem: &str) -> MaterialError {
    let first = problem.lines().next().unwrap_or_default();
    for (from, to) in [
        ("methods.dem.pairs[0].", "contact."),
        ("methods.dem.grains.grain.density", "grain_density"),
        ("methods.dem.grains.grain.", ""),
    ] {
        if let Some(rest) = first.strip_prefix(from)
            && let Some((field, rule)) = format!("{to}{rest}").split_once(": ")
        {
            return parameter_error(field, rule);
        }
    }
    parameter_error("law", first)
}

/// Error of a cell that does not reach equilibrium, for the given reason.
fn equilibrium_error(reason: &'static str) -> MaterialError {
    MaterialError::NotConverged { model: NAME, reason }
}

/// Message of a step in which grains overlap by more than the contact laws permit.
const OVERLAP_MESSAGE: &str = "grains overlap too far in this step: make steps smaller or contacts stiffer";

/// Checkpoint of the cell, as bytes.
pub fn bytes<const D: usize, const R: usize>(solver: &DemSolver<D, R>) -> Result<Vec<u8>, MaterialError> {
    let mut out = Vec::new();
    solver.save(&mut out).map_err(|_| equilibrium_error("the state of the cell cannot be stored"))?;
    Ok(out)
}

/// Restores a cell from the bytes of its checkpoint.
pub fn restore<const D: usize, const R: usize>(
    solver: &mut DemSolver<D, R>,
    mut bytes: &[u8],
) -> Result<(), MaterialError> {
    let foreign = |_| equilibrium_error("the stored state is of another material");
    if solver.clock.stage != DEFORM {
        solver.begin_stage(DEFORM, solver.clock.time).map_err(foreign)?;
    }
    solver.cell.imposed_gradient = None;
    solver.restore(&mut bytes).map_err(foreign)
}

/// Stress of the cell (Pa); for disks the out-of-plane stress is the mean of the normal stresses in the plane.
pub fn stress<const D: usize, const R: usize>(solver: &DemSolver<D, R>) -> SymTensor {
    let cell = solver.cell.stress();
    let at = |i: usize, j: usize| 0.5 * (cell[i][j] + cell[j][i]);
    if D == 2 {
        return SymTensor([at(0, 0), at(1, 1), 0.5 * (at(0, 0) + at(1, 1)), at(0, 1), 0.0, 0.0]);
    }
    SymTensor([at(0, 0), at(1, 1), at(2, 2), at(0, 1), at(1, 2), at(0, 2)])
}

/// Solid fraction: volume of the grains over volume of the cell.
pub fn solid_fraction<const D: usize, const R: usize>(solver: &DemSolver<D, R>) -> f64 {
    solver.grains.radius.iter().map(|radius| volume(D, *radius)).sum::<f64>() / solver.cell.geometry.volume()
}

/// Coordination number: twice the number of contacts over the number of grains.
pub fn coordination<const D: usize, const R: usize>(solver: &DemSolver<D, R>) -> f64 {
    2.0 * solver.records.energy_balance.contacts[0] as f64 / solver.grains.len() as f64
}

/// Upper bound of the P-wave modulus (Pa), for an affine stretch of all contacts along their branch vectors, `Σ k l² / V`. For Hertz
/// contacts the stiffness is 1.5 times the secant one.
pub fn modulus<const D: usize, const R: usize>(solver: &DemSolver<D, R>) -> f64 {
    let mut sum = 0.0;
    solver.view().for_each_contact(|contact, _, _| {
        if contact.overlap > 0.0 {
            let square: f64 = contact.branch.iter().map(|x| x * x).sum();
            sum += 1.5 * contact.normal.max(0.0) / contact.overlap * square;
        }
    });
    sum / solver.cell.geometry.volume()
}

/// Sets the control of the cell in the current stage.
fn set_cell<const D: usize, const R: usize>(solver: &mut DemSolver<D, R>, control: Option<CellControl>) {
    let name = STAGES[solver.clock.stage];
    solver.clock.options.stages.entry(name.to_owned()).or_default().cell = control;
}

/// Runs stress control until the cell has a stress (Pa) and its grains are at rest.
fn servo<const D: usize, const R: usize>(
    solver: &mut DemSolver<D, R>,
    target: &SymTensor,
    share: f64,
) -> Result<(), MaterialError> {
    let follow = |component: usize, within: bool| within.then_some(CellEntry::Stress(target[component]));
    set_cell(
        solver,
        Some(CellControl {
            xx: follow(0, true),
            yy: follow(1, true),
            zz: follow(2, D == 3),
            xy: follow(3, true),
            yz: follow(4, D == 3),
            xz: follow(5, D == 3),
            damping: Some(1.0),
        }),
    );
    let components: &[usize] = if D == 3 { &[0, 1, 2, 3, 4, 5] } else { &[0, 1, 3] };
    let allowed = share * target.norm();
    for step in 1..=MAX_STEPS {
        let dt = solver.critical_step().dt;
        solver.advance(dt).map_err(|_| equilibrium_error(OVERLAP_MESSAGE))?;
        if step % STEPS_PER_CHECK == 0 {
            let now = stress(solver);
            let error = components.iter().map(|&c| (now[c] - target[c]).abs()).fold(0.0, f64::max);
            if error <= allowed && solver.view().unbalanced_ratio() <= REST_RATIO {
                set_cell(solver, None);
                return Ok(());
            }
        }
    }
    Err(equilibrium_error(
        "the specimen does not reach equilibrium under its pressure: increase damping, or check the contacts",
    ))
}

/// Compresses the packing with a friction coefficient (sheet: dem §3.8).
pub fn prepare<const D: usize, const R: usize>(
    solver: &mut DemSolver<D, R>,
    spec: &GranularCellSpec,
    friction: f64,
) -> Result<(), MaterialError> {
    let target = SymTensor::isotropic(-spec.preparation.pressure);
    for pair in &mut solver.clock.options.stages.entry(STAGES[0].to_owned()).or_default().pairs {
        pair.friction = Some(Friction { coefficient: friction, at_rest: None });
    }
    for stage in 0..DEFORM {
        solver.begin_stage(stage, solver.clock.time).map_err(|_| equilibrium_error(OVERLAP_MESSAGE))?;
        servo(solver, &target, spec.tolerance)?;
    }
    solver.begin_stage(DEFORM, solver.clock.time).map_err(|_| equilibrium_error(OVERLAP_MESSAGE))
}

/// Loads the prepared cell to a stress (Pa).
pub fn load<const D: usize, const R: usize>(
    solver: &mut DemSolver<D, R>,
    spec: &GranularCellSpec,
    target: &SymTensor,
) -> Result<(), MaterialError> {
    let min_pressure = MIN_PRESSURE_RATIO * spec.preparation.pressure;
    let pressure = -(0..D).map(|c| target[c]).sum::<f64>() / D as f64;
    if pressure >= min_pressure {
        return servo(solver, target, spec.tolerance);
    }
    servo(solver, &SymTensor::isotropic(-min_pressure), spec.tolerance)?;
    let rate = largest_rate(solver, spec, min_pressure);
    solver.cell.imposed_gradient =
        Some(std::array::from_fn(|i| std::array::from_fn(|j| if i == j { rate } else { 0.0 })));
    for _ in 0..MAX_STEPS {
        if solver.cell.pressure() <= pressure {
            solver.cell.imposed_gradient = Some([[0.0; D]; D]);
            let dt = solver.critical_step().dt;
            return solver.advance(dt).map_err(|_| equilibrium_error(OVERLAP_MESSAGE));
        }
        let dt = solver.critical_step().dt;
        solver.advance(dt).map_err(|_| equilibrium_error(OVERLAP_MESSAGE))?;
    }
    Err(equilibrium_error("the stress of the specimen does not vanish during expansion"))
}

/// Largest strain rate (1/s), at the inertial number of the parameters under a pressure (Pa).
fn largest_rate<const D: usize, const R: usize>(
    solver: &DemSolver<D, R>,
    spec: &GranularCellSpec,
    pressure: f64,
) -> f64 {
    let mean = 2.0 * solver.grains.radius.iter().sum::<f64>() / solver.grains.len() as f64;
    spec.inertial_number * (pressure / spec.grain_density).sqrt() / mean
}

/// Grain updates per second on one thread, for disks and spheres. Measured on cells of 200 grains on a desktop computer
/// (docs/theory/dem.md).
const UPDATES: [f64; 2] = [1.2e6, 6e5];
/// Time to load and store the cell, per grain (s).
const LOAD_AND_STORE_TIME: f64 = 1.5e-6;

/// Estimated computing time of a stress update (s): steps of the grains, loading and storing of the cell.
pub fn update_cost<const D: usize, const R: usize>(
    solver: &DemSolver<D, R>,
    spec: &GranularCellSpec,
) -> UpdateCost {
    let grains = solver.grains.len() as f64;
    let step = grains / UPDATES[D - 2];
    let rate = largest_rate(solver, spec, spec.preparation.pressure);
    UpdateCost {
        update: grains * LOAD_AND_STORE_TIME + step,
        strain: step / (rate * solver.critical_step().dt),
    }
}

/// Deforms the cell by `f` at a rate that its grains allow; `before` is its stress (Pa).
pub fn deform<const D: usize, const R: usize>(
    solver: &mut DemSolver<D, R>,
    spec: &GranularCellSpec,
    f: &Mat3,
    before: &SymTensor,
) -> Result<(), MaterialError> {
    let change: [[f64; D]; D] =
        std::array::from_fn(|i| std::array::from_fn(|j| f.0[i][j] - f64::from(u8::from(i == j))));
    let size = |m: &[[f64; D]; D]| m.as_flattened().iter().map(|x| x * x).sum::<f64>().sqrt();
    let strain: [[f64; D]; D] =
        std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (change[i][j] + change[j][i])));
    let pressure = (-before.trace() / 3.0).max(MIN_PRESSURE_RATIO * spec.preparation.pressure);
    let dt = solver.critical_step().dt;
    let slow = size(&strain) / (largest_rate(solver, spec, pressure) * dt);
    let count = slow.max(size(&change) / MAX_DEFORMATION_STEP).ceil().clamp(1.0, MAX_STEPS as f64);
    // (1 + x)^n = 1 + c, to the third order in c.
    let square = crate::boundary::periodic_cell::product(&change, &change);
    solver.cell.imposed_gradient = Some(std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            (change[i][j] / count - (count - 1.0) / (2.0 * count * count) * square[i][j]) / dt
        })
    }));
    for _ in 0..count as usize {
        solver.advance(dt).map_err(|_| equilibrium_error(OVERLAP_MESSAGE))?;
    }
    Ok(())
}

/// Refuses initial tension: grains without cohesion carry none.
pub fn check_initial<const D: usize>(stress: &SymTensor) -> Result<(), MaterialError> {
    let normal = &stress.0[..D];
    let out_of_plane = if D == 2 { stress[4].abs() + stress[5].abs() } else { 0.0 };
    let reason = if normal.iter().any(|value| *value > 0.0) {
        format!("grains cannot carry tension (stress {:?} Pa)", stress.0)
    } else if out_of_plane > 0.0 {
        "disks cannot carry shear out of their plane: use dimension 3".to_owned()
    } else {
        return Ok(());
    };
    Err(MaterialError::Initial { model: NAME, reason })
}

/// Refuses out-of-plane motion of disks.
pub fn check_motion<const D: usize>(motion: &Motion) -> Result<(), MaterialError> {
    let f = &motion.deformation.0;
    let out_of_plane = [f[2][2] - 1.0, f[0][2], f[1][2], f[2][0], f[2][1]];
    if D == 3 || out_of_plane.iter().all(|value| value.abs() < 1e-12) {
        return Ok(());
    }
    let reason = "disks cannot have strain normal to their plane: use dimension 3, or a test in plane strain";
    Err(MaterialError::Motion { model: NAME, reason })
}
