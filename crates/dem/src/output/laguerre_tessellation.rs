//! Laguerre tessellation of disks (power diagram) by half-planes, and its dual triangulation (sheet: dem §3.9).
//!
//! A point belongs to the disk with the shortest tangent from it. Two disks in contact share the tangent at their contact; the
//! cells fill the domain without gaps. For disks of one size they are Voronoi cells, and the triangles Delaunay triangles.

use rayon::prelude::*;

use crate::boundary::periodic_cell::{PeriodicCell, inverse};
use crate::output::packing_view::PackingView;
use crate::points::vector::{difference, dot};

/// Distance of the farthest corner of a cell, over the mean diameter, above which it is a surface cell.
const SURFACE: f64 = 3.0;

/// Width of the search bins over the mean diameter.
const BIN_WIDTH: f64 = 2.0;

/// Laguerre cells and dual triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tessellation {
    /// Area of the cell of each grain (m²).
    pub area: Vec<f64>,
    /// Whether the cell is at the surface: unbounded, or with a corner farther than three mean diameters.
    pub surface: Vec<bool>,
    /// Grains whose cells have a common corner, anticlockwise from the lowest number; none across a periodic boundary.
    pub triangles: Vec<[usize; 3]>,
}

/// Neighbour across an edge of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
enum CellEdge {
    /// Wall, or boundary of the domain.
    Boundary,
    /// Another grain, or an image of it.
    Grain { number: usize, image: bool },
}

/// Corner of a cell relative to the centre of the grain (m), and the neighbour across the edge that follows it anticlockwise.
type CellCorner = ([f64; 2], CellEdge);

/// Clips a polygon to the half-plane `normal · x ≤ limit`.
fn clip(
    polygon: &mut Vec<CellCorner>,
    room: &mut Vec<CellCorner>,
    normal: &[f64; 2],
    limit: f64,
    side: CellEdge,
) {
    let over = |x: &[f64; 2]| dot(normal, x) - limit;
    if polygon.iter().all(|(x, _)| over(x) <= 0.0) {
        return;
    }
    room.clear();
    for (k, (a, own)) in polygon.iter().enumerate() {
        let (b, _) = &polygon[(k + 1) % polygon.len()];
        let (da, db) = (over(a), over(b));
        let between = || {
            let share = da / (da - db);
            [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]
        };
        match (da <= 0.0, db <= 0.0) {
            (true, true) => room.push((*a, *own)),
            (true, false) => {
                room.push((*a, *own));
                room.push((between(), side));
            }
            (false, true) => room.push((between(), *own)),
            (false, false) => {}
        }
    }
    std::mem::swap(polygon, room);
}

/// Grains sorted into search bins.
struct GrainBins<'a> {
    /// Positions, wrapped into the periods (m).
    position: Vec<[f64; 2]>,
    cell: &'a PeriodicCell<2>,
    unit: [[f64; 2]; 2],
    count: [i64; 2],
    /// Smallest width of a bin (m).
    width: f64,
    bin_offsets: Vec<usize>,
    order: Vec<usize>,
}

impl<'a> GrainBins<'a> {
    /// Bins of grain centres in a periodic cell; `mean` is the mean diameter (m).
    fn new(position: &[[f64; 2]], cell: &'a PeriodicCell<2>, mean: f64) -> Self {
        let unit = inverse(&cell.h).0;
        let back = |x: &[f64; 2]| {
            let s = cell.reduced(&unit, x);
            let steps = [0, 1].map(|c| if cell.periodic[c] { s[c].floor() as i32 } else { 0 });
            difference(x, &cell.shift(&steps))
        };
        let position: Vec<[f64; 2]> = position.iter().map(back).collect();
        let widths = cell.widths();
        let largest = (position.len() as f64).sqrt().ceil().max(1.0) * 4.0;
        let count = widths.map(|width| (width / (BIN_WIDTH * mean)).floor().clamp(1.0, largest) as i64);
        let width = (widths[0] / count[0] as f64).min(widths[1] / count[1] as f64);
        let (bin_offsets, order) = (vec![0; (count[0] * count[1]) as usize + 1], vec![0; position.len()]);
        let mut bins = Self { position, cell, unit, count, width, bin_offsets, order };
        let keys: Vec<usize> = bins
            .position
            .iter()
            .map(|x| {
                let [a, b] = bins.bin_index(x);
                (b * count[0] + a) as usize
            })
            .collect();
        keys.iter().for_each(|key| bins.bin_offsets[key + 1] += 1);
        for key in 1..bins.bin_offsets.len() {
            bins.bin_offsets[key] += bins.bin_offsets[key - 1];
        }
        let mut next = bins.bin_offsets.clone();
        for (i, key) in keys.iter().enumerate() {
            bins.order[next[*key]] = i;
            next[*key] += 1;
        }
        bins
    }

