//! Points in rows along the sides of a shape in the plane, each with the area of its own patch.

mod boundary_rows;
mod voronoi_patches;

use crate::sampling::fitted::voronoi_patches::VoronoiPatches;

use super::{CandidateCells, Sample, SamplingError};
use crate::Shape;
use crate::search::neighbours::CellList;
use crate::shape::{BoundaryEdge, PlanePoint};

/// Share of a spacing within which points of the lattice that fill what rows leave keep away from others.
const LATTICE_CLEARANCE: f64 = 0.8;

/// The same of single points, where even so a place would be too far from all.
const FILL_CLEARANCE: f64 = 0.9;

/// Share by which the area of a patch may differ from the square of the spacing before its point and those around it are moved.
const MAX_AREA_DEVIATION: f64 = 0.15;

/// Moves of uneven points to the middle of their patches (Lloyd 1982).
const MAX_RELAXATIONS: usize = 30;

/// How far from an uneven point others are moved too, in spacings.
const RELAXATION_RADIUS: f64 = 2.0;

/// Points next to a side, nearer than this (in spacings), stay where they are.
const FIXED_DISTANCE: f64 = 0.8;

/// Share of the area that may be lost to round-off.
const MAX_LOST_AREA: f64 = 1e-9;

/// A region with its sides.
pub(super) struct PlanarRegion<'a> {
    pub(super) shape: &'a Shape,
    pub(super) sides: Vec<BoundaryEdge>,
    pub(super) spacing: f64,
}

impl PlanarRegion<'_> {
    /// Distance of a place from the nearest side (m).
    fn distance_to_boundary(&self, x: PlanePoint) -> f64 {
        self.sides.iter().map(|side| side.distance(x)).fold(f64::INFINITY, f64::min)
    }
}

/// Points in rows along the sides of a shape in the plane, about a `spacing` (m) apart: the first half a spacing from the side, round
/// sides before straight ones, until the rows of two sides meet. What they leave is filled from the lattice that begins at `origin`
/// (m), and points that lie unevenly there are moved. Each point lies at the centre of its patch, what is nearer to it than to the
/// others, and has its exact area, so that the areas and their moments sum up to those of the shape. In columns, from low to high.
///
/// # Errors
/// When the shape has other than straight and round sides or is too thin in places, when there would be more than 2²⁸ candidates, or
/// the spacing is not a length.
pub fn fitted<const D: usize>(
    shape: &Shape,
    origin: [f64; D],
    spacing: f64,
) -> Result<Vec<Sample<D>>, SamplingError> {
    if D != 2 {
        return Err(SamplingError::NoBoundaryEdges);
    }
    let samples = in_plane(shape, [origin[0], origin[1]], spacing)?;
    let in_space = |sample: Sample<2>| Sample {
        position: std::array::from_fn(|c| sample.position[c]),
        volume: sample.volume,
    };
    Ok(samples.into_iter().map(in_space).collect())
}

fn in_plane(shape: &Shape, origin: PlanePoint, spacing: f64) -> Result<Vec<Sample<2>>, SamplingError> {
    let cells = CandidateCells::covering(shape, origin, spacing, 1.0)?;
    let sides = shape.boundary_edges().ok_or(SamplingError::NoBoundaryEdges)?;
    let region = PlanarRegion { shape, sides, spacing };
    let mut apart = boundary_rows::rows_along_boundary(&region);
    fill(&region, cells.first, cells.count, origin, &mut apart);
    let mut points = apart.into_points();
    relax_uneven_points(&region, &mut points);
    let patches = VoronoiPatches::new(&region, &points);
    let mut samples: Vec<(PlanePoint, f64)> =
        (0..points.len()).map(|i| patches.centroid_and_area(i)).collect();
    for ((centre, _), point) in samples.iter_mut().zip(&points) {
        if !shape.contains(centre) {
            *centre = *point;
        }
    }
    let reference =
        [cells.first[0] as f64 * spacing + origin[0], cells.first[1] as f64 * spacing + origin[1]];
    let exact: f64 = region.sides.iter().map(|side| side.sector_moments(reference).area).sum();
    let found: f64 = samples.iter().map(|(_, area)| area).sum();
    if (found - exact).abs() > MAX_LOST_AREA * exact {
        return Err(SamplingError::TooThin { spacing, lost: 1.0 - found / exact });
    }
    let column = |x: &PlanePoint| ((x[0] - origin[0]) / spacing).floor();
    samples.sort_by(|(a, _), (b, _)| column(a).total_cmp(&column(b)).then(a[1].total_cmp(&b[1])));
    Ok(samples.into_iter().map(|(position, volume)| Sample { position, volume }).collect())
}

/// Fills what the rows leave: first from the lattice, then by single points where there is room for one.
fn fill(
    region: &PlanarRegion<'_>,
    first: [i64; 2],
    count: [i64; 2],
    origin: PlanePoint,
    points: &mut boundary_rows::SpacedPoints,
) {
    let spacing = region.spacing;
    for (parts, apart) in [(1i64, LATTICE_CLEARANCE), (4, FILL_CLEARANCE)] {
        let edge = spacing / parts as f64;
        for number in 0..count[0] * count[1] * parts * parts {
            let [column, row] = [number / (count[1] * parts), number % (count[1] * parts)];
            let place = |c: usize, k: i64| origin[c] + ((first[c] * parts + k) as f64 + 0.5) * edge;
            let x = [place(0, column), place(1, row)];
            // On a side a point would have half a patch.
            if points.is_free(x, apart * spacing)
                && region.shape.contains(&x)
                && (parts > 1 || region.distance_to_boundary(x) > 0.25 * spacing)
            {
                points.add(x);
            }
        }
    }
}

/// Moves points of uneven patches, and those around them but for the ones next to a side, to the middle of their patches.
fn relax_uneven_points(region: &PlanarRegion<'_>, points: &mut [PlanePoint]) {
    let (spacing, whole) = (region.spacing, region.spacing * region.spacing);
    let uneven: Vec<PlanePoint> = {
        let patches = VoronoiPatches::new(region, points);
        let off = |i: &usize| (patches.centroid_and_area(*i).1 / whole - 1.0).abs() > MAX_AREA_DEVIATION;
        (0..points.len()).filter(off).map(|i| points[i]).collect()
    };
    let mut near = CellList::new();
    if uneven.is_empty() || near.build(&uneven, RELAXATION_RADIUS * spacing).is_err() {
        return;
    }
    let moves = |x: &PlanePoint| {
        let mut nearest = f64::INFINITY;
        near.visit(x, |j| {
            let other = uneven[j as usize];
            nearest = nearest.min((x[0] - other[0]).hypot(x[1] - other[1]));
        });
        nearest < 1e-9 * spacing
            || (nearest < RELAXATION_RADIUS * spacing
                && region.distance_to_boundary(*x) > FIXED_DISTANCE * spacing)
    };
    let free: Vec<usize> = (0..points.len()).filter(|i| moves(&points[*i])).collect();
    for _ in 0..MAX_RELAXATIONS {
        let patches = VoronoiPatches::new(region, points);
        let moved: Vec<PlanePoint> = free.iter().map(|i| patches.centroid_and_area(*i).0).collect();
        drop(patches);
        for (i, x) in free.iter().zip(moved) {
            if region.shape.contains(&x) {
                points[*i] = x;
            }
        }
    }
}

#[cfg(test)]
mod tests;
