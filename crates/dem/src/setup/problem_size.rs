//! Estimate of the number of grains, and of memory and time to place them.

use colluvium_case::description::Body;
use colluvium_case::{Case, CaseError, ProblemSize};

use crate::config::{DemOptions, Diameters, Fill, LatticePacking};
use crate::points::grains::volume;
use crate::setup::{BYTES_OF_GRAIN, options};
use crate::specimen::file::StoredSpecimen;
use crate::specimen::pluviation;

/// Memory of a grain during placement, with its neighbours (bytes).
const BYTES_OF_PLACED: f64 = 300.0;
/// Solid fraction of disks and of spheres placed by drop and roll (Visscher and Bolsterli 1972).
const DROP_AND_ROLL_FRACTIONS: [f64; 2] = [0.82, 0.58];

/// Expected number of grains of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct ExpectedGrains {
    /// Number of grains that the body will have.
    grains: f64,
    /// Number of grains placed in the box around the body, some of which are cut away.
    placed_grains: f64,
    /// Time of the placement (s).
    seconds: f64,
}

/// Approximate size of the problem.
pub fn problem_size(case: &Case) -> Result<ProblemSize, CaseError> {
    let options = options(case)?;
    let stored = StoredSpecimen::of_case(case, &options)?;
    let given = stored.as_ref().map(StoredSpecimen::counts).unwrap_or_default();
    let of_body = |(number, body): (usize, &Body)| match given.get(body.name.as_str()) {
        Some(count) => ExpectedGrains { grains: *count as f64, ..ExpectedGrains::default() },
        None => expected_grains(case, &options, number),
    };
    let all: Vec<ExpectedGrains> = case.bodies.iter().enumerate().map(of_body).collect();
    let end = case.end_time();
    let sources = pluviation::sources(case, &options);
    let rain: f64 = sources.iter().map(|source| source.expected_count(case.dimension(), end)).sum();
    let points = all.iter().map(|own| own.grains).sum::<f64>() + rain;
    // Bodies are placed one after another.
    let placed = all.iter().map(|own| own.placed_grains).fold(0.0, f64::max);
    Ok(ProblemSize {
        points,
        memory: (points * BYTES_OF_GRAIN[case.dimension() - 2] as f64).max(placed * BYTES_OF_PLACED),
        case_key: "methods.dem.grains",
        placing_time: all.iter().map(|own| own.seconds).sum(),
        advice: "use larger grains or smaller bodies",
        ..ProblemSize::default()
    })
}

/// Expected number of grains of a body and the time to place them, before they are placed.
fn expected_grains(case: &Case, options: &DemOptions, number: usize) -> ExpectedGrains {
    let (body, dimension) = (&case.bodies[number], case.dimension());
    let listed = |grains| ExpectedGrains { grains, ..ExpectedGrains::default() };
    if options.bodies.get(&body.name).is_some_and(|own| own.pluviation.is_some()) {
        return listed(0.0);
    }
    if body.points.is_some() {
        return listed(case.point_counts(1.0)[number]);
    }
    match (options.fill_of_body(body), &options.grains[&body.material].diameter) {
        (Some(Fill::Single) | None, _) | (_, None) => listed(1.0),
        (Some(fill), Some(sizes)) => filled_box(body, fill, sizes, dimension),
    }
}

/// Expected number of grains in a shape that is filled, from the volume of its bounding box.
fn filled_box(body: &Body, fill: Fill, sizes: &Diameters, dimension: usize) -> ExpectedGrains {
    let (low, high) = body.shape.bounds(dimension);
    let space: f64 = low.iter().zip(&high).take(dimension).map(|(low, high)| high - low).product();
    let of_shape = body.shape.volume(dimension, false) / space;
    let solid = volume(dimension, 0.5) * sizes.mean_power(dimension, dimension as i32);
    let of_sleeve = |grains: f64| ExpectedGrains { grains, placed_grains: grains, seconds: 1e-5 * grains };
    let placed_grains = match fill {
        Fill::Single => 1.0,
        Fill::Lattice { packing, pitch, .. } => {
            let pitch = pitch.unwrap_or(sizes.range().1);
            space / (site(packing, dimension) * pitch.powi(dimension as i32))
        }
        Fill::Random { solid_fraction } | Fill::Layers { solid_fraction, .. } => {
            solid_fraction * space / solid
        }
        Fill::Sleeve { columns } => {
            return of_sleeve(crate::setup::sleeve_rings::count(&body.shape, sizes, columns));
        }
        Fill::DropAndRoll => DROP_AND_ROLL_FRACTIONS[dimension - 2] * space / solid,
    };
    ExpectedGrains {
        grains: of_shape * placed_grains,
        placed_grains,
        seconds: placed_grains * seconds_each(fill, dimension, placed_grains),
    }
}

/// Area or volume per site of a lattice of unit pitch.
fn site(packing: LatticePacking, dimension: usize) -> f64 {
    match (packing, dimension) {
        (LatticePacking::Square, _) => 1.0,
        (LatticePacking::Hexagonal, 2) => 0.75f64.sqrt(),
        (LatticePacking::Hexagonal | LatticePacking::FaceCentred, _) => 0.5f64.sqrt(),
        (LatticePacking::BodyCentred, _) => 4.0 / 27f64.sqrt(),
    }
}

/// Time to place a grain out of `count` (s), measured on one thread of a desktop computer (docs/theory/dem.md).
fn seconds_each(fill: Fill, dimension: usize, count: f64) -> f64 {
    let flat = dimension == 2;
    match fill {
        Fill::Single | Fill::Lattice { .. } | Fill::Sleeve { .. } => 1e-5,
        Fill::DropAndRoll => {
            if flat {
                3e-5
            } else {
                1.6e-4
            }
        }
        Fill::Random { solid_fraction } => relaxation_time(solid_fraction, flat, count),
        Fill::Layers { solid_fraction, layers, .. } => {
            // All grains below a layer are pushed with it, and for longer.
            9.0 * relaxation_time(solid_fraction, flat, count) * 0.5 * (layers + 1) as f64
        }
    }
}

/// Relaxation time of a grain out of `count` (s). It increases towards the densest random packing and with the number of grains.
fn relaxation_time(solid_fraction: f64, flat: bool, count: f64) -> f64 {
    let (scale, densest) = if flat { (1.2e-5, 0.84) } else { (1.6e-5, 0.64) };
    scale / (densest - solid_fraction).max(0.01) * (count / 3e4).powf(0.28)
}
