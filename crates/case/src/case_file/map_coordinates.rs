//! Map coordinates: `domain.origin` is subtracted when a case is read, and added to the output of a run.
//!
//! Differences are those of decimal numbers, so that a case whose coordinates have the origin added gives bit-identical results.

use colluvium_points::Shape;

use crate::description::{Body, InitialStress, Load, ObstacleShape, PorePressure, ProfilePiece, Velocity};
use crate::files::decimal_sum::decimal_sum;
use crate::measure::visit_position;
use crate::validate::MAX_DISTANCE_RATIO;
use crate::{Case, CaseError, DatasetGeometry, Frame, Snapshot};

/// Largest distance of the origin of the map from zero, over the size of the domain. Map coordinates within it have at least 22 binary
/// digits for positions in the domain.
const MAX_ORIGIN_RATIO: f64 = 1e9;

/// Function that is called with the axis of each coordinate of a case and with the coordinate (m).
type CoordinateVisitor<'a> = dyn FnMut(usize, &mut f64) + 'a;

/// Calls `visit` for the coordinates of a shape.
fn visit_shape(of: &mut Shape, visit: &mut CoordinateVisitor<'_>) {
    match of {
        Shape::Box { min, max } | Shape::Microstructure { min, max, .. } => {
            visit_position(min, visit);
            visit_position(max, visit);
        }
        Shape::Ball { centre, .. } => visit_position(centre, visit),
        Shape::Polygon { vertices } => {
            vertices.vertices_mut().iter_mut().for_each(|corner| visit_position(corner, visit));
        }
        Shape::Cylinder { base, .. } => visit_position(base, visit),
        // Coordinates in its files are converted when they are read.
        Shape::Layer { .. } | Shape::ArcLayer { .. } => {}
        Shape::Union { shapes } | Shape::Intersection { shapes } => {
            shapes.iter_mut().for_each(|inner| visit_shape(inner, visit));
        }
        Shape::Difference { from, cut } => {
            visit_shape(from, visit);
            visit_shape(cut, visit);
        }
    }
}

/// Calls `visit` for the coordinates of an obstacle. Coordinates in its files are map coordinates too and are converted when the files are
/// read.
fn visit_obstacle(of: &mut ObstacleShape, visit: &mut CoordinateVisitor<'_>) {
    match of {
        ObstacleShape::Plane { point, .. } => visit_position(point, visit),
        ObstacleShape::Box { min, max } => {
            visit_position(min, visit);
            visit_position(max, visit);
        }
        ObstacleShape::Ball { centre, .. } => visit_position(centre, visit),
        ObstacleShape::GroundLine { points, .. } => {
            points.iter_mut().for_each(|point| visit_position(point, visit));
        }
        ObstacleShape::Profile { start, pieces } => {
            visit_position(start, visit);
            for ProfilePiece { to, centre } in pieces {
                visit_position(to, visit);
                centre.iter_mut().for_each(|centre| visit_position(centre, visit));
            }
        }
        ObstacleShape::Polygon { vertices } => {
            vertices.iter_mut().for_each(|corner| visit_position(corner, visit));
        }
        ObstacleShape::Extruded { vertices, axis, from, to } => {
            let mut across = (0..3).filter(|other| other != axis);
            let axes = [across.next().unwrap_or(0), across.next().unwrap_or(1)];
            for corner in vertices {
                (0..2).for_each(|c| visit(axes[c], &mut corner[c]));
            }
            visit(*axis, from);
            visit(*axis, to);
        }
        ObstacleShape::Turned { vertices, axis, centre } => {
            // Distances from the axis are unchanged.
            vertices.iter_mut().for_each(|corner| visit(*axis, &mut corner[1]));
            visit_position(centre, visit);
        }
        ObstacleShape::Raster { .. } | ObstacleShape::Mesh { .. } => {}
    }
}

/// Calls `visit` for the coordinates of a velocity field.
fn visit_velocity(of: &mut Velocity, visit: &mut CoordinateVisitor<'_>) {
    match of {
        Velocity::Linear { origin, .. } => visit_position(origin, visit),
        Velocity::Bending { along, clamp, .. } => visit(*along, clamp),
        Velocity::Rest | Velocity::Uniform { .. } | Velocity::Sine { .. } | Velocity::Formula { .. } => {}
    }
}