    /// Index of the bin of a position along both axes.
    fn bin_index(&self, x: &[f64; 2]) -> [i64; 2] {
        let s = self.cell.reduced(&self.unit, x);
        std::array::from_fn(|c| ((s[c] * self.count[c] as f64).floor() as i64).clamp(0, self.count[c] - 1))
    }

    /// Calls `visit` for each grain in the bins at the distance `ring` (in bins), with its position relative to `x` and whether it is an
    /// image.
    fn ring(&self, x: &[f64; 2], ring: i64, mut visit: impl FnMut(usize, [f64; 2], bool)) {
        let own = self.bin_index(x);
        for b in -ring..=ring {
            let step = if b.abs() == ring || ring == 0 { 1 } else { 2 * ring };
            for a in (-ring..=ring).step_by(step as usize) {
                let place = [own[0] + a, own[1] + b];
                let steps: [i64; 2] = std::array::from_fn(|c| place[c].div_euclid(self.count[c]));
                if (0..2).any(|c| steps[c] != 0 && !self.cell.periodic[c]) {
                    continue;
                }
                let shift = self.cell.shift(&steps.map(|step| step as i32));
                let inner: [i64; 2] = std::array::from_fn(|c| place[c].rem_euclid(self.count[c]));
                let key = (inner[1] * self.count[0] + inner[0]) as usize;
                for &j in &self.order[self.bin_offsets[key]..self.bin_offsets[key + 1]] {
                    let apart = difference(&self.position[j], x);
                    visit(j, [apart[0] + shift[0], apart[1] + shift[1]], steps != [0; 2]);
                }
            }
        }
    }
}

/// Laguerre cell of grain `i` among disks with given radii (m); `ends` are half-planes `normal · x ≤ limit` that bound the domain.
fn polygon(
    i: usize,
    bins: &GrainBins<'_>,
    radius: &[f64],
    largest: f64,
    ends: &[([f64; 2], f64)],
) -> Vec<CellCorner> {
    let x = bins.position[i];
    let half = 2.0 * (bins.cell.widths()[0] + bins.cell.widths()[1]);
    let corners = [[-half, -half], [half, -half], [half, half], [-half, half]];
    let mut polygon: Vec<CellCorner> = corners.map(|corner| (corner, CellEdge::Boundary)).to_vec();
    let mut room = Vec::new();
    for (normal, limit) in ends {
        clip(&mut polygon, &mut room, normal, limit - dot(normal, &x), CellEdge::Boundary);
    }
    let maximum = 2 * bins.count[0].max(bins.count[1]) + 2;
    for ring in 0..=maximum {
        let smallest = (ring - 1) as f64 * bins.width;
        let reach = polygon.iter().map(|(x, _)| dot(x, x)).fold(0.0, f64::max).sqrt();
        // No disk beyond this distance cuts the cell.
        if ring > 1 && 0.5 * (smallest + (radius[i].powi(2) - largest.powi(2)) / smallest) > reach {
            break;
        }
        bins.ring(&x, ring, |j, apart, image| {
            let square = dot(&apart, &apart);
            if square > 0.0 && (j != i || image) {
                let limit = 0.5 * (square + radius[i].powi(2) - radius[j].powi(2));
                clip(&mut polygon, &mut room, &apart, limit, CellEdge::Grain { number: j, image });
            }
        });
    }
    polygon
}

