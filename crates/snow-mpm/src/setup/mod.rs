//! From a case to a solver: refuses what the method cannot honour, by JSON path.

mod fill;
mod refuse;

use std::sync::Arc;

use colluvium_case::{
    Case, CaseError, Manufactured, Plan, Resolution, SLACK, Size, Solver, StepLimit, TimeStep,
};
use colluvium_grid::{Node, Sweeps};

pub(crate) use refuse::honours;

use crate::background::{Background, shape};
use crate::bodies::{Bodies, Body};
use crate::config::{NAME, SnowOptions};
use crate::ledger::Ledger;
use crate::maps::Maps;
use crate::nodes::{Nodes, Sums};
use crate::obstacles::Obstacles;
use crate::saw;
use crate::solver::{Clock, Seen, SnowSolver};
use crate::walls::Boundaries;

/// Point-updates per second and thread in the plane and in space, cubic functions and APIC.
const PACE: [f64; 2] = [2.5e6, 0.8e6];

/// An error under a key of the options.
pub(crate) fn own(key: &str, problem: impl Into<String>) -> CaseError {
    CaseError::new(format!("methods.{NAME}.{key}"), problem)
}

/// The options of the case, checked.
pub(crate) fn options(case: &Case) -> Result<SnowOptions, CaseError> {
    if !case.methods.contains_key(NAME) {
        let problem = "is missing: finite-strain MPM needs at least its `cell_size` (m)";
        return Err(CaseError::new(format!("methods.{NAME}"), problem));
    }
    let options: SnowOptions = case.method_options(NAME)?;
    options.validate().map_err(|(key, problem)| own(key, problem))?;
    Ok(options)
}

/// The solver of `case`, under a manufactured solution if there is one.
pub(crate) fn build(case: &Case, solution: Option<Manufactured>) -> Result<Box<dyn Solver>, CaseError> {
    let options = options(case)?;
    let shape = shape(options.shape);
    match case.dimension() {
        1 => built(case, &options, shape.on_line(), solution),
        2 => built(case, &options, shape.in_plane(), solution),
        _ => built(case, &options, shape.in_space(), solution),
    }
}

fn built<const D: usize>(
    case: &Case,
    options: &SnowOptions,
    chosen: Chosen<D>,
    solution: Option<Manufactured>,
) -> Result<Box<dyn Solver>, CaseError> {
    let mut solver = solver(case, options, chosen)?;
    if let Some(solution) = solution {
        solver.begin_manufactured(solution)?;
    }
    Ok(Box::new(solver))
}

/// The plan of `case`.
pub(crate) fn plan(case: &Case) -> Result<Plan, CaseError> {
    let options = options(case)?;
    let shape = shape(options.shape);
    match case.dimension() {
        1 => measured(case, &options, shape.on_line()),
        2 => measured(case, &options, shape.in_plane()),
        _ => measured(case, &options, shape.in_space()),
    }
}

/// The size of `case`, without making its points.
pub(crate) fn size(case: &Case) -> Result<Size, CaseError> {
    let options = options(case)?;
    let dimension = case.dimension();
    let apart = options.cell_size / options.points_per_cell as f64;
    let points = case.points_at(apart);
    let cells = |axis: usize| (case.domain.max[axis] - case.domain.min[axis]) / options.cell_size;
    let nodes: f64 = (0..dimension).map(|axis| cells(axis) + 11.0).product();
    let number = size_of::<f64>();
    // Columns of the points, and what sorting takes of their moments.
    let own = (3 * dimension + 2 * dimension * dimension + 9) * number + 4;
    let mut memory = nodes * size_of::<Node>() as f64;
    for (body, points) in case.bodies.iter().zip(&points) {
        let path = || format!("materials.{}", body.material);
        let law = case.materials[&body.material].build();
        let state = law.map_err(|error| CaseError::new(path(), error.to_string()))?.state_size();
        memory += points * (own + 2 * state + 16) as f64;
    }
    Ok(Size {
        points: points.iter().sum(),
        nodes,
        memory,
        key: "methods.snow-mpm.cell_size",
        ..Size::default()
    })
}

type Chosen<const D: usize> = Option<&'static dyn Sweeps<D>>;

