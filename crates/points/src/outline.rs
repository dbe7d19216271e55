//! Outlines in plan.

use crate::polygon::signed_area;
use crate::surface::{Facetted, Surface};

/// Closed rings in plan. A place lies in the outline when an odd number of rings is around it, so that a ring within another
/// is a hole.
#[derive(Clone, Debug)]
pub struct Outline {
    rings: Vec<Facetted<2>>,
    corners: Vec<Vec<[f64; 2]>>,
}

impl Outline {
    /// The outline of these rings (m). The last corner of a ring may repeat the first.
    ///
    /// # Errors
    /// When there is no ring, or one has fewer than three corners or crosses itself, in a line.
    pub fn new(rings: Vec<Vec<[f64; 2]>>) -> Result<Self, String> {
        if rings.is_empty() {
            return Err("holds no polygon".to_owned());
        }
        let mut corners = rings;
        for ring in &mut corners {
            if ring.len() > 1 && ring.first() == ring.last() {
                ring.pop();
            }
        }
        let ring = |(number, corners): (usize, &Vec<[f64; 2]>)| {
            Facetted::polygon(corners).map_err(|error| format!("ring {}: {error}", number + 1))
        };
        let rings = corners.iter().enumerate().map(ring).collect::<Result<_, _>>()?;
        Ok(Self { rings, corners })
    }

    /// The corners of the rings (m), none twice.
    pub fn rings(&self) -> &[Vec<[f64; 2]>] {
        &self.corners
    }

    /// Area in plan (m²), holes taken off.
    pub fn area(&self) -> f64 {
        let around = |number: usize| {
            let others = self.rings.iter().enumerate().filter(|(other, _)| *other != number);
            others.filter(|(_, ring)| ring.contains(&self.corners[number][0])).count()
        };
        let signed = |(number, ring): (usize, &Vec<[f64; 2]>)| {
            signed_area(ring).abs() * if around(number).is_multiple_of(2) { 1.0 } else { -1.0 }
        };
        self.corners.iter().enumerate().map(signed).sum()
    }

    /// Whether a place in plan lies in it.
    pub fn contains(&self, place: [f64; 2]) -> bool {
        self.rings.iter().filter(|ring| ring.contains(&place)).count() % 2 == 1
    }

    /// Lower and upper corner of a box around it (m).
    pub fn bounds(&self) -> ([f64; 2], [f64; 2]) {
        let mut around = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for ring in &self.rings {
            let (low, high) = ring.bounds();
            for c in 0..2 {
                around.0[c] = around.0[c].min(low[c]);
                around.1[c] = around.1[c].max(high[c]);
            }
        }
        around
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_within_another_is_a_hole() {
        let square =
            |low: f64, high: f64| vec![[low, low], [high, low], [high, high], [low, high], [low, low]];
        let outline = Outline::new(vec![square(0.0, 9.0), square(3.0, 6.0)]).unwrap();
        assert!(
            outline.contains([1.0, 4.0]) && !outline.contains([4.0, 4.0]) && !outline.contains([-1.0, 4.0])
        );
        assert_eq!(outline.bounds(), ([0.0; 2], [9.0; 2]));
        assert_eq!((outline.area(), outline.rings()[1].len()), (72.0, 4));
        assert!(Outline::new(Vec::new()).is_err());
        assert!(Outline::new(vec![vec![[0.0, 0.0], [1.0, 1.0], [0.0, 0.0]]]).is_err());
    }
}