/// Laguerre tessellation of disks in a box bounded by the half-planes `ends`, periodic along some of its axes.
pub fn tessellate(
    position: &[[f64; 2]],
    radius: &[f64],
    cell: &PeriodicCell<2>,
    ends: &[([f64; 2], f64)],
) -> Tessellation {
    if position.is_empty() {
        return Tessellation::default();
    }
    let mean = 2.0 * radius.iter().sum::<f64>() / radius.len() as f64;
    let largest = radius.iter().copied().fold(0.0, f64::max);
    let bins = GrainBins::new(position, cell, mean);
    let cells: Vec<(f64, bool, Vec<[usize; 3]>)> = (0..position.len())
        .into_par_iter()
        .map(|i| {
            let polygon = polygon(i, &bins, radius, largest, ends);
            let count = polygon.len();
            let pairs = || (0..count).map(|k| (&polygon[k], &polygon[(k + 1) % count]));
            let twice: f64 = pairs().map(|((a, _), (b, _))| a[0] * b[1] - a[1] * b[0]).sum();
            let reach = polygon.iter().map(|(x, _)| dot(x, x)).fold(0.0, f64::max).sqrt();
            let meet = |((_, before), (_, after)): (&CellCorner, &CellCorner)| match (before, after) {
                (
                    CellEdge::Grain { number: j, image: false },
                    CellEdge::Grain { number: k, image: false },
                ) if i < *j && i < *k => Some([i, *j, *k]),
                _ => None,
            };
            (0.5 * twice, count == 0 || reach > SURFACE * mean, pairs().filter_map(meet).collect())
        })
        .collect();
    let mut out = Tessellation::default();
    for (area, surface, triangles) in cells {
        out.area.push(area);
        out.surface.push(surface);
        out.triangles.extend(triangles);
    }
    out
}

/// Gradient `∂u_a/∂x_b` of a linear field on a triangle from its corner values; `None` for a triangle without area.
pub fn gradient(corners: [[f64; 2]; 3], values: [[f64; 2]; 3]) -> Option<[[f64; 2]; 2]> {
    let (p, q) = (difference(&corners[1], &corners[0]), difference(&corners[2], &corners[0]));
    let (u, v) = (difference(&values[1], &values[0]), difference(&values[2], &values[0]));
    let twice = p[0] * q[1] - p[1] * q[0];
    (twice != 0.0).then(|| {
        std::array::from_fn(|a| [(u[a] * q[1] - v[a] * p[1]) / twice, (v[a] * p[0] - u[a] * q[0]) / twice])
    })
}

impl<const D: usize, const R: usize> PackingView<'_, D, R> {
    /// Laguerre tessellation of the present disks, within the domain and its plane walls; empty in space.
    pub fn tessellation(&self) -> Tessellation {
        if D != 2 {
            return Tessellation::default();
        }
        let flat = |x: &[f64; D]| [x[0], x[1]];
        let own = &self.cell.geometry;
        let cell = PeriodicCell::<2> {
            origin: flat(&own.origin),
            h: [flat(&own.h[0]), flat(&own.h[1])],
            periodic: [own.periodic[0], own.periodic[1]],
            velocity_gradient: [[0.0; 2]; 2],
            mean_velocity_gradient: [[0.0; 2]; 2],
        };
        let mut ends = Vec::new();
        for axis in (0..2).filter(|axis| !cell.periodic[*axis]) {
            let (low, high) = (cell.origin[axis], cell.origin[axis] + cell.h[axis][axis]);
            for (sign, limit) in [(-1.0, -low), (1.0, high)] {
                let mut normal = [0.0; 2];
                normal[axis] = sign;
                ends.push((normal, limit));
            }
        }
        for wall in self.boundary.walls.iter().filter(|wall| wall.surface.is_none()) {
            let (sign, mut normal) = (if wall.is_upper { 1.0 } else { -1.0 }, [0.0; 2]);
            normal[wall.axis] = sign;
            ends.push((normal, sign * wall.position));
        }
        let position: Vec<[f64; 2]> = self.grains.position.iter().map(flat).collect();
        tessellate(&position, &self.grains.radius, &cell, &ends)
    }

    /// Solid fraction of all cells except surface cells; not-a-number if there are none.
    pub fn inner_solid_fraction(&self) -> f64 {
        let cells = self.tessellation();
        let inner = (0..cells.area.len()).filter(|&i| !cells.surface[i]);
        let sums = inner.fold((0.0, 0.0), |(solid, area), i| {
            (solid + crate::points::grains::volume(D, self.grains.radius[i]), area + cells.area[i])
        });
        sums.0 / sums.1
    }
}

#[cfg(test)]
mod tests {
    use colluvium_testkit::assert_near;

    use super::*;

    fn square(side: f64, periodic: bool) -> PeriodicCell<2> {
        PeriodicCell::new([0.0; 2], [side; 2], [periodic; 2])
    }

    /// Pseudo-random positions and radii.
    fn scattered(count: usize, side: f64) -> (Vec<[f64; 2]>, Vec<f64>) {
        let part = |k: usize, factor: f64| (k as f64 * factor).fract();
        let places =
            (0..count).map(|k| [side * part(k + 1, 0.754_877_666), side * part(k + 1, 0.569_840_291)]);
        (places.collect(), (0..count).map(|k| 0.2 + 0.4 * part(k + 1, 0.618_033_989)).collect())
    }

