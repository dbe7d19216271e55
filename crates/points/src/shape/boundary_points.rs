//! Surface of a shape as area vectors, and the points next to it.

use crate::search::neighbours::CellList;
use crate::shape::Shape;

/// Patch of the surface of a shape: an area normal to one axis, with a sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePatch<const D: usize> {
    /// Centre of the patch (m).
    pub position: [f64; D],
    /// Axis normal to the patch.
    pub axis: usize,
    /// Area (m²; m in the plane, without unit on a line), positive where the outward normal points along the axis.
    pub area: f64,
}

/// Length over the extent of the shape, below which an interval is empty.
const EMPTY_INTERVAL: f64 = 1e-12;

impl Shape {
    /// Surface patches of a valid shape, at its intersections with lines along each axis. The lines are at most `step` (m) apart. Each line
    /// represents its share of the area normal to it, so that the vectors of the patches sum up to that of any part of the surface, curved
    /// or not, and to zero over the whole surface. A face normal to an axis has its exact area.
    pub fn surface_patches<const D: usize>(&self, step: f64) -> Vec<SurfacePatch<D>> {
        let (low, high) = self.bounds(D);
        let counts: [usize; D] =
            std::array::from_fn(|c| ((high[c] - low[c]) / step).ceil().max(1.0) as usize);
        let widths: [f64; D] = std::array::from_fn(|c| (high[c] - low[c]) / counts[c] as f64);
        let mut pieces = Vec::new();
        for axis in 0..D {
            let across = || (0..D).filter(move |c| *c != axis);
            let area: f64 = across().map(|c| widths[c]).product();
            for number in 0..across().map(|c| counts[c]).product() {
                let (mut line, mut rest) = ([0.0; D], number);
                for c in across() {
                    line[c] = low[c] + widths[c] * ((rest % counts[c]) as f64 + 0.5);
                    rest /= counts[c];
                }
                self.line_intervals(&line, axis, EMPTY_INTERVAL * (high[axis] - low[axis]), |at, leaves| {
                    let mut position = line;
                    position[axis] = at;
                    pieces.push(SurfacePatch { position, axis, area: if leaves { area } else { -area } });
                });
            }
        }
        pieces
    }

    /// Calls `found` with each coordinate along `axis` (m) at which a line enters or leaves the shape. The second argument is whether the
    /// line leaves it.
    fn line_intervals<const D: usize>(
        &self,
        line: &[f64; D],
        axis: usize,
        nothing: f64,
        mut found: impl FnMut(f64, bool),
    ) {
        let mut cuts = self.crossings(line, axis);
        cuts.sort_by(f64::total_cmp);
        let mut end = None;
        for pair in cuts.windows(2).filter(|pair| pair[1] - pair[0] > nothing) {
            let mut middle = *line;
            middle[axis] = 0.5 * (pair[0] + pair[1]);
            match (end, self.contains(&middle)) {
                (None, true) => found(pair[0], false),
                (Some(end), false) => found(end, true),
                _ => {}
            }
            end = self.contains(&middle).then_some(pair[1]);
        }
        if let Some(end) = end {
            found(end, true);
        }
    }
}

/// Area vectors (m²; m in the plane) of the surface of a shape, distributed to the nearest points. They are sums over surface patches times
/// `weight` at their positions, and zero for inner points. The lines of the patches are a `share` of the spacing apart; with a quarter,
/// none lies halfway between two points of a lattice.
pub fn boundary_area_vectors<const D: usize>(
    shape: &Shape,
    positions: &[[f64; D]],
    (spacing, share): (f64, f64),
    weight: impl Fn(&[f64; D]) -> f64,
) -> Vec<[f64; D]> {
    let pieces = shape.surface_patches::<D>(share * spacing);
    let mut vectors = vec![[0.0; D]; positions.len()];
    let mut cells = CellList::new();
    if positions.is_empty() || cells.build(positions, spacing).is_err() {
        return vectors;
    }
    for piece in pieces {
        let weight = weight(&piece.position);
        if weight != 0.0 {
            vectors[nearest_point(&cells, positions, &piece.position)][piece.axis] += weight * piece.area;
        }
    }
    vectors
}

