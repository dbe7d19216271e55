//! Boundary laws of an obstacle by region.

use crate::PlanRegion;
use crate::description::{Obstacle, ObstacleWall, Wall};

/// Boundary law of an obstacle at a position of its surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObstacleLaw {
    /// Wall law (friction, adhesion).
    pub wall: ObstacleWall,
    /// Whether material may separate, whatever the wall.
    pub separation: bool,
}

impl ObstacleLaw {
    /// Friction coefficient; infinite for no slip.
    pub fn friction(&self) -> f64 {
        Wall::from(self.wall).friction()
    }

    /// Adhesion: shear strength beside friction (Pa).
    pub fn adhesion(&self) -> f64 {
        match self.wall {
            ObstacleWall::Frictional { adhesion, .. } => adhesion,
            ObstacleWall::Rough | ObstacleWall::Smooth => 0.0,
        }
    }

    /// Whether material may separate.
    pub fn allows_separation(&self) -> bool {
        self.separation || matches!(self.wall, ObstacleWall::Frictional { .. })
    }
}

/// Boundary laws of an obstacle: one for each of its regions, and one elsewhere.
#[derive(Clone, Debug)]
pub struct ObstacleLaws {
    regions: Vec<PlanRegion>,
    /// Laws of the regions, then the law elsewhere.
    laws: Vec<ObstacleLaw>,
}

impl ObstacleLaws {
    /// Laws of an obstacle with these regions, in their order.
    pub(super) fn new(obstacle: &Obstacle, regions: Vec<PlanRegion>) -> Self {
        let walls = obstacle.regions.iter().map(|region| region.wall).chain([obstacle.wall]);
        let laws = walls.map(|wall| ObstacleLaw { wall, separation: obstacle.separation });
        Self { regions, laws: laws.collect() }
    }

    /// Index of the first region that contains a position of the surface (m); the number of regions where none does.
    #[inline]
    pub fn region(&self, place: &[f64]) -> usize {
        if self.regions.is_empty() {
            return 0;
        }
        let plan = &place[..place.len() - 1];
        self.regions.iter().position(|region| region.contains(plan)).unwrap_or(self.regions.len())
    }

    /// Law at a position of the surface (m).
    #[inline]
    pub fn law_at(&self, place: &[f64]) -> &ObstacleLaw {
        &self.laws[self.region(place)]
    }

    /// Whether the law is the same everywhere.
    pub fn is_uniform(&self) -> bool {
        self.regions.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use crate::Case;

    #[test]
    fn the_first_region_that_contains_a_position_determines_its_wall_law() {
        let folder = tempfile::tempdir().unwrap();
        let ring = json!([[[510.0, 0.0], [520.0, 0.0], [520.0, 9.0], [510.0, 9.0], [510.0, 0.0]]]);
        let text = json!({ "type": "Polygon", "coordinates": ring }).to_string();
        std::fs::write(folder.path().join("part.geojson"), text).unwrap();
        let wall = |friction: f64| json!({ "kind": "frictional", "friction_coefficient": friction });
        let case = json!({
            "title": "t", "space": "3d", "gravity": [0, 0, -10],
            "materials": { "m": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
            "domain": { "min": [500, 0, 0], "max": [530, 10, 9], "origin": [500, 0, 0] },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [501, 1, 5], "max": [502, 2, 6] } }],
            "obstacles": [{
                "name": "ground", "wall": { "kind": "smooth" },
                "shape": { "kind": "plane", "point": [500, 0, 4], "normal": [1, 0, 3] },
                "regions": [
                    { "outline": "part.geojson", "wall": wall(0.5) },
                    { "shape": { "kind": "box", "min": [515, 0], "max": [525, 10] }, "wall": wall(0.2) }
                ]
            }],
            "stages": [{ "name": "s", "duration": 1 }]
        });
        let case = Case::from_value(&case, folder.path()).unwrap();
        let standing = case.placed_obstacles::<3>().unwrap();
        let friction = |x: f64, y: f64| standing[0].laws.law_at(&[x, y, 7.0]).friction();
        assert_eq!([friction(5.0, 5.0), friction(12.0, 5.0), friction(17.0, 5.0)], [0.0, 0.5, 0.5]);
        assert_eq!([friction(17.0, 9.5), friction(24.0, 5.0), friction(26.0, 5.0)], [0.2, 0.2, 0.0]);
        let mut missing = case.clone();
        missing.obstacles[0].regions[0].outline = Some("none.geojson".to_owned());
        let problem = missing.placed_obstacles::<3>().unwrap_err().to_string();
        assert!(problem.starts_with("obstacles[0].regions[0].outline: none.geojson"), "{problem}");
    }
}
