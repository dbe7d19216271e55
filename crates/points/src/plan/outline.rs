//! Outlines in plan: unions of polygons.

use std::collections::HashMap;

use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::single::SingleFloatOverlay;

use crate::plan::polygon::{has_self_contact, proper_crossing, signed_area};
use crate::surface::{FacettedSurface, Surface};

/// Closed ring in plan: its corners (m).
pub type Ring = Vec<[f64; 2]>;

/// Polygon in plan: its outer ring, then the rings of its holes.
pub type Polygon = Vec<Ring>;

/// Union of polygons in plan. A hole belongs to its own polygon only, and polygons may touch and overlap: a position lies in the outline
/// when it lies in any of them.
#[derive(Clone, Debug)]
pub struct Outline {
    polygon_rings: Vec<PolygonRings>,
    polygons: Vec<Polygon>,
    merged_polygons: Vec<Polygon>,
}

/// Polygon: outer ring and holes.
#[derive(Clone, Debug)]
struct PolygonRings {
    outer: RingLoops,
    holes: Vec<RingLoops>,
}

/// Loops of a ring that do not overlap; several where the ring touches itself. Its inside is the area within an odd number of loops.
#[derive(Clone, Debug)]
struct RingLoops(Vec<FacettedSurface<2>>);

impl RingLoops {
    /// Whether an odd number of the loops contains a position.
    fn contains(&self, place: [f64; 2]) -> bool {
        self.0.iter().filter(|one| one.contains(&place)).count() % 2 == 1
    }
}

impl PolygonRings {
    /// Whether a position is within the outer ring and in no hole.
    fn contains(&self, place: [f64; 2]) -> bool {
        self.outer.contains(place) && !self.holes.iter().any(|hole| hole.contains(place))
    }
}

impl Outline {
    /// Outline of these polygons (m). The last corner of a ring may repeat the first, and a ring may touch itself or run over its own
    /// edges: its inside is the area with a winding number other than zero.
    ///
    /// # Errors
    /// When there is no polygon, or a ring has fewer than three corners or crosses itself, as one line.
    pub fn new(polygons: Vec<Polygon>) -> Result<Self, String> {
        let polygons: Vec<Polygon> = polygons.into_iter().filter(|polygon| !polygon.is_empty()).collect();
        if polygons.is_empty() {
            return Err("contains no polygon".to_owned());
        }
        let mut number = 0;
        let mut split = |polygon: &Polygon| -> Result<Vec<Vec<Ring>>, String> {
            let around = |ring: &Ring| {
                number += 1;
                nonzero_winding_loops(ring).map_err(|problem| format!("ring {number}: {problem}"))
            };
            polygon.iter().map(around).collect()
        };
        let split: Vec<Vec<Vec<Ring>>> = polygons.iter().map(&mut split).collect::<Result<_, _>>()?;
        let (mut number, mut polygon_rings) = (0, Vec::with_capacity(split.len()));
        for polygon in &split {
            let mut rings = polygon.iter().map(|ring| {
                number += 1;
                let facetted = ring.iter().map(|one| FacettedSurface::polygon(one)).collect::<Result<_, _>>();
                facetted.map(RingLoops).map_err(|error| format!("ring {number}: {error}"))
            });
            let outer = rings.next().unwrap_or_else(|| Ok(RingLoops(Vec::new())))?;
            polygon_rings.push(PolygonRings { outer, holes: rings.collect::<Result<_, _>>()? });
        }
        Ok(Self { polygon_rings, merged_polygons: union_of_polygons(split), polygons })
    }

    /// Polygons from which the outline was made (m).
    pub fn polygons(&self) -> &[Polygon] {
        &self.polygons
    }

    /// Boundary rings of the outline, holes included (m). No two of them cross.
    pub fn rings(&self) -> impl Iterator<Item = &Ring> {
        self.merged_polygons.iter().flatten()
    }

    /// Area in plan (m²); overlapping parts count once.
    pub fn area(&self) -> f64 {
        area(&self.merged_polygons)
    }

    /// Polygons whose union is the outline, without overlaps and without common edges.
    pub(crate) fn disjoint_polygons(&self) -> &[Polygon] {
        &self.merged_polygons
    }

    /// Polygons of the outline minus `others` (m).
    pub(crate) fn difference(&self, others: &Vec<Polygon>) -> Vec<Polygon> {
        if others.is_empty() {
            return self.merged_polygons.clone();
        }
        self.merged_polygons.overlay_as::<i64>(others, OverlayRule::Difference, FillRule::EvenOdd)
    }

    /// Polygons of the union of the outline and `others` (m).
    pub(crate) fn union(&self, others: &Vec<Polygon>) -> Vec<Polygon> {
        self.merged_polygons.overlay_as::<i64>(others, OverlayRule::Union, FillRule::EvenOdd)
    }

