//! Construction of a solver from a case: rejects features that the method does not support, by JSON path.

pub(crate) mod bed;
mod body_nodes;
mod capabilities;
mod hazard_rasters;
mod inflows;
mod material;
mod open_boundaries;
mod point_changes;
mod pore_fluid;

use std::sync::Arc;

use colluvium_case::description::Space;
use colluvium_case::{Case, CaseError, CaseErrorKind, Plan, ProblemSize, Resolution, Solver};
use colluvium_points::Raster;

use crate::setup::bed::case_bed::CaseBed;
pub(crate) use crate::setup::capabilities::capabilities;

use crate::NAME;
use crate::bed::Bed;
use crate::boundary::stages::plan_boundaries;
use crate::config::DepthOptions;
use crate::config::choices::{DepthFrame, Phases};
use crate::config::settings::{Consolidation, EarthPressure, FlowSettings, Mixture, Numerics, PoreColumn};
use crate::flow::{Flow, FlowFailure, OutsideNodes};
use crate::laws::interphase_drag::MixtureDensities;
use crate::solver::DepthSolver;
use colluvium_case::Warning;

/// Node updates per second and thread, from the benchmark of one phase without columns.
const UPDATES_PER_SECOND: f64 = 2e6;
/// Node-updates per second and thread with two phases or columns.
const COUPLED_UPDATES_PER_SECOND: f64 = 5e5;

/// Error under a key of the options.
fn option_error(key: &str, kind: impl Into<CaseErrorKind>) -> CaseError {
    CaseError::new(format!("methods.{NAME}.{key}"), kind)
}

/// Options of the case, checked.
pub(crate) fn options(case: &Case) -> Result<DepthOptions, CaseError> {
    if !case.methods.contains_key(NAME) {
        let problem = "is missing: depth-integrated SPH needs at least its `spacing` (m)";
        return Err(CaseError::new(format!("methods.{NAME}"), CaseErrorKind::missing_input(NAME, problem)));
    }
    let options: DepthOptions = pore_fluid::with_pore_fluid_options(case)?.method_options(NAME)?;
    options.validate().map_err(|(key, problem)| option_error(&key, problem))?;
    Ok(options)
}

/// Builds the solver of `case`.
pub fn build(case: &Case) -> Result<Box<dyn Solver>, CaseError> {
    Ok(match case.space {
        Space::PlaneStrain => Box::new(typed_solver::<1>(case)?),
        _ => Box::new(typed_solver::<2>(case)?),
    })
}

/// Builds the solver of `case`, which has `D` dimensions in plan.
pub fn typed_solver<const D: usize>(case: &Case) -> Result<DepthSolver<D>, CaseError> {
    let options = options(case)?;
    capabilities::check_supported(case, &options)?;
    solver(case, &options)
}

/// Plan of `case`.
pub fn plan(case: &Case) -> Result<Plan, CaseError> {
    let options = options(case)?;
    capabilities::check_supported(case, &options)?;
    match case.space {
        Space::PlaneStrain => plan_in::<1>(case, &options),
        _ => plan_in::<2>(case, &options),
    }
}

/// Memory of a node with its neighbours (bytes).
fn bytes_per_node(case: &Case, options: &DepthOptions) -> f64 {
    let neighbours = if case.space == Space::PlaneStrain { 20.0 } else { 60.0 };
    let heads = options.column.as_ref().map_or(0.0, |column| 8.0 * (column.cells + 1) as f64);
    600.0 + 4.0 * neighbours + heads
}

/// Size of `case`, without making its nodes.
pub fn problem_size(case: &Case) -> Result<ProblemSize, CaseError> {
    let options = options(case)?;
    capabilities::check_supported(case, &options)?;
    let sets = if options.phases == Phases::Two { 2.0 } else { 1.0 };
    let area: f64 = case
        .bodies
        .iter()
        .map(|body| {
            let (low, high) = body.shape.bounds(case.dimension());
            (0..case.dimension() - 1).map(|c| (high[c] - low[c]).max(0.0)).product::<f64>()
        })
        .sum();
    let points = sets * area / options.spacing.powi(case.dimension() as i32 - 1);
    let case_key = "methods.depth-sph.spacing";
    Ok(ProblemSize {
        points,
        nodes: 0.0,
        memory: points * bytes_per_node(case, &options),
        case_key,
        ..ProblemSize::default()
    })
}

