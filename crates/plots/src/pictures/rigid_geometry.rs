//! Rigid geometry behind the points of a picture.

use std::ops::Range;

use colluvium_case::description::ObstacleMotion;

/// Rigid geometry: lines in a plane, or heights of the ground in space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RigidGeometry {
    /// Fixed lines in the plane, with their corners (m).
    pub lines: Vec<Vec<[f64; 2]>>,
    /// Moving lines in the plane.
    pub moving: Vec<MovingLines>,
    /// Moving bodies in space.
    pub shells: Vec<MovingSurface>,
    /// Height field of the fixed geometry in space.
    pub heights: Option<Heights>,
    /// Text on geometry that is not shown, with the reason; empty where all geometry is shown.
    pub missing: String,
}

/// Lines that move together as a rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct MovingLines {
    /// Lines with their corners at the start (m), relative to `reference_point`.
    pub lines: Vec<Vec<[f64; 2]>>,
    /// Reference point of the body at the start (m), in the coordinates of the picture.
    pub reference_point: [f64; 2],
    /// Rigid motion, its `centre` relative to `reference_point` (m).
    pub motion: ObstacleMotion,
}

impl MovingLines {
    /// Position of `reference_point` at `time` (s), and cosine and sine of the rotation angle of the lines.
    pub fn pose(&self, time: f64) -> [f64; 4] {
        let frame = self.motion.transform::<2>(time).shifted(&self.reference_point);
        let [x, y] = frame.translation;
        [x, y, frame.rotation[0][0], frame.rotation[1][0]]
    }
}

/// Surface of a moving body in space.
#[derive(Clone, Debug, PartialEq)]
pub struct MovingSurface {
    /// Corners of the faces at the start (m), relative to `reference_point`.
    pub corners: Vec<[f64; 3]>,
    /// Indices of the four corners of each face, counter-clockwise from outside.
    pub faces: Vec<[usize; 4]>,
    /// Reference point of the body at the start (m), in the coordinates of the picture.
    pub reference_point: [f64; 3],
    /// Rigid motion, its `centre` relative to `reference_point` (m).
    pub motion: ObstacleMotion,
}

impl MovingSurface {
    /// Position of `reference_point` at `time` (s), and the rotation of the body, by rows.
    pub fn pose(&self, time: f64) -> ([f64; 3], [[f64; 3]; 3]) {
        let frame = self.motion.transform::<3>(time).shifted(&self.reference_point);
        (frame.translation, frame.rotation)
    }
}

impl RigidGeometry {
    /// Lines in the plane at `time` (s).
    pub fn lines_at(&self, time: f64) -> Vec<Vec<[f64; 2]>> {
        let moved = self.moving.iter().flat_map(|one| {
            let frame = one.motion.transform::<2>(time).shifted(&one.reference_point);
            let place = move |at: &[f64; 2]| frame.to_space(at);
            one.lines.iter().map(move |line| line.iter().map(place).collect())
        });
        self.lines.iter().cloned().chain(moved).collect()
    }
}

/// Heights on a lattice normal to the axis against gravity.
#[derive(Clone, Debug, PartialEq)]
pub struct Heights {
    /// Numbers of nodes along the two axes of the lattice, the lower axis first.
    pub counts: [usize; 2],
    /// Position of the first node (m).
    pub origin: [f64; 2],
    /// Distance of the nodes along the two axes (m).
    pub spacing: [f64; 2],
    /// Heights (m), the first axis fastest; NaN where there is no ground.
    pub values: Vec<f64>,
}

/// Parts of a line inside a window.
pub fn clip_line(line: &[[f64; 2]], window: &[Range<f64>; 2]) -> Vec<Vec<[f64; 2]>> {
    let mut parts: Vec<Vec<[f64; 2]>> = Vec::new();
    for pair in line.windows(2) {
        let Some([from, to]) = clip_segment(pair[0], pair[1], window) else { continue };
        match parts.last_mut() {
            Some(part) if part.last() == Some(&from) => part.push(to),
            _ => parts.push(vec![from, to]),
        }
    }
    parts
}

/// Part of a straight segment inside a window (Liang & Barsky 1984).
fn clip_segment(from: [f64; 2], to: [f64; 2], window: &[Range<f64>; 2]) -> Option<[[f64; 2]; 2]> {
    let direction = [to[0] - from[0], to[1] - from[1]];
    let (mut enters, mut leaves) = (0f64, 1f64);
    for c in 0..2 {
        if direction[c] == 0.0 {
            if from[c] < window[c].start || from[c] > window[c].end {
                return None;
            }
            continue;
        }
        let (a, b) = ((window[c].start - from[c]) / direction[c], (window[c].end - from[c]) / direction[c]);
        enters = enters.max(a.min(b));
        leaves = leaves.min(a.max(b));
    }
    let at = |share: f64| match share {
        0.0 => from,
        1.0 => to,
        _ => [from[0] + share * direction[0], from[1] + share * direction[1]],
    };
    (enters < leaves).then(|| [at(enters), at(leaves)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_a_wheel_roll_on() {
        let motion = ObstacleMotion {
            velocity: vec![2.0, 0.0],
            rotation: -90.0,
            centre: vec![0.0, 0.0],
            axis: Vec::new(),
            start: 1.0,
            ramp: 0.0,
        };
        let spoke = vec![[0.0, 0.0], [0.0, 1.0]];
        let wheel = MovingLines { lines: vec![spoke], reference_point: [5e5, 3.0], motion };
        let ground = RigidGeometry {
            lines: vec![vec![[0.0; 2], [1.0; 2]]],
            moving: vec![wheel],
            ..RigidGeometry::default()
        };
        assert_eq!(ground.lines_at(1.0)[1], [[5e5, 3.0], [5e5, 4.0]], "before it begins");
        let line = &ground.lines_at(2.0)[1];
        for (x, y) in line.iter().flatten().zip([5e5 + 2.0, 3.0, 5e5 + 3.0, 3.0]) {
            assert!((x - y).abs() < 1e-9, "{line:?}");
        }
        assert_eq!(ground.lines_at(2.0)[0], ground.lines[0]);
    }

    #[test]
    fn lines_end_at_the_window() {
        let window = [0.0..2.0, 0.0..1.0];
        let line = [[-1.0, 0.5], [1.0, 0.5], [1.0, 3.0], [1.5, 3.0], [1.5, -1.0], [9.0, -1.0]];
        let parts = clip_line(&line, &window);
        assert_eq!(
            parts,
            [vec![[0.0, 0.5], [1.0, 0.5], [1.0, 1.0]], vec![[1.5, 1.0], [1.5, 0.0]]],
            "in, up and out, and down through it"
        );
        assert!(clip_line(&[[-1.0, -1.0], [3.0, -0.5]], &window).is_empty());
    }
}