/// Index of the position nearest to `place`; the first one of equally near ones.
fn nearest_point<const D: usize>(cells: &CellList<D>, positions: &[[f64; D]], place: &[f64; D]) -> usize {
    let square = |p: usize| -> f64 { positions[p].iter().zip(place).map(|(x, y)| (x - y).powi(2)).sum() };
    let nearer = |best: (f64, usize), p: usize| if (square(p), p) < best { (square(p), p) } else { best };
    let mut best = (f64::INFINITY, usize::MAX);
    cells.visit(place, |p| best = nearer(best, p as usize));
    if best.1 == usize::MAX {
        best = (0..positions.len()).fold(best, nearer);
    }
    best.1
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn disk(radius: f64) -> Shape {
        Shape::Ball { centre: vec![0.3, -0.2], radius }
    }

    fn total<const D: usize>(pieces: &[SurfacePatch<D>], keep: impl Fn(&[f64; D]) -> bool) -> [f64; D] {
        let mut sum = [0.0; D];
        pieces.iter().filter(|piece| keep(&piece.position)).for_each(|piece| sum[piece.axis] += piece.area);
        sum
    }

    #[test]
    fn areas_of_a_closed_surface_cancel_and_those_of_a_part_are_its_projections() {
        let ring = Shape::Difference { from: Box::new(disk(1.0)), cut: Box::new(disk(0.5)) };
        let pieces = ring.surface_patches::<2>(1e-3);
        assert!(total(&pieces, |_| true).iter().all(|sum| sum.abs() < 1e-12));
        // The hole faces inwards: its right half has the area vector -1 along x, the width of the hole.
        let within = |x: &[f64; 2]| (x[0] - 0.3).hypot(x[1] + 0.2) < 0.75;
        let [x, y] = total(&pieces, |place| within(place) && place[0] > 0.3);
        assert!((x + 1.0).abs() < 3e-3 && y.abs() < 3e-3, "{x} {y}");
        // Divergence theorem: the flux of the position vector is twice the area.
        let flux: f64 = pieces.iter().map(|piece| piece.position[piece.axis] * piece.area).sum();
        assert!((flux / 2.0 / (0.75 * PI) - 1.0).abs() < 1e-5, "{flux}");
    }

    #[test]
    fn a_cylinder_has_its_ends_and_a_box_its_faces() {
        let cylinder = Shape::Cylinder { base: [0.0; 3], axis: 1, radius: 0.5, height: 2.0 };
        let pieces = cylinder.surface_patches::<3>(0.02);
        let [_, top, _] = total(&pieces, |place| place[1] > 1.99 && place[0].hypot(place[2]) < 0.499);
        assert!((top / (0.25 * PI) - 1.0).abs() < 0.01, "{top}");
        let flux: f64 = pieces.iter().map(|piece| piece.position[piece.axis] * piece.area).sum();
        // Fifty lines across a circle have its area to 0.3 %.
        assert!((flux / 3.0 / (0.5 * PI) - 1.0).abs() < 5e-3, "{flux}");
        let cube = Shape::Box { min: vec![0.0, 0.0, 0.0], max: vec![1.0, 2.0, 3.0] };
        let right = total(&cube.surface_patches::<3>(0.3), |place| place[0] == 1.0);
        assert!((right[0] - 6.0).abs() < 1e-12 && right[1] == 0.0 && right[2] == 0.0, "{right:?}");
    }

    #[test]
    fn each_point_next_to_a_face_has_its_own_part_of_it() {
        let square = Shape::Box { min: vec![0.0, 0.0], max: vec![1.0, 1.0] };
        let place = |k: usize| [0.05 + 0.1 * (k % 10) as f64, 0.05 + 0.1 * (k / 10) as f64];
        let points: Vec<[f64; 2]> = (0..100).map(place).collect();
        let vectors =
            boundary_area_vectors(&square, &points, (0.1, 0.25), |x| if x[1] > 0.999 { 2.0 } else { 0.0 });
        for (k, vector) in vectors.iter().enumerate() {
            let share = if k >= 90 { 0.2 } else { 0.0 };
            assert!((vector[1] - share).abs() < 1e-12 && vector[0].abs() < 1e-12, "{k}: {vector:?}");
        }
    }
}
