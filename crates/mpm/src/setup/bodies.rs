//! Sampling of bodies by points.

use colluvium_case::bodies::law_points::InitialLawState;
use colluvium_case::description::{Body, Space};
use colluvium_case::{Case, CaseError, PointList, spatial};
use colluvium_grid::{Domains, GridView};
use colluvium_points::Sample;

use crate::background_grid::BackgroundGrid;
use crate::background_grid::unstructured_mesh;
use crate::phases;
use crate::points::point_set::{PointColumns, PointSet};
use crate::{MpmOptions, StressScheme};
use colluvium_case::CaseErrorKind;

/// Maximum number of points, by the range of ids.
const MAX_POINTS: usize = u32::MAX as usize;

/// Returns the points of body `number`, with ids from `first_id` on; `listed` are those of a list. `wet` where any body has a pore fluid.
pub(super) fn point_set<const D: usize>(
    case: &Case,
    options: &MpmOptions,
    background: &BackgroundGrid<D>,
    (number, listed): (usize, Option<&PointList>),
    first_id: usize,
    wet: bool,
) -> Result<PointSet<D>, CaseError> {
    let view = &background.grid_view();
    let body = &case.bodies[number];
    let path = format!("bodies[{number}]");
    let samples = samples(options, view, case, (number, listed), first_id)?;
    let position: Vec<[f64; D]> = samples.iter().map(|sample| sample.position).collect();
    let radial = |x: &[f64; D]| if case.space == Space::Axisymmetric { x[0] } else { 1.0 };
    let volume: Vec<f64> = samples.iter().map(|sample| sample.volume * radial(&sample.position)).collect();
    let mass = volume.iter().enumerate().map(|(i, v)| Ok(v * case.density_at(number, listed, i)?));
    let mass = mass.collect::<Result<Vec<f64>, CaseError>>()?;
    let pore = wet.then(|| phases::pore_set(case, body, listed, &position));
    let InitialLawState { material, stress, states } = case.initialise_law(number, listed, &position)?;
    let domain = domains(background, &position, &path)?;
    let follows_later = domain.stretch() && options.stress_update == StressScheme::Usf;
    let used = |used: bool| if used { samples.len() } else { 0 };
    let velocity = velocities(body, listed, &position);
    let is_affine = options.transfer_of(number).is_affine();
    Ok(PointSet {
        body: number as u32,
        field: 0,
        rigid: None,
        material,
        extent: [width(view, options, &samples, listed.is_some() || !on_lattice(body)); D],
        points: PointColumns {
            id: (first_id as u32..(first_id + position.len()) as u32).collect(),
            grid_velocity: if is_affine { Vec::new() } else { velocity.clone() },
            velocity,
            mass,
            initial_volume: volume.clone(),
            volume,
            stress,
            origin: position.clone(),
            affine_velocity: vec![[[0.0; D]; D]; used(is_affine)],
            scratch: vec![[0.0; D]; used(options.filters_velocities())],
            pending_gradient: vec![[[0.0; D]; D]; used(follows_later)],
            position,
            ..PointColumns::default()
        },
        states,
        domain,
        loads: Vec::new(),
        pore,
        slabs: Vec::new(),
    })
}

/// Initial velocities of the points of a body (m/s); `listed` values are from a file.
fn velocities<const D: usize>(
    body: &Body,
    listed: Option<&PointList>,
    position: &[[f64; D]],
) -> Vec<[f64; D]> {
    let velocity_at = |(point, x): (usize, &[f64; D])| {
        let own = listed.and_then(|list| Some(list.velocities.as_ref()?[point]));
        let velocity = own.unwrap_or_else(|| body.velocity.velocity_at(spatial(x)));
        std::array::from_fn(|c| velocity[c])
    };
    position.iter().enumerate().map(velocity_at).collect()
}

/// Domains of the points of a body with their initial widths.
fn domains<const D: usize>(
    background: &BackgroundGrid<D>,
    position: &[[f64; D]],
    path: &str,
) -> Result<Domains<D>, CaseError> {
    let mut domains = background.transfers.domains(position.len());
    domains.initialise(&background.grid_view(), position).map_err(|(p, reason)| {
        CaseError::new(format!("{path}.shape"), format!("the point at {:?} m: {reason}", position[p]))
    })?;
    Ok(domains)
}

/// Whether the points of a body are on a lattice, with equal widths.
fn on_lattice(body: &Body) -> bool {
    !body.shape.follows_terrain() && body.sampling.is_lattice()
}

/// Full width of the points of a body (m). For points in elements, lists or boundary-fitted rows it is the mean edge of squares or cubes of
/// their volume.
fn width<const D: usize>(
    view: &GridView<'_, D>,
    options: &MpmOptions,
    samples: &[Sample<D>],
    listed: bool,
) -> f64 {
    if view.mesh.is_empty() && !listed {
        return view.grid.cell / options.points_per_cell as f64;
    }
    let volume = samples.iter().map(|sample| sample.volume).sum::<f64>() / samples.len() as f64;
    // The range of shape functions is that of points as wide as a cell at most.
    let width = volume.powf(1.0 / D as f64);
    if listed { width.min(view.grid.cell) } else { width }
}

/// Points of a body from its shape or a list, with the spacing checked against the cell size.
fn samples<const D: usize>(
    options: &MpmOptions,
    view: &GridView<'_, D>,
    case: &Case,
    (number, listed): (usize, Option<&PointList>),
    first_id: usize,
) -> Result<Vec<Sample<D>>, CaseError> {
    let (grid, body, path) = (view.grid, &case.bodies[number], format!("bodies[{number}]"));
    let samples = if let Some(list) = listed {
        let spacing = list.spacing(D);
        if spacing > (1.0 + 1e-9) * grid.cell {
            let problem = format!(
                "the mean width of the points is {spacing:.4e} m, more than the cell size of {} m",
                grid.cell
            );
            return Err(CaseError::new(format!("{path}.points"), problem));
        }
        list.samples()
    } else if view.mesh.is_empty() {
        case.samples(number, grid.origin, grid.cell / options.points_per_cell as f64)?
    } else if body.shape.follows_terrain() {
        let problem = "terrain needs points on a lattice, but with a mesh the points have fixed positions in \
                       its elements";
        return Err(CaseError::new(format!("{path}.shape.rows"), problem));
    } else if !body.sampling.is_lattice() {
        let problem = "with a mesh the points have fixed positions in its elements";
        return Err(CaseError::new(format!("{path}.sampling"), problem));
    } else {
        unstructured_mesh::sample_body(view.mesh, options, body)
    };
    if samples.is_empty() {
        let problem = format!("holds no point: it is smaller than the cells of {} m", grid.cell);
        return Err(CaseError::new(format!("{path}.shape"), CaseErrorKind::coded("empty-body", problem)));
    }
    if first_id + samples.len() > MAX_POINTS {
        return Err(CaseError::new(
            "methods.mpm.cell_size",
            CaseErrorKind::coded("too-many-points", format!("gives more than {MAX_POINTS} points")),
        ));
    }
    if let Some(outside) = samples.iter().find(|sample| !grid.contains(&sample.position)) {
        let problem = format!("the point at {:?} m lies outside the domain", outside.position);
        return Err(CaseError::new(format!("{path}.shape"), CaseErrorKind::coded("outside-domain", problem)));
    }
    Ok(samples)
}