/// Densities of the bodies, if those of the mixture apply (kg/m³).
fn densities(case: &Case, options: &DepthOptions) -> Option<Vec<f64>> {
    let mixture = options.mixture.as_ref()?;
    let densities = MixtureDensities {
        grain: mixture.grain_density,
        fluid: mixture.fluid_density,
        gravity: case.gravity_magnitude(),
    };
    let of_body = |name: &String| match options.phases {
        Phases::Layers if mixture.upper.contains(name) => mixture.fluid_density,
        Phases::Layers => mixture.grain_density,
        _ => densities.mixture(mixture.porosity_of(name)),
    };
    Some(case.bodies.iter().map(|body| of_body(&body.name)).collect())
}

/// Plan of a case in `D` plan dimensions: number of nodes, steps and memory, with warnings.
fn plan_in<const D: usize>(case: &Case, options: &DepthOptions) -> Result<Plan, CaseError> {
    let (mut solver, of_bed) = build_in::<D>(case, options)?;
    let time_step = solver.limit();
    let points = solver.point_count();
    let mut warnings = options.warnings();
    warnings.extend(of_bed);
    warnings.extend(capabilities::warnings(case, points));
    warnings.extend(pore_fluid::warnings(case));
    let coupled = options.phases != Phases::One || options.column.is_some();
    Ok(Plan {
        points,
        nodes: 0,
        steps: (case.end_time() / time_step.dt).ceil() as u64,
        time_step,
        memory: (points as f64 * bytes_per_node(case, options)) as u64,
        volumes: solver.volumes(),
        grains: None,
        densities: densities(case, options),
        resolution: Some(Resolution {
            width: options.spacing,
            point_distance: options.spacing,
            axes: D,
            case_key: "methods.depth-sph.spacing",
            noun: "spacings",
        }),
        updates_per_second: if coupled { COUPLED_UPDATES_PER_SECOND } else { UPDATES_PER_SECOND },
        warnings,
    })
}

/// Builds a solver with its concrete type, at time zero.
pub(crate) fn solver<const D: usize>(
    case: &Case,
    options: &DepthOptions,
) -> Result<DepthSolver<D>, CaseError> {
    Ok(build_in(case, options)?.0)
}

/// Solver of a case at time zero, with the warnings of its bed.
fn build_in<const D: usize>(
    case: &Case,
    options: &DepthOptions,
) -> Result<(DepthSolver<D>, Vec<Warning>), CaseError> {
    let ground = bed::case_bed::case_bed::<D>(case, options)?;
    let mut of_maps = Vec::new();
    let maps = hazard_rasters::hazard_rasters(case, &ground, options.spacing, &mut of_maps)?;
    let CaseBed { mut bed, fit_errors, mut warnings, .. } = ground;
    warnings.append(&mut of_maps);
    let settings = settings::<D>(case, options)?;
    if let Bed::Erodible(erodible) = &mut bed {
        let depths = erodible_depths(case, options)?;
        erodible.set_erodible_depth(|x| {
            let of_zone = settings.erodible_depth(&std::array::from_fn(|c| x[c]));
            // Zero where the raster has no data.
            let limit = |raster: &Raster| raster.interpolate(x[0], x[1]).unwrap_or(0.0);
            depths.as_ref().map_or(of_zone, |raster| of_zone.min(limit(raster)))
        });
    }
    let filled = body_nodes::body_nodes::<D>(case, options, &settings.material, &bed)?;
    warnings.extend(filled.warnings);
    let ends = plan_boundaries::<D>(case, 0);
    let failed = |failure: FlowFailure| {
        CaseError::new("bodies", CaseErrorKind::coded(failure.reason.code(), failure.to_string()))
    };
    let mut flow = Flow::new(settings, bed, ends, &filled.sets).map_err(failed)?;
    let mut openings = inflows::add_inflows(case, options, &mut flow, &mut warnings)?;
    openings.extend(open_boundaries::openings(case, options));
    warnings.extend(open_boundaries::open_boundaries(&openings, &mut flow)?);
    if !filled.transferred_pressures.is_empty() {
        let held = flow.set_pore_pressures(&filled.transferred_pressures);
        if held > 0 {
            warnings.push(Warning::new(
                "pore-pressure-limited",
                format!(
                    "bodies: the initial pore pressure of {held} nodes exceeds the weight of the material or \
                 is below the lower bound of methods.depth-sph.column: it is limited to this range"
                ),
            ));
        }
    }
    flow.boundary.outside =
        if options.leaving_is_an_error { OutsideNodes::Fail } else { OutsideNodes::Remove };
    let solver = DepthSolver::new(Arc::new(case.clone()), options.clone(), flow, maps, fit_errors);
    Ok((solver, warnings))
}

