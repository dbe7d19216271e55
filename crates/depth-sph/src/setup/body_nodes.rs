//! Nodes of the bodies: thickness in plan is the vertical length of the body above (sheet: depth-sph §3.2).

use std::collections::BTreeMap;

use colluvium_case::description::Body;
use colluvium_case::{Case, CaseError, PointList};
use colluvium_points::Shape;

use crate::bed::{Bed, BedPoint};
use crate::config::DepthOptions;
use crate::config::choices::Phases;
use crate::config::settings::Mixture;
use crate::points::phase_nodes::NewNode;
use crate::pore_pressure::pressure_transfer::{PointAboveSquare, TransferredPressure};
use crate::setup::pore_fluid::PorePressureField;
use colluvium_case::CaseErrorKind;
use colluvium_case::Warning;

/// Tolerance of the gap between a body and the bed, or between bodies, over the height of the domain.
const HEIGHT_TOLERANCE: f64 = 1e-6;

/// Tolerance of the difference of a hydrostatic surface from the flow surface, over the depth.
const SURFACE_TOLERANCE: f64 = 0.01;

/// Nodes of each set, with their pore pressures and warnings.
pub struct BodyNodes<const D: usize> {
    /// Nodes of each set.
    pub sets: Vec<Vec<NewNode<D>>>,
    /// Pore pressures transferred from points, each with the number of its node in the first set.
    pub transferred_pressures: Vec<(usize, TransferredPressure)>,
    /// Warnings.
    pub warnings: Vec<Warning>,
}

/// Makes the nodes of each set.
pub fn body_nodes<const D: usize>(
    case: &Case,
    options: &DepthOptions,
    material: &Mixture,
    bed: &Bed<D>,
) -> Result<BodyNodes<D>, CaseError> {
    let (mut warnings, mut transferred) = (Vec::new(), Vec::new());
    let mut sets = vec![Vec::new(); if options.phases == Phases::One { 1 } else { 2 }];
    let upper =
        |body: &Body| options.mixture.as_ref().is_some_and(|mixture| mixture.upper.contains(&body.name));
    let lattice = PlanLattice::<D>::new(case, options.spacing);
    for (number, body) in case.bodies.iter().enumerate() {
        let density = density(options, material, body, upper(body));
        if let Some((own, pressures)) = nodes_of_points(case, options, (number, density), bed, &mut warnings)?
        {
            let first = sets[0].len();
            transferred.extend(pressures.into_iter().enumerate().map(|(i, pressure)| (first + i, pressure)));
            assign_to_phases(options, &mut sets, own, body);
            continue;
        }
        let mut own = Vec::new();
        let field = PorePressureField::for_body(case, options.frame, body);
        let (mut volume, mut whole) = (0.0, 0.0);
        for x in lattice.squares_in(body, case.dimension()) {
            let column = body_column::<D>(case, number, &x, bed)?;
            let area = options.spacing.powi(D as i32);
            whole += column.total_thickness * area;
            if column.thickness_above_bed <= 0.0 {
                continue;
            }
            let cell = column.thickness_above_bed * area;
            volume += cell;
            if let (Some(field), Some(below)) = (&field, bed.bed_point(&x)) {
                let pressure =
                    pore_pressure_profile(case, options, (number, field), (column.depth, &x, &below))?;
                transferred.extend(pressure.map(|pressure| (sets[0].len() + own.len(), pressure)));
            }
            own.push(new_node(body, number, x, cell, options));
        }
        let exact = body.shape.measure(case.dimension());
        // Correction of the volume that the lattice loses at edges; a body that the bed cuts has no closed form.
        if let Some(exact) = exact.filter(|_| volume > 0.0 && volume >= (1.0 - HEIGHT_TOLERANCE) * whole) {
            own.iter_mut().for_each(|node: &mut NewNode<D>| node.volume *= exact / volume);
        }
        if volume < (1.0 - HEIGHT_TOLERANCE) * whole {
            warnings.push(below_bed_warning(number, 1.0 - volume / whole));
        }
        warnings.extend(thick_release_warning(number, &own, options.spacing));
        assign_to_phases(options, &mut sets, own, body);
    }
    if sets.iter().all(Vec::is_empty) {
        let problem = "no body covers a point of the lattice: make methods.depth-sph.spacing smaller";
        return Err(CaseError::new("bodies", CaseErrorKind::coded("empty-body", problem)));
    }
    Ok(BodyNodes { sets, transferred_pressures: transferred, warnings })
}

