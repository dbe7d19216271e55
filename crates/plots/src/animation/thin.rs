//! What is left out of an animation that would be too large for a page.

use super::{Panel, View};

/// Frames that are always kept, as far as the run has them, before points are left out.
const FRAMES: usize = 24;
/// Frames of a run at most.
const MOST: usize = 120;

/// What is kept of a run: some frames, and of each one in `share` of its points.
pub(super) struct Kept<'a> {
    pub panel: Panel<'a>,
    pub share: u64,
}

/// What is kept of the runs within the bytes of a view, and what was left out, in words.
pub(super) fn thin<'a>(panels: &[Panel<'a>], view: &View, fields: usize) -> (Vec<Kept<'a>>, String) {
    // Places and widths of 16 bits, values of 8; widths are mostly those of the frame before.
    let each = (3 * view.axes.len() + fields) as f64;
    let bytes = |panel: &Panel<'_>| each * panel.frames.iter().map(|f| f.ids.len() as f64).sum::<f64>();
    let budget = if view.bytes == 0 { super::BYTES } else { view.bytes } as f64;
    let excess = panels.iter().map(bytes).sum::<f64>() / budget;
    let mut words = Vec::new();
    let mut one = |panel: &Panel<'a>| {
        let count = panel.frames.len();
        let wanted = (count as f64 / excess.max(1.0)) as usize;
        let wanted = wanted.clamp(FRAMES.min(count), MOST.max(FRAMES)).min(count);
        let frames: Vec<_> = evenly(count, wanted).into_iter().map(|k| panel.frames[k]).collect();
        let left = excess * frames.len() as f64 / count.max(1) as f64;
        let share = left.ceil().max(1.0) as u64;
        let mut said = Vec::new();
        if frames.len() < panel.of {
            said.push(format!("{} of {} frames", frames.len(), panel.of));
        }
        if share > 1 {
            said.push(format!("one in {share} of the points"));
        }
        if !said.is_empty() {
            let name = if panels.len() > 1 { format!("{}: ", panel.name) } else { String::new() };
            words.push(format!("{name}{}", said.join(", ")));
        }
        Kept { panel: Panel { frames, ..panel.clone() }, share }
    };
    let kept = panels.iter().map(&mut one).collect();
    (kept, words.join("; "))
}

/// Numbers of `wanted` of `count` frames, evenly, the first and the last among them.
fn evenly(count: usize, wanted: usize) -> Vec<usize> {
    match wanted {
        0 => Vec::new(),
        1 => vec![count - 1],
        _ => (0..wanted).map(|k| (k * (count - 1) + (wanted - 1) / 2) / (wanted - 1)).collect(),
    }
}

/// Places of the points that are kept: the same ones in every frame, in no order that a lattice of points could have.
pub(super) fn shown(ids: &[u64], share: u64) -> Vec<usize> {
    // Fibonacci hashing (Knuth): neighbouring numbers fall far apart.
    let hash = |id: u64| id.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32;
    (0..ids.len()).filter(|&i| share <= 1 || hash(ids[i]).is_multiple_of(share)).collect()
}
