//! Bounding volume tree of facets.

/// Facets in a leaf.
const LEAF_FACETS: usize = 4;
/// Largest depth of the tree: more than 2³² facets need when they are halved at each level.
const MAX_DEPTH: usize = 64;

/// Node of the tree: box around its facets.
#[derive(Clone, Debug)]
struct BoundingVolumeNode<const D: usize> {
    low: [f64; D],
    high: [f64; D],
    /// First item, or second child where `count` is zero; the first child follows its parent.
    first: u32,
    count: u32,
}

/// Binary tree of bounding boxes, split at the median along their longest axis.
#[derive(Clone, Debug)]
pub(crate) struct BoundingVolumeTree<const D: usize> {
    nodes: Vec<BoundingVolumeNode<D>>,
    order: Vec<u32>,
}

impl<const D: usize> BoundingVolumeTree<D> {
    /// Tree of these boxes, each with lower and upper corner.
    pub(crate) fn new(boxes: &[([f64; D], [f64; D])]) -> Self {
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        let mut nodes = Vec::with_capacity(boxes.len());
        if !boxes.is_empty() {
            build_node(boxes, &mut order, 0, &mut nodes);
        }
        Self { nodes, order }
    }

    /// Calls `visit` with each item whose box is within a distance of `x`. It receives the square of that distance (m²), which it may
    /// reduce.
    pub(crate) fn visit(&self, x: &[f64; D], mut square: f64, mut visit: impl FnMut(usize, &mut f64)) {
        let mut stack = [0u32; MAX_DEPTH];
        let mut top = usize::from(!self.nodes.is_empty());
        while top > 0 {
            top -= 1;
            let at = stack[top] as usize;
            let node = &self.nodes[at];
            if square_distance_to_box(node, x) > square {
                continue;
            }
            if node.count > 0 {
                let items = node.first as usize..(node.first + node.count) as usize;
                for item in &self.order[items] {
                    visit(*item as usize, &mut square);
                }
                continue;
            }
            // The nearer child is on top of the stack and is visited first.
            let (left, right) = (at as u32 + 1, node.first);
            let nearer_left = square_distance_to_box(&self.nodes[left as usize], x)
                <= square_distance_to_box(&self.nodes[right as usize], x);
            let (near, far) = if nearer_left { (left, right) } else { (right, left) };
            stack[top] = far;
            stack[top + 1] = near;
            top += 2;
        }
    }

    /// Calls `visit` with each item whose box overlaps the box between `low` and `high`.
    pub(crate) fn visit_box(&self, low: &[f64; D], high: &[f64; D], mut visit: impl FnMut(usize)) {
        let mut stack = [0u32; MAX_DEPTH];
        let mut top = usize::from(!self.nodes.is_empty());
        while top > 0 {
            top -= 1;
            let at = stack[top] as usize;
            let node = &self.nodes[at];
            if (0..D).any(|c| node.low[c] > high[c] || node.high[c] < low[c]) {
                continue;
            }
            if node.count > 0 {
                let items = node.first as usize..(node.first + node.count) as usize;
                self.order[items].iter().for_each(|item| visit(*item as usize));
            } else {
                stack[top] = at as u32 + 1;
                stack[top + 1] = node.first;
                top += 2;
            }
        }
    }

    /// Corners of the box around all items (m).
    pub(crate) fn bounds(&self) -> ([f64; D], [f64; D]) {
        self.nodes.first().map_or(([0.0; D], [0.0; D]), |node| (node.low, node.high))
    }
}

/// Square of the distance of `x` from a box (m²).
fn square_distance_to_box<const D: usize>(node: &BoundingVolumeNode<D>, x: &[f64; D]) -> f64 {
    (0..D).map(|c| (node.low[c] - x[c]).max(x[c] - node.high[c]).max(0.0).powi(2)).sum()
}

/// Adds a node for the facets in `order` and, where they are many, its children.
fn build_node<const D: usize>(
    boxes: &[([f64; D], [f64; D])],
    order: &mut [u32],
    first: usize,
    nodes: &mut Vec<BoundingVolumeNode<D>>,
) {
    let (mut low, mut high) = ([f64::INFINITY; D], [f64::NEG_INFINITY; D]);
    for item in order.iter() {
        let (l, h) = &boxes[*item as usize];
        for c in 0..D {
            low[c] = low[c].min(l[c]);
            high[c] = high[c].max(h[c]);
        }
    }
    let at = nodes.len();
    let count = order.len();
    nodes.push(BoundingVolumeNode { low, high, first: first as u32, count: count as u32 });
    if count <= LEAF_FACETS {
        return;
    }
    let longest =
        (0..D).max_by(|a, b| (high[*a] - low[*a]).total_cmp(&(high[*b] - low[*b]))).unwrap_or_default();
    let middle = |item: u32| boxes[item as usize].0[longest] + boxes[item as usize].1[longest];
    let half = count / 2;
    order.select_nth_unstable_by(half, |a, b| middle(*a).total_cmp(&middle(*b)).then(a.cmp(b)));
    let (left, right) = order.split_at_mut(half);
    build_node(boxes, left, first, nodes);
    nodes[at].count = 0;
    nodes[at].first = nodes.len() as u32;
    build_node(boxes, right, first + half, nodes);
}