/// Calls `visit` for the coordinates of a body: of its shape and velocity, and of the surfaces of its stress and pore pressure.
fn visit_body(of: &mut Body, vertical: Option<usize>, visit: &mut CoordinateVisitor<'_>) {
    visit_shape(&mut of.shape, visit);
    visit_velocity(&mut of.velocity, visit);
    if let (InitialStress::K0 { surface, .. }, Some(axis)) = (&mut of.stress, vertical) {
        visit(axis, surface);
    }
    let Some(fluid) = &mut of.pore_fluid else { return };
    if let (PorePressure::Hydrostatic { surface }, Some(axis)) = (&mut fluid.pressure, vertical) {
        visit(axis, surface);
    }
    fluid.velocity.iter_mut().for_each(|of| visit_velocity(of, visit));
}

impl Case {
    /// Calls `visit` with the axis of every coordinate in the case and the coordinate (m). Options of methods are not included.
    fn each_coordinate(&mut self, visit: &mut CoordinateVisitor<'_>) {
        let vertical = self.gravity.iter().position(|g| *g != 0.0);
        visit_position(&mut self.domain.min, visit);
        visit_position(&mut self.domain.max, visit);
        self.bodies.iter_mut().for_each(|of| visit_body(of, vertical, visit));
        for boundary in &mut self.boundaries {
            boundary.position.iter_mut().for_each(|x| visit(boundary.side.axis(), x));
        }
        for of in &mut self.obstacles {
            visit_obstacle(&mut of.shape, visit);
            of.motion.iter_mut().for_each(|motion| visit_position(&mut motion.centre, visit));
            of.regions
                .iter_mut()
                .filter_map(|region| region.shape.as_mut())
                .for_each(|of| visit_shape(of, visit));
        }
        self.patches.iter_mut().for_each(|patch| visit_shape(&mut patch.region, visit));
        self.removal_shapes.iter_mut().for_each(|cut| visit_shape(&mut cut.shape, visit));
        for load in &mut self.loads {
            match load {
                Load::Traction { profile, .. }
                | Load::Pressure { profile, .. }
                | Load::PorePressure { profile, .. } => {
                    for profile in profile.iter_mut() {
                        let axis = profile.axis.number();
                        profile.shares.iter_mut().for_each(|share| visit(axis, &mut share[0]));
                    }
                }
                Load::Surface { within, .. } => {
                    within.iter_mut().for_each(|region| visit_shape(region, visit));
                }
            }
        }
        for stage in &mut self.stages {
            stage.excavate.iter_mut().for_each(|region| visit_shape(region, visit));
        }
        for measure in self.measures.values_mut() {
            measure.visit_coordinates(visit);
        }
    }

    /// Subtracts `domain.origin` from the coordinates of the case.
    ///
    /// # Errors
    /// When the domain is not near the origin, or map coordinates are too large to resolve positions in the domain.
    pub(crate) fn subtract_origin(&mut self) -> Result<(), CaseError> {
        self.shift(-1);
        let refuse = |problem: String| Err(CaseError::new("domain.origin", problem));
        let extent = self.domain.max_extent();
        let farthest = |of: &[f64]| of.iter().fold(0.0_f64, |far, x| far.max(x.abs()));
        let (map, off) =
            (farthest(&self.domain.origin), farthest(&self.domain.min).max(farthest(&self.domain.max)));
        if map > 0.0 && off > MAX_DISTANCE_RATIO * extent {
            return refuse(format!(
                "{:?} is farther from the domain than {MAX_DISTANCE_RATIO} times its size of {extent} m, so \
                 positions lose digits. Give a place near the domain",
                self.domain.origin
            ));
        }
        if map > MAX_ORIGIN_RATIO * extent {
            return refuse(format!(
                "{:?} is so far from zero that results in map coordinates cannot resolve positions in a \
                 domain of {extent} m",
                self.domain.origin
            ));
        }
        Ok(())
    }

    /// Adds `domain.origin` to the coordinates of the case.
    pub(crate) fn add_origin(&mut self) {
        self.shift(1);
    }

    /// Adds the origin of the domain to all coordinates, or subtracts it where `sign` is negative.
    fn shift(&mut self, sign: i128) {
        if self.domain.origin.is_empty() {
            return;
        }
        let origin = self.origin();
        self.each_coordinate(&mut |axis, x| *x = decimal_sum(*x, origin[axis], sign));
    }