/// Largest mean thickness of a release over the square root of its area without a warning.
const MAX_THICKNESS: f64 = 0.5;

/// Warning for a release in plan that is thick for its area: its thickness is probably in another unit, or the level of the ground.
fn thick_release_warning<const D: usize>(
    number: usize,
    nodes: &[NewNode<D>],
    spacing: f64,
) -> Option<Warning> {
    let area = nodes.len() as f64 * spacing.powi(D as i32);
    let thickness = nodes.iter().map(|node| node.volume).sum::<f64>() / area;
    let width = area.sqrt();
    (D == 2 && thickness > MAX_THICKNESS * width).then(|| {
        Warning::new(
            "doubtful-unit",
            format!(
                "bodies[{number}].shape: its mean thickness is {thickness:.4} m over an area of {area:.4e} m², \
                 {width:.4} m wide. Check the unit of the thickness, which is in metres above the ground"
            ),
        )
    })
}

/// Warning of a body of which a share of the volume lies below the bed.
fn below_bed_warning(number: usize, share: f64) -> Warning {
    let below = 100.0 * share;
    Warning::new(
        "body-below-bed",
        format!(
            "bodies[{number}].shape: {below:.1} % of the volume lies below the bed and is left out; only the \
             part above the bed flows. Raise the body, or use a layer on the terrain"
        ),
    )
}

/// Nodes that are made from points, with a pore-pressure profile for each if the case has pore-pressure columns.
type PointNodes<const D: usize> = (Vec<NewNode<D>>, Vec<TransferredPressure>);

/// Nodes from the point list of a body, for a flow density (kg/m³), with their pore pressures; `None` for a body without a point list.
fn nodes_of_points<const D: usize>(
    case: &Case,
    options: &DepthOptions,
    (number, density): (usize, f64),
    bed: &Bed<D>,
    warnings: &mut Vec<Warning>,
) -> Result<Option<PointNodes<D>>, CaseError> {
    let Some(mut list) = case.point_list(number)? else { return Ok(None) };
    // A flow has one density, and the mass of points is kept.
    for (volume, mass) in list.volumes.iter_mut().zip(list.masses.iter().flatten()) {
        *volume = mass / density;
    }
    if list.stresses.is_some() {
        warnings.push(Warning::new("stress-ignored", format!(
            "bodies[{number}].points: the stresses are ignored: depth-integrated flow has no stress. Leave \
             their columns out"
        )));
    }
    if let (None, Some(field), Some(_)) = (
        &list.pore_pressures,
        PorePressureField::for_body(case, options.frame, &case.bodies[number]),
        &options.column,
    ) {
        list.pore_pressures = Some(list.positions.iter().map(|x| field.pressure_at(*x, 1.0)).collect());
    }
    if list.pore_pressures.is_some() && options.column.is_none() {
        warnings.push(Warning::new(
            "pore-pressure-ignored",
            format!(
                "bodies[{number}].points: the pore pressures are ignored: to include them, give \
             methods.depth-sph.column"
            ),
        ));
    }
    transferred_nodes(case, options, number, &list, bed).map(Some)
}

/// Density of the flow of a body (kg/m³).
fn density(options: &DepthOptions, material: &Mixture, body: &Body, upper: bool) -> f64 {
    match (options.phases, upper) {
        (Phases::One, _) => material.density(),
        (Phases::Layers, true) => material.densities.fluid,
        (Phases::Layers, false) => material.densities.grain,
        (Phases::Two, _) => {
            let porosity = options.mixture.as_ref().map_or(0.0, |mixture| mixture.porosity_of(&body.name));
            material.densities.mixture(porosity)
        }
    }
}

