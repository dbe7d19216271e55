//! What a point knows of the obstacles that it presses on (docs/theory/mpm.md, obstacles).

/// A point of a body whose obstacles act on points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pressed<const D: usize> {
    /// Half the width of the point (m).
    pub half: f64,
    /// Distance from a surface below which the point presses on it (m): `half`, or less where the point began nearer and has not
    /// been farther away since.
    pub reach: f64,
    /// How far it may go from where it was last looked at before it can come within `half` of a surface (m).
    pub free: f64,
    /// How far obstacles could have come when it was last looked at (m).
    pub swept: f64,
    /// Its displacement when it was last looked at (m).
    pub seen: [f64; D],
    /// Elastic slip along the surface (m).
    pub spring: [f64; D],
    /// Number plus one of the obstacle that holds it, which is one that nothing lifts off; zero for none.
    pub bond: u32,
    /// Force of the obstacles on it in the step (N).
    pub force: [f64; D],
}

impl<const D: usize> Pressed<D> {
    /// A point of no width that has not been looked at.
    pub const NEW: Self = Self {
        half: 0.0,
        reach: 0.0,
        free: 0.0,
        swept: 0.0,
        seen: [0.0; D],
        spring: [0.0; D],
        bond: 0,
        force: [0.0; D],
    };
}

/// Numbers that are saved of a point, beside two vectors.
const SCALARS: usize = 5;

/// Everything that changes, for a checkpoint; forces are found anew.
pub fn saved<const D: usize>(points: &[Pressed<D>]) -> Vec<f64> {
    let mut numbers = Vec::with_capacity(points.len() * (SCALARS + 2 * D));
    for point in points {
        numbers.extend([point.half, point.reach, point.free, f64::from(point.bond), point.swept]);
        numbers.extend(point.seen);
        numbers.extend(point.spring);
    }
    numbers
}

/// Takes the numbers of [`saved`] for `count` points; `None` where they do not fit. Without points with obstacles there are none.
pub fn restore<const D: usize>(points: &mut Vec<Pressed<D>>, numbers: &[f64], count: usize) -> Option<()> {
    let each = SCALARS + 2 * D;
    let expected = if points.is_empty() { 0 } else { count * each };
    if numbers.len() != expected {
        return None;
    }
    points.clear();
    points.extend(numbers.chunks_exact(each).map(|numbers| {
        let vector = |first: usize| std::array::from_fn(|c| numbers[first + c]);
        Pressed {
            half: numbers[0],
            reach: numbers[1],
            free: numbers[2],
            bond: numbers[3] as u32,
            swept: numbers[4],
            seen: vector(SCALARS),
            spring: vector(SCALARS + D),
            force: [0.0; D],
        }
    }));
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_come_back_from_their_numbers() {
        let point = Pressed::<2> {
            half: 0.5,
            reach: 0.25,
            free: -1.0,
            swept: 2.0,
            seen: [1.0, 2.0],
            spring: [3.0, 4.0],
            bond: 3,
            force: [0.0; 2],
        };
        let points = vec![point, Pressed { half: 7.0, ..point }];
        let mut again = vec![Pressed::NEW; 5];
        restore(&mut again, &saved(&points), 2).unwrap();
        assert_eq!(again, points);
        assert!(restore(&mut again, &[0.0; 8], 2).is_none());
        assert!(restore::<2>(&mut Vec::new(), &[], 2).is_some());
    }
}