    /// Shape in the options of a method, in map coordinates, converted to coordinates from `domain.origin`.
    #[must_use]
    pub fn relative_to_origin(&self, mut of: Shape) -> Shape {
        let origin = self.origin();
        visit_shape(&mut of, &mut |axis, x| *x = decimal_sum(*x, origin[axis], -1));
        of
    }
}

/// Adds the origin of a map to positions (m).
fn add_to_positions(positions: &mut [[f64; 3]], origin: [f64; 3]) {
    positions.iter_mut().for_each(|x| (0..3).for_each(|c| x[c] += origin[c]));
}

impl Snapshot {
    /// Snapshot with its positions on the map of the case, of whose domain it has those relative to the origin.
    #[must_use]
    pub fn on_map(mut self, case: &Case) -> Self {
        if !case.domain.origin.is_empty() {
            add_to_positions(&mut self.positions, case.origin());
        }
        self
    }
}

impl Frame {
    /// Frame with all its geometries on the map of the case, as [`Snapshot::on_map`]. A solver and [`crate::RunEvent`] give frames relative
    /// to the origin.
    #[must_use]
    pub fn on_map(mut self, case: &Case) -> Self {
        if !case.domain.origin.is_empty() {
            self.datasets.iter_mut().for_each(|dataset| dataset.geometry.add_origin(case.origin()));
        }
        self
    }
}