    /// Area in common with another outline (m²).
    pub fn overlap(&self, other: &Self) -> f64 {
        let ((low, high), (from, to)) = (self.bounds(), other.bounds());
        if (0..2).any(|c| low[c] >= to[c] || from[c] >= high[c]) {
            return 0.0;
        }
        area(&self.merged_polygons.overlay_as::<i64>(
            &other.merged_polygons,
            OverlayRule::Intersect,
            FillRule::EvenOdd,
        ))
    }

    /// Whether the outline contains a position in plan (m).
    pub fn contains(&self, place: [f64; 2]) -> bool {
        self.polygon_rings.iter().any(|part| part.contains(place))
    }

    /// Lower and upper corner of the bounding box in plan (m).
    pub fn bounds(&self) -> ([f64; 2], [f64; 2]) {
        let mut around = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for ring in self.polygon_rings.iter().flat_map(|part| &part.outer.0) {
            let (low, high) = ring.bounds();
            for c in 0..2 {
                around.0[c] = around.0[c].min(low[c]);
                around.1[c] = around.1[c].max(high[c]);
            }
        }
        around
    }
}

/// Area of polygons without overlaps, holes subtracted (m²).
fn area(polygons: &[Polygon]) -> f64 {
    let around = |(number, ring): (usize, &Ring)| {
        // Coordinates relative to the first corner, so that no digits are lost far from the origin.
        let from_first: Ring = ring.iter().map(|x| [x[0] - ring[0][0], x[1] - ring[0][1]]).collect();
        signed_area(&from_first).abs() * if number == 0 { 1.0 } else { -1.0 }
    };
    polygons.iter().flat_map(|polygon| polygon.iter().enumerate()).map(around).sum()
}

/// Simple loops of a ring, without repeated corners. Loops without area, as of a line there and back, are left out.
fn split_into_loops(ring: &Ring) -> Vec<Ring> {
    let (mut open, mut places, mut closed) = (Ring::new(), HashMap::new(), Vec::new());
    for corner in ring {
        // Zero and minus zero are the same coordinate.
        let place = |corner: &[f64; 2]| corner.map(|c| (c + 0.0).to_bits());
        if let Some(&start) = places.get(&place(corner)) {
            closed.push(open[start..].to_vec());
            for corner in open.drain(start + 1..) {
                places.remove(&place(&corner));
            }
        } else {
            places.insert(place(corner), open.len());
            open.push(*corner);
        }
    }
    closed.push(open);
    closed.retain(|one| one.len() > 2);
    if closed.is_empty() { vec![ring.clone()] } else { closed }
}

/// Loops around the area with a winding number other than zero. They do not overlap.
fn nonzero_winding_loops(ring: &Ring) -> Result<Vec<Ring>, String> {
    let loops_of = split_into_loops(ring);
    let is_plain = loops_of.len() == 1 && !has_self_contact(&loops_of[0]);
    if is_plain || ring.iter().flatten().any(|c| !c.is_finite()) {
        return Ok(loops_of);
    }
    if let Some((a, b)) = proper_crossing(ring) {
        return Err(format!(
            "the piece from {:?} to {:?} m crosses the one from {:?} to {:?} m",
            a.0, a.1, b.0, b.1
        ));
    }
    let around: Vec<Polygon> =
        vec![ring.clone()].overlay_as::<i64>(&Vec::<Ring>::new(), OverlayRule::Subject, FillRule::NonZero);
    let found: Vec<Ring> = around.iter().flatten().flat_map(split_into_loops).collect();
    Ok(if found.is_empty() { loops_of } else { found })
}

/// Union of polygons, each given by the loops of its rings, as polygons without overlaps and without common edges.
fn union_of_polygons(polygons: Vec<Vec<Vec<Ring>>>) -> Vec<Polygon> {
    if let [polygon] = &polygons[..]
        && let [outer] = &polygon[..]
        && outer.len() == 1
    {
        return polygons.into_iter().flatten().collect();
    }
    let without_holes = |mut polygon: Vec<Vec<Ring>>| -> Vec<Polygon> {
        let holes: Vec<Polygon> = polygon.drain(1..).flat_map(|hole| odd_even_polygons(&hole)).collect();
        let outer: Vec<Polygon> = polygon.iter().flat_map(odd_even_polygons).collect();
        if holes.is_empty() {
            return outer;
        }
        outer.overlay_as::<i64>(&holes, OverlayRule::Difference, FillRule::NonZero)
    };
    let all: Vec<Polygon> = polygons.into_iter().flat_map(without_holes).collect();
    all.overlay_as::<i64>(&Vec::<Polygon>::new(), OverlayRule::Subject, FillRule::NonZero)
}