/// Volume, first moment and momentum above a square, and the indices of its points.
type SquareSums<const D: usize> = ([[f64; D]; 3], Vec<usize>);

/// Nodes from points of another method (sheet: depth-sph §3.2, 4). The points above a lattice square become one node with their volume,
/// centroid and momentum, and their pore pressures if the case has columns.
fn transferred_nodes<const D: usize>(
    case: &Case,
    options: &DepthOptions,
    number: usize,
    list: &PointList,
    bed: &Bed<D>,
) -> Result<PointNodes<D>, CaseError> {
    let lattice = PlanLattice::<D>::new(case, options.spacing);
    let mut squares: BTreeMap<[i64; D], SquareSums<D>> = BTreeMap::new();
    for (point, (x, volume)) in list.positions.iter().zip(&list.volumes).enumerate() {
        let velocity = match &list.velocities {
            Some(velocities) => velocities[point],
            None => case.bodies[number].velocity.velocity_at(*x),
        };
        let square = std::array::from_fn(|c| ((x[c] - lattice.low[c]) / lattice.spacing).floor() as i64);
        let (sums, points) = squares.entry(square).or_insert_with(|| ([[0.0; D]; 3], Vec::new()));
        points.push(point);
        for c in 0..D {
            sums[0][c] += volume;
            sums[1][c] += volume * x[c];
            sums[2][c] += volume * velocity[c];
        }
    }
    let cells = options.column.as_ref().map(|column| column.cells);
    let (mut nodes, mut transferred) = (Vec::with_capacity(squares.len()), Vec::new());
    for ([volume, moment, momentum], points) in squares.into_values() {
        let position = std::array::from_fn(|c| moment[c] / volume[c]);
        if bed.bed_point(&position).is_none() {
            let origin = case.origin();
            let place: Vec<f64> = (0..D).map(|c| position[c] + origin[c]).collect();
            let problem =
                format!("there is no ground below points at {place:?} m: the raster of the bed ends there");
            return Err(CaseError::new(
                format!("bodies[{number}].points.file"),
                CaseErrorKind::coded("no-data", problem),
            ));
        }
        let mut own = new_node(&case.bodies[number], number, position, volume[0], options);
        own.velocity = std::array::from_fn(|c| momentum[c] / volume[c]);
        nodes.push(own);
        if let (Some(cells), Some(pressures)) = (cells, &list.pore_pressures) {
            let level = |x: &[f64; 3]| bed.bed_point(&std::array::from_fn(|c| x[c])).map(|bed| bed.level);
            let above = |&point: &usize| {
                let x = &list.positions[point];
                Some([list.volumes[point], x[D] - level(x)?, pressures[point]])
            };
            // Beside the end of the bed the bed may exist below their middle only.
            let above: Vec<PointAboveSquare> = points.iter().filter_map(above).collect();
            transferred.push(TransferredPressure::from_points(&above, cells));
        }
    }
    Ok((nodes, transferred))
}

/// Node of a body at a position, with its volume (m³).
pub(super) fn new_node<const D: usize>(
    body: &Body,
    number: usize,
    x: [f64; D],
    volume: f64,
    options: &DepthOptions,
) -> NewNode<D> {
    let velocity = body.velocity.velocity_at(spatial(&x));
    let ratio = options.smoothing_ratio(D);
    NewNode {
        body: number as u32,
        position: x,
        velocity: std::array::from_fn(|c| velocity[c]),
        volume,
        length: ratio * options.spacing,
        scale: ratio.powi(D as i32),
    }
}

/// Position in space of a position in plan, at level 0.
fn spatial(x: &[f64]) -> [f64; 3] {
    std::array::from_fn(|c| x.get(c).copied().unwrap_or(0.0))
}

/// Depth of flow (m), position in plan (m) and bed point below it.
type FlowOverBed<'a, const D: usize> = (f64, &'a [f64; D], &'a BedPoint<D>);