impl DatasetGeometry {
    /// Adds the origin of a map (m) to all coordinates.
    fn add_origin(&mut self, origin: [f64; 3]) {
        match self {
            Self::Points(points) => add_to_positions(&mut points.positions, origin),
            Self::Mesh(mesh) => add_to_positions(&mut mesh.vertices, origin),
            Self::Lattice { nodes, .. } => (0..3).for_each(|c| nodes.low[c] += origin[c]),
            Self::Raster(nodes) => (0..2).for_each(|c| nodes.origin[c] += origin[c]),
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    /// Case with a coordinate of every kind, translated by `by`.
    fn translated_case(by: [f64; 2]) -> Value {
        let at = |x: f64, y: f64| json!([decimal_sum(x, by[0], 1), decimal_sum(y, by[1], 1)]);
        let (x, y) = (|x: f64| decimal_sum(x, by[0], 1), |y: f64| decimal_sum(y, by[1], 1));
        let elastic =
            json!({ "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 });
        let mut case = json!({
            "title": "t", "space": "plane-strain", "gravity": [0, -10], "materials": { "m": elastic },
            "domain": { "min": at(0.1, -0.3), "max": at(9.7, 4.3) },
            "bodies": [
                { "name": "a", "material": "m", "shape": { "kind": "box", "min": at(0.3, 0.7), "max": at(1.1, 1.3) },
                  "stress": { "kind": "k0", "surface": y(1.3), "coefficient": 0.5 } },
                { "name": "b", "material": "m", "shape": { "kind": "polygon", "vertices": [at(3.1, 1.1), at(4.1, 1.1), at(4.1, 2.7)] },
                  "velocity": { "kind": "linear", "value": [0, 1], "origin": at(3.3, 1.7), "gradient": [[0, 1], [1, 0]] } }
            ],
            "boundaries": [{ "side": "x-min", "position": x(0.2), "wall": { "kind": "smooth" } }],
            "obstacles": [
                { "name": "p", "shape": { "kind": "plane", "point": at(0.7, 0.1), "normal": [1, 2] }, "wall": { "kind": "rough" } },
                { "name": "l", "shape": { "kind": "ground-line", "points": [at(0.1, 0.2), at(7.7, 0.6)] }, "wall": { "kind": "smooth" },
                  "regions": [{ "shape": { "kind": "box", "min": [x(0.9)], "max": [x(1.7)] }, "wall": { "kind": "rough" } }] },
                { "name": "c", "shape": { "kind": "profile", "start": at(0.0, 1.0),
                  "pieces": [{ "to": at(1.0, 0.0), "centre": at(1.0, 1.0) }] }, "wall": { "kind": "rough" } }
            ],
            "measures": { "push": { "kind": "reaction", "target": "l", "about": at(0.3, 0.9) }, "run": { "kind": "run-out", "side": "x-max", "origin": x(0.2), "initial_length": 1 },
                          "eye": { "kind": "probe", "position": at(0.7, 0.9), "radius": 1, "fields": ["stress"] } },
            "stages": [{ "name": "s", "duration": 1, "excavate": [{ "kind": "ball", "centre": at(0.6, 0.9), "radius": 0.1 }] }]
        });
        if by != [0.0; 2] {
            case["domain"]["origin"] = json!(by);
        }
        case
    }

    #[test]
    fn all_geometries_of_a_frame_move_to_the_map() {
        use crate::solver::{Dataset, FramePoints, Lattice, PlanNodes, PolygonMesh};
        let case = Case::from_json(&translated_case([5e5, 5e6]).to_string()).unwrap();
        let positions = vec![[1.0, 2.0, 0.0]];
        let geometries = [
            DatasetGeometry::Points(FramePoints { positions: positions.clone(), ..FramePoints::default() }),
            DatasetGeometry::Mesh(PolygonMesh::of_lines(&[[positions[0]; 2]])),
            DatasetGeometry::Lattice {
                nodes: Lattice { low: positions[0], spacing: 1.0, count: [1; 3] },
                mask: Vec::new(),
            },
            DatasetGeometry::Raster(PlanNodes {
                columns: 1,
                rows: 1,
                origin: [1.0, 2.0],
                spacing: [1.0; 2],
                reference: colluvium_points::Georeference::default(),
            }),
        ];
        let sets = geometries.map(|geometry| Dataset { name: String::new(), geometry, fields: Vec::new() });
        let frame = Frame { datasets: sets.to_vec(), ..Frame::default() }.on_map(&case);
        let low = |geometry: &DatasetGeometry| match geometry {
            DatasetGeometry::Points(points) => points.positions[0],
            DatasetGeometry::Mesh(mesh) => mesh.vertices[1],
            DatasetGeometry::Lattice { nodes, .. } => nodes.low,
            DatasetGeometry::Raster(nodes) => [nodes.origin[0], nodes.origin[1], 0.0],
        };
        for dataset in &frame.datasets {
            assert_eq!(low(&dataset.geometry), [500_001.0, 5_000_002.0, 0.0]);
        }
        let snapshot = Snapshot { positions, ..Snapshot::default() }.on_map(&case);
        assert_eq!(snapshot.positions, [[500_001.0, 5_000_002.0, 0.0]]);
    }

    #[test]
    fn a_case_in_map_coordinates_equals_the_case_at_zero() {
        let here = Case::from_json(&translated_case([0.0; 2]).to_string()).unwrap();
        let mut there = Case::from_json(&translated_case([5e5, 5e6]).to_string()).unwrap();
        assert_eq!(Case::from_json(&there.to_json()).unwrap(), there, "what a run keeps of it");
        assert!(there.to_json().contains("500000.3"));
        there.domain.origin.clear();
        assert_eq!(there, here);
    }

    #[test]
    fn map_coordinates_without_an_origin_are_refused_with_a_suggested_origin() {
        let mut case = translated_case([5e5, 5e6]);
        case["domain"].as_object_mut().unwrap().remove("origin");
        let problem = Case::from_json(&case.to_string()).unwrap_err().to_string();
        assert!(problem.contains("domain.origin") && problem.contains("[500000.0, 5000000.0]"), "{problem}");
        for (origin, expected) in [
            (json!([5e5, 0]), "is farther from the domain than 1000 times"),
            (json!([5e5, -5e6]), "is farther from the domain than 1000 times"),
            (json!([5e15, 5e6]), "is farther from the domain than 1000 times"),
        ] {
            case["domain"]["origin"] = origin;
            let problem = Case::from_json(&case.to_string()).unwrap_err().to_string();
            assert!(problem.starts_with("domain.origin: ") && problem.contains(expected), "{problem}");
        }
        let far = Case::from_json(&translated_case([2e10, 0.0]).to_string()).unwrap_err().to_string();
        assert!(far.contains("cannot resolve positions in a domain"), "{far}");
        case["domain"]["origin"] = json!([5e5]);
        assert!(Case::from_json(&case.to_string()).unwrap_err().to_string().contains("domain.origin"));
    }
}