fn measured<const D: usize>(
    case: &Case,
    options: &SnowOptions,
    chosen: Chosen<D>,
) -> Result<Plan, CaseError> {
    let mut solver = solver(case, options, chosen)?;
    let time_step = solver.limit();
    let mut volumes = vec![0.0; case.bodies.len()];
    for body in &solver.bodies.all {
        volumes[body.number as usize] += body.points.volume.iter().sum::<f64>();
    }
    let memory = solver.bodies.all.iter().map(Body::bytes).sum::<usize>() + solver.nodes.bytes();
    Ok(Plan {
        points: solver.bodies.len(),
        nodes: solver.background.layout.len(),
        steps: (case.end_time() / time_step.dt).ceil() as u64,
        time_step,
        memory: memory as u64,
        volumes,
        grains: None,
        densities: None,
        resolution: Some(Resolution {
            width: options.cell_size,
            apart: options.cell_size / options.points_per_cell as f64,
            axes: D,
            key: "methods.snow-mpm.cell_size",
            noun: "cells",
        }),
        updates_per_second: PACE[usize::from(D == 3)],
        warnings: refuse::warnings(case, options),
    })
}

/// The background of a domain that repeats itself, where it does.
fn repeating<const D: usize>(case: &Case, background: Background<D>) -> Result<Background<D>, CaseError> {
    let periodic = std::array::from_fn(|axis| case.domain.is_periodic(axis));
    background.repeating(periodic).map_err(|least| {
        let problem = format!(
            "needs {least} cells or more along each periodic axis, so many do nodes reach beyond its sides"
        );
        CaseError::new("domain.periodic", problem)
    })
}

/// A solver with its concrete type, at time zero.
fn solver<const D: usize>(
    case: &Case,
    options: &SnowOptions,
    chosen: Chosen<D>,
) -> Result<SnowSolver<D>, CaseError> {
    let sweeps = chosen.ok_or_else(|| own("shape", "is not available in so many dimensions"))?;
    let corner = |values: &[f64]| std::array::from_fn(|axis| values[axis]);
    let corners = [corner(&case.domain.min), corner(&case.domain.max)];
    refuse::thin_layers(case, options)?;
    saw::refuse(case)?;
    let background = Background::new(corners, options.cell_size, sweeps)
        .map_err(|error| own("cell_size", error.to_string()))?;
    let background = repeating(case, background)?;
    let standing = case.standing::<D>()?;
    let mut all = Vec::new();
    let mut next = 0;
    for number in 0..case.bodies.len() {
        let body = fill::body(case, options, &background, number, next)?;
        next += body.points.len();
        let slack = SLACK * options.cell_size;
        case.refuse_covered(&standing, number, &body.points.position, slack)?;
        all.push(body);
    }
    let obstacles = Obstacles::new(case, &standing, &background)?;
    let nothing = TimeStep { dt: f64::INFINITY, limit: StepLimit::NOTHING, point: None, position: [0.0; 3] };
    let clock = Clock {
        stage: 0,
        stage_start: 0.0,
        time: 0.0,
        step: 0,
        limit: nothing,
        sums: Sums::default(),
        external: 0.0,
        seen: Seen::default(),
    };
    let mut solver = SnowSolver {
        case: Arc::new(case.clone()),
        options: options.clone(),
        nodes: Nodes::new(&background.layout),
        boundaries: Boundaries::new(case, 0, &background, Arc::new(obstacles.rest().clone())),
        obstacles,
        background,
        bodies: Bodies::new(all),
        ledger: Ledger::default(),
        maps: Maps::of(case, options.cell_size)?,
        manufactured: None,
        blades: case.cuts.iter().map(|cut| cut.bounds(D)).collect(),
        clock,
    };
    solver.bodies.sort(&mut solver.background);
    solver.ledger = Ledger::new(&solver.stored(), case.cuts.len());
    solver.set_paces();
    if let Some(maps) = &mut solver.maps {
        maps.follow(&solver.bodies, 0.0);
    }
    match solver.clock.limit.too_long(options.time_step) {
        Some(problem) => Err(own("time_step", problem)),
        None => Ok(solver),
    }
}