/// Pore pressure over the depth at a position, from the initial field of a body. Without columns only a hydrostatic field is valid.
fn pore_pressure_profile<const D: usize>(
    case: &Case,
    options: &DepthOptions,
    (number, field): (usize, &PorePressureField<'_>),
    under: FlowOverBed<'_, D>,
) -> Result<Option<TransferredPressure>, CaseError> {
    let Some(cells) = options.column.as_ref().map(|column| column.cells) else {
        check_hydrostatic(case, number, field, under)?;
        return Ok(None);
    };
    let (depth, x, bed) = under;
    let at = |k: usize| {
        let mut place = spatial(x);
        place[D] = bed.level + depth * k as f64 / cells as f64;
        // The pressure is zero at the surface.
        if k < cells { field.pressure_at(place, bed.steepness()) } else { 0.0 }
    };
    Ok(Some(TransferredPressure { depth, pressure: (0..=cells).map(at).collect() }))
}

/// Rejects a hydrostatic pressure with a surface other than that of the flow, for a case without pore-pressure columns.
fn check_hydrostatic<const D: usize>(
    case: &Case,
    number: usize,
    field: &PorePressureField<'_>,
    (depth, x, bed): FlowOverBed<'_, D>,
) -> Result<(), CaseError> {
    let top = bed.level + depth;
    match field.surface() {
        Some(surface) if (surface - top).abs() > SURFACE_TOLERANCE * depth => {
            let origin = case.origin();
            let place: Vec<f64> = (0..D).map(|c| x[c] + origin[c]).collect();
            let problem = CaseErrorKind::coded(
                "conflicting-keys",
                format!(
                    "{} m differs from the surface of the flow at {place:?} m, {} m, below which the pore \
                 pressure of depth-sph is hydrostatic: give methods.depth-sph.column for another surface, \
                 or leave `pressure` out",
                    surface + origin[D],
                    top + origin[D]
                ),
            );
            Err(CaseError::new(format!("bodies[{number}].pore_fluid.pressure.surface"), problem))
        }
        _ => Ok(()),
    }
}

/// Assigns the nodes of a body to the node sets of its phases.
pub(super) fn assign_to_phases<const D: usize>(
    options: &DepthOptions,
    sets: &mut [Vec<NewNode<D>>],
    nodes: Vec<NewNode<D>>,
    body: &Body,
) {
    let upper = options.mixture.as_ref().is_some_and(|mixture| mixture.upper.contains(&body.name));
    match options.phases {
        Phases::One => sets[0].extend(nodes),
        Phases::Layers => sets[usize::from(upper)].extend(nodes),
        Phases::Two => {
            let porosity = options.mixture.as_ref().map_or(0.0, |mixture| mixture.porosity_of(&body.name));
            for (set, part) in sets.iter_mut().zip([1.0 - porosity, porosity]) {
                set.extend(nodes.iter().map(|node| NewNode { volume: part * node.volume, ..*node }));
            }
            let Some(velocity) = body.pore_fluid.as_ref().and_then(|fluid| fluid.velocity.as_ref()) else {
                return;
            };
            let first = sets[1].len() - nodes.len();
            for node in &mut sets[1][first..] {
                let own = velocity.velocity_at(spatial(&node.position));
                node.velocity = std::array::from_fn(|c| own[c]);
            }
        }
    }
}

/// Lattice of squares in plan, aligned with the lower corner of the domain.
struct PlanLattice<const D: usize> {
    low: [f64; D],
    spacing: f64,
}

impl<const D: usize> PlanLattice<D> {
    /// Lattice in plan with a spacing (m), from the lower corner of the domain.
    fn new(case: &Case, spacing: f64) -> Self {
        Self { low: std::array::from_fn(|c| case.domain.min[c]), spacing }
    }

    /// Centres of the lattice squares within the bounds of a body, one row after another.
    fn squares_in(&self, body: &Body, dimension: usize) -> Vec<[f64; D]> {
        let (low, high) = body.shape.bounds(dimension);
        let first = |c: usize| ((low[c] - self.low[c]) / self.spacing - 0.5).ceil() as i64;
        let last = |c: usize| ((high[c] - self.low[c]) / self.spacing - 0.5).floor() as i64;
        let place = |c: usize, k: i64| self.low[c] + self.spacing * (k as f64 + 0.5);
        let mut points = vec![[0.0; D]];
        for c in 0..D {
            let extended = |point: &[f64; D]| {
                let point = *point;
                (first(c)..=last(c)).map(move |k| {
                    let mut point = point;
                    point[c] = place(c, k);
                    point
                })
            };
            points = points.iter().flat_map(extended).collect();
        }
        points
    }
}

/// Intervals of a body along the vertical through `x` (m), over a bed at `level` (m).
fn vertical_intervals<const D: usize>(
    body: &Body,
    x: &[f64; D],
    middle: f64,
    level: Option<f64>,
) -> Vec<(f64, f64)> {
    if let (Shape::Layer { laid, .. }, Some(level), [x, y]) = (&body.shape, level, &x[..]) {
        // Its base is the triangulated contact surface, which differs from the bed by the twist of a cell.
        let thickness = laid.layer().map_or(0.0, |layer| layer.thickness(*x, *y));
        return if thickness > 0.0 { vec![(level, level + thickness)] } else { Vec::new() };
    }
    let mut point = x.to_vec();
    point.push(middle);
    let mut cuts = body.shape.crossings(&point, D);
    cuts.sort_by(f64::total_cmp);
    let inside = |pair: &&[f64]| {
        let mut point = x.to_vec();
        point.push(0.5 * (pair[0] + pair[1]));
        pair[1] > pair[0] && body.shape.contains(&point)
    };
    cuts.windows(2).filter(inside).map(|pair| (pair[0], pair[1])).collect()
}

/// Column of a body above a position.
struct BodyColumn {
    /// Thickness above the bed (m).
    thickness_above_bed: f64,
    /// Thickness including the part below the bed (m).
    total_thickness: f64,
    /// Depth of the flow of all bodies (m).
    depth: f64,
}

/// Vertical extent of a body above a position (m); rejects gaps below and within it.
fn body_column<const D: usize>(
    case: &Case,
    number: usize,
    x: &[f64; D],
    bed: &Bed<D>,
) -> Result<BodyColumn, CaseError> {
    let (low, high) = (case.domain.min[D], case.domain.max[D]);
    let slack = HEIGHT_TOLERANCE * (high - low);
    let level = bed.bed_point(x).map(|bed| bed.level);
    let all = |other: &Body| vertical_intervals(other, x, 0.5 * (low + high), level);
    let own = all(&case.bodies[number]);
    let Some(base) = own.first().map(|stretch| stretch.0) else {
        return Ok(BodyColumn { thickness_above_bed: 0.0, total_thickness: 0.0, depth: 0.0 });
    };
    let origin = case.origin();
    let place: Vec<f64> = (0..D).map(|c| x[c] + origin[c]).collect();
    let refuse = |problem: String| Err(CaseError::new(format!("bodies[{number}].shape"), problem));
    let Some(bed) = level else {
        return refuse(format!(
            "there is no ground below it at {place:?} m: the raster of the bed ends there or has no data"
        ));
    };
    let mut all: Vec<(f64, f64)> = case.bodies.iter().flat_map(all).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut top = bed;
    for (from, to) in all {
        if from > top + slack && from <= own.last().map_or(base, |stretch| stretch.0) + slack {
            let [from, to] = [top, from].map(|z| z + origin[D]);
            return refuse(format!(
                "there is a gap from {from} m to {to} m below it at {place:?} m, which depth-integrated \
                 flow cannot have: fill the gap, or use another method"
            ));
        }
        top = top.max(to);
    }
    let thickness_above_bed = own.iter().map(|(from, to)| (to - from.max(bed)).max(0.0)).sum();
    Ok(BodyColumn {
        thickness_above_bed,
        total_thickness: own.iter().map(|(from, to)| to - from).sum(),
        depth: top - bed,
    })
}