    #[test]
    fn lattices_have_the_solid_fractions_of_the_sheet() {
        let pi = std::f64::consts::PI;
        let sites: Vec<[f64; 2]> =
            (0..36).map(|k| [0.5 + f64::from(k % 6), 0.5 + f64::from(k / 6)]).collect();
        let cells = tessellate(&sites, &[0.5; 36], &square(6.0, true), &[]);
        cells.area.iter().for_each(|area| assert_near(0.25 * pi / area, std::f64::consts::FRAC_PI_4, 1e-6));
        let row = 0.75f64.sqrt();
        let hexagonal: Vec<[f64; 2]> = (0..36)
            .map(|k| [0.25 + f64::from(k % 6) + 0.5 * f64::from(k / 6 % 2), row * (0.5 + f64::from(k / 6))])
            .collect();
        let cell = PeriodicCell::new([0.0; 2], [6.0, 6.0 * row], [true; 2]);
        let cells = tessellate(&hexagonal, &[0.5; 36], &cell, &[]);
        cells.area.iter().for_each(|area| assert_near(0.25 * pi / area, 0.906_900, 1e-6));
    }

    #[test]
    fn cells_fill_a_period_and_a_box_and_a_sheared_cell() {
        let (places, radii) = scattered(90, 10.0);
        assert_near(tessellate(&places, &radii, &square(10.0, true), &[]).area.iter().sum(), 100.0, 1e-10);
        let ends = [([-1.0, 0.0], 0.0), ([1.0, 0.0], 10.0), ([0.0, -1.0], 0.0), ([0.0, 1.0], 10.0)];
        assert_near(tessellate(&places, &radii, &square(10.0, false), &ends).area.iter().sum(), 100.0, 1e-10);
        let mut sheared = square(10.0, true);
        sheared.h[0][1] = 4.0;
        assert_near(tessellate(&places, &radii, &sheared, &[]).area.iter().sum(), 100.0, 1e-10);
    }

    #[test]
    fn unequal_disks_that_touch_share_the_tangent_at_their_contact() {
        let ends = [([-1.0, 0.0], 1.0), ([1.0, 0.0], 3.0), ([0.0, -1.0], 1.0), ([0.0, 1.0], 1.0)];
        let cell = PeriodicCell::new([-1.0, -1.0], [3.0, 1.0], [false; 2]);
        let cells = tessellate(&[[0.0; 2], [1.5, 0.0]], &[1.0, 0.5], &cell, &ends);
        // The contact is at x = 1: 2 m on its left, 2 m on its right, 2 m high.
        assert_near(cells.area[0], 4.0, 1e-12);
        assert_near(cells.area[1], 4.0, 1e-12);
    }

    #[test]
    fn triangles_fill_the_hull_and_give_the_gradient_of_a_linear_field() {
        let places: Vec<[f64; 2]> =
            (0..25).map(|k| [f64::from(k % 5) + 0.1 * f64::from(k / 5), f64::from(k / 5)]).collect();
        let ends = [([-1.0, 0.0], 5.0), ([1.0, 0.0], 10.0), ([0.0, -1.0], 5.0), ([0.0, 1.0], 10.0)];
        let cell = PeriodicCell::new([-5.0; 2], [10.0; 2], [false; 2]);
        let cells = tessellate(&places, &[0.4; 25], &cell, &ends);
        let field = |x: [f64; 2]| [2.0 * x[0] - x[1], 0.5 * x[0] + 3.0 * x[1]];
        let mut inner = 0.0;
        for triangle in &cells.triangles {
            let corners = triangle.map(|i| places[i]);
            let (p, q) = (difference(&corners[1], &corners[0]), difference(&corners[2], &corners[0]));
            let area = 0.5 * (p[0] * q[1] - p[1] * q[0]);
            assert!(area > -1e-12, "{triangle:?}");
            inner += area;
            if let Some(gradient) = gradient(corners, corners.map(field)) {
                for (found, exact) in gradient.as_flattened().iter().zip([2.0, -1.0, 0.5, 3.0]) {
                    assert_near(*found, exact, 1e-9);
                }
            }
        }
        assert_near(inner, 16.0, 1e-9);
        assert!(cells.surface.iter().filter(|surface| !**surface).count() >= 9);
    }
}