/// Raster of the erodible depths, if the case has one.
fn erodible_depths(case: &Case, options: &DepthOptions) -> Result<Option<Raster>, CaseError> {
    let Some(file) = &options.erodible_depth_raster else { return Ok(None) };
    let wrong = |kind: CaseErrorKind| option_error("erodible_depth_raster", kind);
    if case.dimension() != 3 {
        return Err(wrong(CaseErrorKind::coded(
            "needs-other-key",
            "a raster is available in 3d only: give `erodible_depth`",
        )));
    }
    let raster = case.plan_raster(file).map_err(wrong)?;
    raster
        .validate()
        .map_err(|error| wrong(CaseErrorKind::coded_file(file, error.code(), error.to_string())))?;
    match raster.values.iter().find(|depth| **depth < 0.0) {
        Some(depth) => {
            let problem = format!("a depth of {depth} m must not be negative");
            Err(wrong(CaseErrorKind::file(file, problem)))
        }
        None => Ok(Some(raster)),
    }
}

/// Settings that are constant during the flow.
fn settings<const D: usize>(case: &Case, options: &DepthOptions) -> Result<FlowSettings<D>, CaseError> {
    let gravity = -case.gravity[D];
    let drive: [f64; D] = std::array::from_fn(|c| case.gravity[c]);
    let tilted = drive.iter().any(|g| *g != 0.0);
    let frame = match options.frame {
        Some(frame) if tilted && frame != DepthFrame::BedFitted => {
            return Err(option_error(
                "frame",
                "must be bed-fitted, because gravity is tilted over a flat bed",
            ));
        }
        Some(DepthFrame::BedFitted) if !case.obstacles.is_empty() => {
            return Err(option_error(
                "frame",
                "must not be bed-fitted, because the bed is an obstacle: depth is vertical over it",
            ));
        }
        Some(frame) => frame,
        None if tilted => DepthFrame::BedFitted,
        None => DepthFrame::Horizontal,
    };
    let material = material::mixture(case, options, case.gravity_magnitude())?;
    let drag = options.mixture.as_ref().map(|mixture| mixture.drag).unwrap_or_default();
    Ok(FlowSettings {
        phases: options.phases,
        gravity,
        plan_gravity: drive,
        frame,
        metric: options.metric,
        curvature_in_friction: options.curvature_in_friction,
        material,
        drag,
        column: column(options, &material),
        zones: bed::bed_zones::zones(case, options)?,
        earth_pressure: options.earth_pressure.map(|earth| {
            let (internal, basal) = (earth.internal_friction_angle, earth.basal_friction_angle);
            EarthPressure::savage_hutter(internal.to_radians(), basal.to_radians())
        }),
        interface_friction: options.mixture.as_ref().map_or(0.0, |mixture| mixture.interface_friction),
        numerics: numerics::<D>(options),
    })
}

/// Numerical parameters of the options.
fn numerics<const D: usize>(options: &DepthOptions) -> Numerics {
    Numerics {
        kernel: options.kernel,
        variable_length: options.variable_smoothing,
        shortest: options.shortest_smoothing.unwrap_or(0.0),
        summation_passes: options.passes,
        continuity: options.continuity,
        momentum: options.momentum,
        surface_gradient: options.surface_gradient,
        integration: options.integration,
        viscosity: (options.viscosity_linear, options.viscosity_quadratic),
        xsph: options.xsph,
        search: options.search,
        courant: options.courant,
        ..Numerics::defaults::<D>()
    }
}

/// Pore-pressure column of the options; `None` without one.
fn column(options: &DepthOptions, material: &Mixture) -> Option<PoreColumn> {
    let column = options.column.as_ref()?;
    let mixture = options.mixture.as_ref()?;
    let permeability = mixture.drag.permeability(material.porosity, &material.densities);
    // A coefficient c_v = k_w K_v/α also gives the stiffness, where there is a permeability.
    let (consolidation, stiffness) = match (&column.skeleton, column.consolidation) {
        (Some(skeleton), _) => (Consolidation::OfDrag, skeleton.stiffness()),
        (None, Some(value)) => (Consolidation::Coefficient(value), value / permeability),
        (None, None) => return None,
    };
    Some(PoreColumn {
        cells: column.cells,
        weight: column.weight,
        profile: column.profile,
        consolidation,
        lower_bound: column.lower_bound,
        excess_ratio: column.excess_ratio,
        stiffness,
        dilatancy: column.dilatancy.map(|dilatancy| (dilatancy.slope, dilatancy.critical_porosity)),
    })
}
