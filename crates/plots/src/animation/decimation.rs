//! Decimation of frames and points of animations that would be too large for a page.

use std::collections::HashMap;

use colluvium_case::Snapshot;

use crate::animation::{Panel, View, shape};

/// Smallest number of frames that remain, as far as the run has them, before points are left out.
const MIN_FRAMES: usize = 24;
/// Largest number of frames of a run in an animation.
const MAX_FRAMES: usize = 120;

/// Run with the frames and points that remain after decimation. Where points are left out, each remaining point represents a group of
/// neighbours.
pub(super) struct DecimatedRun<'a> {
    /// Frames and fields of the run, as a panel of the page.
    pub panel: Panel<'a>,
    /// Groups of points that are drawn as one; `None` where each point is drawn.
    pub blocks: Option<DecimationBlocks>,
}

/// Leaves out frames and points of runs, so that the page does not exceed the bytes of the view. Returns the reduced runs, and a text that
/// states the numbers of frames and points left out.
pub(super) fn decimate<'a>(
    panels: &[Panel<'a>],
    view: &View,
    fields: usize,
) -> (Vec<DecimatedRun<'a>>, String) {
    // Positions and widths of 16 bits, values of 8; widths are mostly those of the frame before.
    let each = (3 * view.axes.len() + fields) as f64;
    let bytes = |panel: &Panel<'_>| each * panel.frames.iter().map(|f| f.ids.len() as f64).sum::<f64>();
    let budget = if view.bytes == 0 { crate::animation::DEFAULT_BYTES } else { view.bytes } as f64;
    let excess = panels.iter().map(bytes).sum::<f64>() / budget;
    let mut words = Vec::new();
    let mut one = |panel: &Panel<'a>| {
        let count = panel.frames.len();
        let wanted = (count as f64 / excess.max(1.0)) as usize;
        let wanted = wanted.clamp(MIN_FRAMES.min(count), MAX_FRAMES.max(MIN_FRAMES)).min(count);
        let frames: Vec<_> = evenly_spaced(count, wanted).into_iter().map(|k| panel.frames[k]).collect();
        let share = excess * frames.len() as f64 / count.max(1) as f64;
        let panel = Panel { frames, ..panel.clone() };
        let blocks = (share > 1.0).then(|| DecimationBlocks::from_panel(&panel, view, share));
        let mut notes = Vec::new();
        if panel.frames.len() < panel.frame_count {
            notes.push(format!("{} of {} frames", panel.frames.len(), panel.frame_count));
        }
        if let Some(blocks) = &blocks {
            notes.push(format!("one of {} points, with the width of its block", blocks.points_per_block()));
        }
        if !notes.is_empty() {
            let name = if panels.len() > 1 { format!("{}: ", panel.name) } else { String::new() };
            words.push(format!("{name}{}", notes.join(", ")));
        }
        DecimatedRun { panel, blocks }
    };
    let kept = panels.iter().map(&mut one).collect();
    (kept, words.join("; "))
}

/// Indices of `wanted` of `count` frames, evenly spaced, the first and the last among them.
fn evenly_spaced(count: usize, wanted: usize) -> Vec<usize> {
    match wanted {
        0 => Vec::new(),
        1 => vec![count - 1],
        _ => (0..wanted).map(|k| (k * (count - 1) + (wanted - 1) / 2) / (wanted - 1)).collect(),
    }
}

/// Size and position of a group of points relative to the point that represents it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DecimationBlock {
    /// Width of the group over that of the point, along each axis.
    pub width_ratio: [f64; 3],
    /// Vector from the point to the middle of its group (m).
    pub offset: [f64; 3],
}

/// Points that remain after decimation, equal in all frames. Each is the one nearest to the middle of a group of neighbours. Bodies that
/// move as a whole stay whole in the picture.
pub(super) struct DecimationBlocks {
    blocks: HashMap<u64, DecimationBlock>,
    point_count: usize,
}