/// Area within an odd number of the loops of a ring, as polygons with counter-clockwise outer rings and clockwise holes.
fn odd_even_polygons(loops: &Vec<Ring>) -> Vec<Polygon> {
    loops.overlay_as::<i64>(&Vec::<Ring>::new(), OverlayRule::Subject, FillRule::EvenOdd)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(low: f64, high: f64) -> Ring {
        vec![[low, low], [high, low], [high, high], [low, high], [low, low]]
    }

    fn rectangle(low: [f64; 2], high: [f64; 2]) -> Ring {
        vec![low, [high[0], low[1]], high, [low[0], high[1]]]
    }

    #[test]
    fn a_hole_is_one_of_its_own_polygon() {
        let outline = Outline::new(vec![vec![square(0.0, 9.0), square(3.0, 6.0)]]).unwrap();
        assert!(
            outline.contains([1.0, 4.0]) && !outline.contains([4.0, 4.0]) && !outline.contains([-1.0, 4.0])
        );
        assert_eq!(outline.bounds(), ([0.0; 2], [9.0; 2]));
        assert!((outline.area() - 72.0).abs() < 1e-12 && outline.rings().count() == 2);
        // An island in the hole, and a polygon across the boundary of the hole.
        let islands = vec![vec![square(0.0, 9.0), square(3.0, 6.0)], vec![square(4.0, 5.0)]];
        let island = Outline::new(islands).unwrap();
        assert!(island.contains([4.5, 4.5]) && !island.contains([3.5, 3.5]));
        assert!((island.area() - 73.0).abs() < 1e-12 && island.rings().count() == 3);
        let over = vec![vec![square(0.0, 9.0), square(3.0, 6.0)], vec![rectangle([2.0, 4.0], [4.0, 5.0])]];
        let over = Outline::new(over).unwrap();
        assert!(over.contains([2.5, 4.5]) && over.contains([3.5, 4.5]) && !over.contains([5.0, 4.5]));
        assert!((over.area() - 73.0).abs() < 1e-12);
    }

    #[test]
    fn polygons_that_touch_overlap_or_lie_in_one_another_are_one_area() {
        // Two with a common edge, four around a corner and a strip across: the square of 4 m by 4 m.
        let halves = vec![vec![rectangle([0.0; 2], [2.0, 4.0])], vec![rectangle([2.0, 0.0], [4.0; 2])]];
        let quarter = |x: f64, y: f64| vec![rectangle([x, y], [x + 2.0, y + 2.0])];
        let quarters = vec![quarter(0.0, 0.0), quarter(2.0, 0.0), quarter(2.0, 2.0), quarter(0.0, 2.0)];
        let over = vec![vec![rectangle([0.0; 2], [3.0, 4.0])], vec![rectangle([1.0, 0.0], [4.0; 2])]];
        let within = vec![vec![square(0.0, 4.0)], vec![square(1.0, 2.0)]];
        for polygons in [halves, quarters, over, within] {
            let outline = Outline::new(polygons).unwrap();
            assert!((outline.area() - 16.0).abs() < 1e-12, "{}", outline.area());
            assert_eq!(outline.rings().map(Vec::len).collect::<Vec<_>>(), [4]);
            for place in [[1.5, 1.5], [2.0, 2.0], [2.0, 1.0], [3.5, 0.5], [0.5, 3.5]] {
                assert!(outline.contains(place), "{place:?}");
            }
            assert!(!outline.contains([4.1, 2.0]));
        }
    }

    #[test]
    fn repeated_corners_of_an_outline_are_accepted() {
        let mut twice = square(0.0, 4.0);
        twice.insert(1, twice[1]);
        // A line there and back, and the ring closed twice.
        twice.extend([[0.0, 0.0], [-1.0, 0.0], [0.0, 0.0]]);
        let outline = Outline::new(vec![vec![twice]]).unwrap();
        assert!((outline.area() - 16.0).abs() < 1e-12 && !outline.contains([-0.5, 0.0]));
        // A hole that touches a corner of the ring, as in shapefiles, and two loops with a corner in common.
        let hanging =
            vec![[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0], [0.0, 0.0], [1.0, 2.0], [2.0, 1.0]];
        let outline = Outline::new(vec![vec![hanging]]).unwrap();
        assert!((outline.area() - 14.5).abs() < 1e-12);
        assert!(outline.contains([3.0, 3.0]) && !outline.contains([1.0, 1.0]));
        let eight = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [4.0, 2.0], [4.0, 4.0], [2.0, 4.0], [2.0, 2.0]];
        let outline = Outline::new(vec![vec![eight]]).unwrap();
        assert!((outline.area() - 6.0).abs() < 1e-12);
        assert!(
            outline.contains([1.5, 0.5]) && outline.contains([3.0, 3.0]) && !outline.contains([1.0, 3.0])
        );
    }

    #[test]
    fn a_ring_counts_by_its_winding_number_and_holes_of_a_polygon_are_united() {
        let outline = |polygons: Vec<Polygon>| Outline::new(polygons).unwrap();
        let twice = |low: f64, high: f64| {
            let mut ring = square(low, high);
            ring.extend(square(low, high));
            ring
        };
        // Traced twice, alone and beside another; a hole traced twice, and the same hole given twice.
        assert!((outline(vec![vec![twice(0.0, 4.0)]]).area() - 16.0).abs() < 1e-9);
        let both = outline(vec![vec![twice(0.0, 4.0)], vec![square(5.0, 7.0)]]);
        assert!((both.area() - 20.0).abs() < 1e-9 && both.contains([1.0, 1.0]) && both.contains([6.0, 6.0]));
        for holes in [vec![twice(1.0, 3.0)], vec![square(1.0, 3.0), square(1.0, 3.0)]] {
            let holed = outline(vec![[vec![square(0.0, 4.0)], holes].concat()]);
            assert!((holed.area() - 12.0).abs() < 1e-9, "{}", holed.area());
            assert!(!holed.contains([2.0, 2.0]) && holed.contains([0.5, 0.5]));
        }
        let over = outline(vec![vec![square(0.0, 4.0), square(1.0, 3.0), square(2.0, 3.5)]]);
        assert!((over.area() - (16.0 - 4.0 - 2.25 + 1.0)).abs() < 1e-9 && !over.contains([2.5, 2.5]));
        // A ring that runs over its own edges a second time, and a loop that touches an edge between two corners.
        let mut part = square(0.0, 4.0);
        part.extend([[4.0, 0.0], [4.0, 2.0], [0.0, 0.0]]);
        let part = outline(vec![vec![part]]);
        assert!((part.area() - 16.0).abs() < 1e-9 && part.contains([3.0, 1.0]));
        let along = vec![[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0], [0.0, 0.0], [3.0, 0.0], [3.0, 3.0]];
        let along = outline(vec![vec![along]]);
        assert!((along.area() - 16.0).abs() < 1e-9 && along.contains([2.0, 1.0]));
        // Two triangles that touch where a corner lies on an edge, one clockwise and one counter-clockwise.
        let bow = vec![[0.0, 0.0], [2.0, 2.0], [4.0, 4.0], [4.0, 0.0], [1.0, 1.0], [0.0, 2.0]];
        let bow = outline(vec![vec![bow]]);
        assert!(bow.area() > 4.0 && bow.contains([3.5, 1.0]) && bow.contains([0.2, 1.0]));
        // Loops with a corner in common that cross each other.
        let crossed =
            vec![[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0], [0.0, 0.0], [5.0, 1.0], [5.0, 2.0]];
        assert!(Outline::new(vec![vec![crossed]]).unwrap_err().contains("crosses"));
    }

    #[test]
    fn the_overlap_of_two_outlines_is_the_area_in_both() {
        let [a, b, c] = [square(0.0, 4.0), square(3.0, 9.0), square(4.0, 5.0)]
            .map(|ring| Outline::new(vec![vec![ring]]).unwrap());
        assert!((a.overlap(&b) - 1.0).abs() < 1e-12 && (b.overlap(&c) - 1.0).abs() < 1e-12);
        assert_eq!(a.overlap(&c), 0.0);
    }

    #[test]
    fn invalid_outlines_are_refused_and_extreme_coordinates_cause_no_panic() {
        assert!(Outline::new(Vec::new()).is_err());
        assert!(Outline::new(vec![vec![vec![[0.0, 0.0], [1.0, 1.0], [0.0, 0.0]]]]).is_err());
        let crossed = vec![[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [0.0, 4.0]];
        let error = Outline::new(vec![vec![square(0.0, 1.0)], vec![crossed]]).unwrap_err();
        assert!(error.starts_with("ring 2: ") && error.contains("crosses"), "{error}");
        for size in [1e-300, 1e-12, 1e12, 1e150, 1e300] {
            let _ = Outline::new(vec![vec![square(0.0, size)], vec![square(size, 1.5 * size)]]);
        }
        assert!(Outline::new(vec![vec![square(0.0, f64::NAN)], vec![square(1.0, 2.0)]]).is_err());
    }

    #[test]
    fn far_from_the_origin_areas_keep_their_digits() {
        let at = |x: f64| vec![rectangle([6e5 + x, 5e6], [6e5 + x + 10.0, 5e6 + 20.0])];
        let outline = Outline::new(vec![at(0.0), at(10.0), at(15.0)]).unwrap();
        assert!((outline.area() - 500.0).abs() < 1e-6, "{}", outline.area());
    }
}
