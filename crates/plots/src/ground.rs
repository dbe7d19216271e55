//! Rigid geometry behind the points of a picture.

use std::ops::Range;

/// Rigid geometry that stands still: lines in a plane, or ground seen from above in space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ground {
    /// Lines in the plane, with their corners (m).
    pub lines: Vec<Vec<[f64; 2]>>,
    /// The ground in space.
    pub heights: Option<Heights>,
    /// What is not shown and why, in words; empty where all is.
    pub missing: String,
}

/// Heights on a lattice across the axis against gravity.
#[derive(Clone, Debug, PartialEq)]
pub struct Heights {
    /// Nodes along the two axes of the lattice, the lower axis first.
    pub counts: [usize; 2],
    /// Place of the first node (m).
    pub origin: [f64; 2],
    /// Distance of the nodes along the two axes (m).
    pub spacing: [f64; 2],
    /// Heights (m), the first axis fastest; NaN where there is no ground.
    pub values: Vec<f64>,
}

/// The parts of a line that lie in a window.
pub fn within(line: &[[f64; 2]], window: &[Range<f64>; 2]) -> Vec<Vec<[f64; 2]>> {
    let mut parts: Vec<Vec<[f64; 2]>> = Vec::new();
    for pair in line.windows(2) {
        let Some([from, to]) = cut(pair[0], pair[1], window) else { continue };
        match parts.last_mut() {
            Some(part) if part.last() == Some(&from) => part.push(to),
            _ => parts.push(vec![from, to]),
        }
    }
    parts
}

/// The part of a straight piece that lies in a window (Liang & Barsky 1984).
fn cut(from: [f64; 2], to: [f64; 2], window: &[Range<f64>; 2]) -> Option<[[f64; 2]; 2]> {
    let way = [to[0] - from[0], to[1] - from[1]];
    let (mut enters, mut leaves) = (0f64, 1f64);
    for c in 0..2 {
        if way[c] == 0.0 {
            if from[c] < window[c].start || from[c] > window[c].end {
                return None;
            }
            continue;
        }
        let (a, b) = ((window[c].start - from[c]) / way[c], (window[c].end - from[c]) / way[c]);
        enters = enters.max(a.min(b));
        leaves = leaves.min(a.max(b));
    }
    let at = |share: f64| match share {
        0.0 => from,
        1.0 => to,
        _ => [from[0] + share * way[0], from[1] + share * way[1]],
    };
    (enters < leaves).then(|| [at(enters), at(leaves)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_at_the_window() {
        let window = [0.0..2.0, 0.0..1.0];
        let line = [[-1.0, 0.5], [1.0, 0.5], [1.0, 3.0], [1.5, 3.0], [1.5, -1.0], [9.0, -1.0]];
        let parts = within(&line, &window);
        assert_eq!(
            parts,
            [vec![[0.0, 0.5], [1.0, 0.5], [1.0, 1.0]], vec![[1.5, 1.0], [1.5, 0.0]]],
            "in, up and out, and down through it"
        );
        assert!(within(&[[-1.0, -1.0], [3.0, -0.5]], &window).is_empty());
    }
}