impl DecimationBlocks {
    /// Selects about one point in `share`, by the positions in the first frame that contains a point.
    fn from_panel(panel: &Panel<'_>, view: &View, share: f64) -> Self {
        let shape = shape(panel);
        // A flow column has its depth as height.
        let axes: Vec<usize> = view
            .axes
            .iter()
            .copied()
            .filter(|axis| shape != "depth" || *axis != view.vertical_axis)
            .collect();
        let mut blocks = Self { blocks: HashMap::new(), point_count: 0 };
        let mut known: std::collections::HashSet<u64> = std::collections::HashSet::new();
        for frame in &panel.frames {
            let new: Vec<usize> = (0..frame.ids.len()).filter(|&i| known.insert(frame.ids[i])).collect();
            if !new.is_empty() {
                blocks.point_count += new.len();
                blocks.add(frame, &new, &axes, share, shape == "disk");
            }
        }
        blocks
    }

    /// Groups the points that are in a frame for the first time.
    fn add(&mut self, frame: &Snapshot, new: &[usize], axes: &[usize], share: f64, round: bool) {
        let cells = BlockCells::new(frame, new, axes);
        let mut found = cells.sort(cells.edge(share));
        // Sorted by point, independent of the order of the blocks.
        found.sort_unstable_by_key(|members| members[0]);
        for members in found {
            let (first, count) = (members[0], members.len() as f64);
            let (mut middle, mut wide) = (frame.positions[first], frame.extents[first]);
            for &axis in axes {
                let (low, high) = cells.extent(&members, axis);
                (middle[axis], wide[axis]) = (0.5 * (low + high), high - low);
            }
            let away =
                |i: &usize| axes.iter().map(|&c| (frame.positions[*i][c] - middle[c]).powi(2)).sum::<f64>();
            let Some(&point) = members.iter().min_by(|a, b| away(a).total_cmp(&away(b))) else { continue };
            let mut block = DecimationBlock { width_ratio: [1.0; 3], offset: [0.0; 3] };
            for &axis in axes {
                let own = frame.extents[point][axis];
                if round {
                    block.width_ratio[axis] =
                        count.powf(1.0 / axes.len() as f64).min(wide[axis] / own.max(1e-300)).max(1.0);
                } else if own > 0.0 {
                    block.width_ratio[axis] = (wide[axis] / own).max(1.0);
                    block.offset[axis] = middle[axis] - frame.positions[point][axis];
                }
            }
            self.blocks.insert(frame.ids[point], block);
        }
    }

    /// Number of points that a remaining point represents.
    fn points_per_block(&self) -> u64 {
        (self.point_count as f64 / self.blocks.len().max(1) as f64).round().max(1.0) as u64
    }

    /// Group that a point represents; `None` where the point is left out.
    pub fn get(&self, id: u64) -> Option<&DecimationBlock> {
        self.blocks.get(&id)
    }

    /// Largest ratio of the width of a group to that of its point.
    pub fn widest(&self) -> f64 {
        self.blocks.values().flat_map(|block| block.width_ratio).fold(1.0, f64::max)
    }
}

/// Points that are sorted into cells, each with a group of neighbours.
struct BlockCells<'a> {
    frame: &'a Snapshot,
    points: &'a [usize],
    axes: &'a [usize],
    low: Vec<f64>,
    /// Width of a point along each axis (m).
    width: Vec<f64>,
}

impl<'a> BlockCells<'a> {
    /// Grid of cells as wide as the median point, over some points of a frame.
    fn new(frame: &'a Snapshot, points: &'a [usize], axes: &'a [usize]) -> Self {
        let low = |axis: &usize| {
            let ends = points.iter().map(|&i| frame.positions[i][*axis] - 0.5 * frame.extents[i][*axis]);
            ends.filter(|x| x.is_finite()).fold(f64::INFINITY, f64::min)
        };
        let width = |axis: &usize| {
            let mut widths: Vec<f64> = points.iter().map(|&i| frame.extents[i][*axis]).collect();
            let middle = widths.len() / 2;
            let median = *widths.select_nth_unstable_by(middle, f64::total_cmp).1;
            if median > 0.0 && median.is_finite() { median } else { 1.0 }
        };
        Self {
            frame,
            points,
            axes,
            low: axes.iter().map(low).collect(),
            width: axes.iter().map(width).collect(),
        }
    }

    /// Groups of the points in cells with an edge of `edge` point widths.
    fn sort(&self, edge: f64) -> Vec<Vec<usize>> {
        let mut blocks: HashMap<(u32, [i64; 3]), Vec<usize>> = HashMap::new();
        for &i in self.points {
            let mut key = [0; 3];
            for (c, &axis) in self.axes.iter().enumerate() {
                // A thousandth of a point width: points on the border of two blocks fall to one side regardless of round-off.
                let steps = (self.frame.positions[i][axis] - self.low[c]) / self.width[c] + 1e-3;
                key[c] = (steps / edge).floor() as i64;
            }
            let body = self.frame.bodies.get(i).copied().unwrap_or(0);
            blocks.entry((body, key)).or_default().push(i);
        }
        blocks.into_values().collect()
    }

    /// Edge of the cells (point widths) at which at most one point in `share` remains. It is a whole number where that leaves about as
    /// many, since the groups of a lattice are then equal.
    fn edge(&self, share: f64) -> f64 {
        let largest = (self.points.len() as f64 / share).max(1.0);
        let count = |edge: f64| self.sort(edge).len() as f64;
        let whole = share.powf(1.0 / self.axes.len().max(1) as f64).ceil();
        let mut alike = [whole, whole + 1.0].into_iter();
        if let Some(edge) = alike.find(|edge| (0.2 * largest..=largest).contains(&count(*edge))) {
            return edge;
        }
        let (mut low, mut high) = (1e-6f64, 1e6f64);
        for _ in 0..24 {
            let middle = (low * high).sqrt();
            if count(middle) > largest { low = middle } else { high = middle }
        }
        high
    }

    /// Extent of a group of points along an axis (m).
    fn extent(&self, members: &[usize], axis: usize) -> (f64, f64) {
        members.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &i| {
            let (x, half) = (self.frame.positions[i][axis], 0.5 * self.frame.extents[i][axis]);
            (low.min(x - half), high.max(x + half))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Slab of 40 × 10 points that falls as a whole.
    fn slab(time: f64) -> Snapshot {
        let place = |k: usize| [0.1 * (k % 40) as f64 + 0.05, 0.1 * (k / 40) as f64 + 0.05 - time, 0.0];
        Snapshot {
            time,
            ids: (0..400).collect(),
            bodies: vec![0; 400],
            positions: (0..400).map(place).collect(),
            extents: vec![[0.1, 0.1, 0.1]; 400],
            ..Snapshot::default()
        }
    }

    #[test]
    fn a_decimated_slab_in_rigid_motion_has_no_gaps() {
        let frames = [slab(0.0), slab(0.7)];
        let panel = Panel { name: "a".into(), frames: frames.iter().collect(), frame_count: 2 };
        let view = View { axes: vec![0, 1], vertical_axis: 1, ..View::default() };
        for share in [1.5, 4.0, 9.0, 17.0] {
            let blocks = DecimationBlocks::from_panel(&panel, &view, share);
            assert!(blocks.blocks.len() as f64 <= 400.0 / share, "{share}: {}", blocks.blocks.len());
            for frame in &frames {
                let mut area = 0.0;
                let mut drawn = Vec::new();
                for (i, id) in frame.ids.iter().enumerate() {
                    let Some(block) = blocks.get(*id) else { continue };
                    let [x, y] = [0, 1].map(|c| frame.positions[i][c] + block.offset[c]);
                    let [w, h] = [0, 1].map(|c| frame.extents[i][c] * block.width_ratio[c]);
                    area += w * h;
                    drawn.push([x - 0.5 * w, x + 0.5 * w, y - 0.5 * h, y + 0.5 * h]);
                }
                assert!((area - 4.0).abs() < 1e-9, "{share}: {area} m² of 4 m²");
                for x in &frame.positions {
                    let covers = |r: &&[f64; 4]| r[0] < x[0] && x[0] < r[1] && r[2] < x[1] && x[1] < r[3];
                    assert_eq!(drawn.iter().filter(covers).count(), 1, "{x:?}");
                }
            }
        }
    }

    #[test]
    fn points_that_enter_later_are_decimated_at_the_same_rate() {
        let (early, mut late) = (slab(0.0), slab(1.0));
        late.ids = (200..600).collect();
        let panel = Panel { name: "a".into(), frames: vec![&early, &late], frame_count: 2 };
        let blocks = DecimationBlocks::from_panel(
            &panel,
            &View { axes: vec![0, 1], vertical_axis: 1, ..View::default() },
            4.0,
        );
        let shown = |frame: &Snapshot| frame.ids.iter().filter(|id| blocks.get(**id).is_some()).count();
        assert!(blocks.point_count == 600 && shown(&early) == 100 && (50..=100).contains(&shown(&late)));
    }
}
