//! Orthogonal recursive bisection: partition of points into boxes, one per rank, each with a halo around it.

use std::cmp::Ordering;

/// Closed axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundingBox<const D: usize> {
    /// Lower corner (m).
    pub low: [f64; D],
    /// Upper corner (m).
    pub high: [f64; D],
}

impl<const D: usize> BoundingBox<D> {
    /// Smallest box around points; `None` where there are no points.
    pub fn enclosing<'a>(points: impl IntoIterator<Item = &'a [f64; D]>) -> Option<Self> {
        let mut points = points.into_iter();
        let first = points.next()?;
        let start = Self { low: *first, high: *first };
        Some(points.fold(start, |bounds, x| Self {
            low: std::array::from_fn(|c| bounds.low[c].min(x[c])),
            high: std::array::from_fn(|c| bounds.high[c].max(x[c])),
        }))
    }

    /// Whether `x` lies in the box or at most `reach` (m) away from it: the halo of the box for sums with a support of that radius.
    pub fn contains_within(&self, x: &[f64; D], reach: f64) -> bool {
        let beyond = |c: usize| (self.low[c] - x[c]).max(x[c] - self.high[c]).max(0.0);
        (0..D).map(|c| beyond(c).powi(2)).sum::<f64>() <= reach * reach
    }

    /// Longest axis of the box; the first one of equal ones.
    fn longest_axis(&self) -> usize {
        let length = |c: usize| self.high[c] - self.low[c];
        (1..D).fold(0, |longest, c| if length(c) > length(longest) { c } else { longest })
    }
}

/// Indices of the points of other ranks in the halo of the box of `rank`: within `reach` (m) of it. Ascending.
pub fn halo_points<const D: usize>(
    positions: &[[f64; D]],
    owners: &[u32],
    rank: u32,
    bounds: &BoundingBox<D>,
    reach: f64,
) -> Vec<u32> {
    let all = positions.iter().zip(owners).enumerate();
    let near = all.filter(|(_, (x, owner))| **owner != rank && bounds.contains_within(x, reach));
    near.map(|(point, _)| point as u32).collect()
}

/// Node of the bisection tree: a cut, or the rank of a part of space.
#[derive(Clone, Copy, Debug, PartialEq)]
enum BisectionNode<const D: usize> {
    /// Points before `at` in the order of [`compare_from_axis`] belong to the node `low`, the others to `high`.
    Cut { axis: usize, position: [f64; D], low: usize, high: usize },
    /// Rank that owns a part of space.
    Rank(u32),
}

/// Bisection tree: cuts that partition space among ranks.
///
/// Points are cut at the weighted median across the longest axis of the box around them, and each half again, until there are as many parts
/// as ranks (Berger & Bokhari 1987; sheet: sph §3.9). For an odd number of ranks, the shares of the halves are in proportion to their
/// numbers of ranks. The boxes of two ranks have no inner point in common.
#[derive(Clone, Debug, PartialEq)]
pub struct Bisection<const D: usize> {
    nodes: Vec<BisectionNode<D>>,
    ranks: usize,
}

/// Order of points along `axis`. Ties are broken by the following axes, so that a lattice can be cut anywhere in a row.
fn compare_from_axis<const D: usize>(a: &[f64; D], b: &[f64; D], axis: usize) -> Ordering {
    let along = (0..D).map(|k| (axis + k) % D).map(|c| a[c].total_cmp(&b[c]));
    along.fold(Ordering::Equal, Ordering::then)
}

impl<const D: usize> Bisection<D> {
    /// Partitions points of the given weights among `ranks` ranks (zero counts as one); returns the tree and the rank of each point. The
    /// same points give the same cuts on every machine.
    ///
    /// On either side of a cut the weight differs from its share by at most half of the weight of one point, unless a side would then have
    /// fewer points than ranks; with at least as many points as ranks, every rank has a point. Points at the same position are ordered by
    /// their index.
    pub fn new(positions: &[[f64; D]], weights: &[u32], ranks: usize) -> (Self, Vec<u32>) {
        let ranks = ranks.max(1);
        let mut cuts = Self { nodes: Vec::with_capacity(2 * ranks), ranks };
        let mut owners = vec![0; positions.len()];
        let mut order: Vec<u32> = (0..positions.len() as u32).collect();
        cuts.partition(positions, weights, &mut order, 0..ranks, &mut owners);
        (cuts, owners)
    }

    /// Builds the node that partitions the points of `order` among `ranks`.
    fn partition(
        &mut self,
        positions: &[[f64; D]],
        weights: &[u32],
        order: &mut [u32],
        ranks: std::ops::Range<usize>,
        owners: &mut [u32],
    ) -> usize {
        let node = self.nodes.len();
        self.nodes.push(BisectionNode::Rank(ranks.start as u32));
        if ranks.len() == 1 {
            order.iter().for_each(|&point| owners[point as usize] = ranks.start as u32);
            return node;
        }
        let at = |point: u32| &positions[point as usize];
        let bounds = BoundingBox::enclosing(order.iter().map(|&point| at(point)));
        let axis = bounds.map_or(0, |bounds| bounds.longest_axis());
        order.sort_unstable_by(|&a, &b| compare_from_axis(at(a), at(b), axis).then(a.cmp(&b)));
        let middle = ranks.start + ranks.len() / 2;
        let shares = (middle - ranks.start, ranks.end - middle);
        let cut = cut_index(order.iter().map(|&point| u64::from(weights[point as usize])), shares);
        // Without points above the cut, all points are below it.
        let at = order.get(cut).map_or([f64::INFINITY; D], |&point| *at(point));
        let (below, above) = order.split_at_mut(cut);
        let low = self.partition(positions, weights, below, ranks.start..middle, owners);
        let high = self.partition(positions, weights, above, middle..ranks.end, owners);
        self.nodes[node] = BisectionNode::Cut { axis, position: at, low, high };
        node
    }

    /// Number of ranks.
    pub fn ranks(&self) -> usize {
        self.ranks
    }

    /// Rank whose part of space contains `x`.
    pub fn owner(&self, x: &[f64; D]) -> u32 {
        let mut node = 0;
        loop {
            match &self.nodes[node] {
                BisectionNode::Rank(rank) => return *rank,
                BisectionNode::Cut { axis, position: at, low, high } => {
                    node = if compare_from_axis(x, at, *axis) == Ordering::Less { *low } else { *high };
                }
            }
        }
    }
}

/// Number of points below the cut, so that their weight comes closest to its share. Each side has a point for each rank where there are
/// enough.
fn cut_index(weights: impl ExactSizeIterator<Item = u64> + Clone, (low, high): (usize, usize)) -> usize {
    let (count, ranks) = (weights.len(), (low + high) as u128);
    let target = weights.clone().map(u128::from).sum::<u128>() * low as u128;
    let (mut best, mut cut, mut sum) = (target, 0, 0u128);
    for (number, weight) in weights.enumerate() {
        sum += u128::from(weight);
        let apart = (sum * ranks).abs_diff(target);
        if apart < best {
            (best, cut) = (apart, number + 1);
        }
    }
    if count >= low + high { cut.clamp(low, count - high) } else { cut }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Total weight of each rank.
    fn loads(owners: &[u32], weights: &[u32], ranks: usize) -> Vec<u64> {
        let mut loads = vec![0; ranks];
        owners.iter().zip(weights).for_each(|(&owner, &weight)| loads[owner as usize] += u64::from(weight));
        loads
    }

    fn boxes<const D: usize>(
        positions: &[[f64; D]],
        owners: &[u32],
        ranks: usize,
    ) -> Vec<Option<BoundingBox<D>>> {
        let of = |rank: u32| positions.iter().zip(owners).filter(move |(_, o)| **o == rank).map(|(x, _)| x);
        (0..ranks as u32).map(|rank| BoundingBox::enclosing(of(rank))).collect()
    }

    fn shares_out<const D: usize>(positions: &[[f64; D]], weights: &[u32], ranks: usize) {
        let weights = &weights[..positions.len()];
        let (cuts, owners) = Bisection::new(positions, weights, ranks);
        // Each point belongs to exactly one rank, which is the owner of its position.
        assert_eq!(owners.len(), positions.len());
        for (i, (x, &owner)) in positions.iter().zip(&owners).enumerate() {
            assert!((owner as usize) < ranks);
            let alone = positions.iter().enumerate().all(|(j, y)| i == j || x != y);
            assert!(!alone || cuts.owner(x) == owner, "{x:?}");
        }
        // No two boxes have an inner point in common.
        let boxes = boxes(positions, &owners, ranks);
        for (k, a) in boxes.iter().enumerate() {
            for b in &boxes[..k] {
                let (Some(a), Some(b)) = (a, b) else { continue };
                assert!((0..D).any(|c| a.high[c] <= b.low[c] || b.high[c] <= a.low[c]), "{a:?} {b:?}");
            }
        }
        // Within the weight of one point per cut: each cut is off by half a point at most, and passes the error on in shares.
        let loads = loads(&owners, weights, ranks);
        if positions.len() >= 8 * ranks {
            let mean = loads.iter().sum::<u64>() as f64 / ranks as f64;
            let heaviest = f64::from(weights.iter().copied().max().unwrap_or(0));
            let depth = ranks.next_power_of_two().trailing_zeros();
            for load in &loads {
                assert!((*load as f64 - mean).abs() <= 0.5 * heaviest * f64::from(depth) + 1e-9, "{loads:?}");
            }
        }
        let empty = loads.iter().filter(|load| **load == 0).count();
        assert!(empty == 0 || positions.len() < ranks);
        // The halo equals the points that brute force finds near the box.
        for (rank, bounds) in boxes.iter().enumerate() {
            let Some(bounds) = bounds else { continue };
            let found = halo_points(positions, &owners, rank as u32, bounds, 0.7);
            let near = |x: &[f64; D]| {
                let nearest: [f64; D] = std::array::from_fn(|c| x[c].clamp(bounds.low[c], bounds.high[c]));
                (0..D).map(|c| (x[c] - nearest[c]).powi(2)).sum::<f64>() <= 0.49
            };
            let all = (0..positions.len()).filter(|&i| owners[i] != rank as u32 && near(&positions[i]));
            assert!(found.iter().map(|&i| i as usize).eq(all));
        }
    }

    proptest! {
        #[test]
        fn every_point_has_one_rank_and_the_ranks_share_evenly(
            coordinates in proptest::collection::vec(-3.0..3.0f64, 0..300),
            weights in proptest::collection::vec(1..5u32, 300),
            ranks in 1..20usize,
        ) {
            let (one, two, three) = (coordinates.as_chunks::<1>(), coordinates.as_chunks::<2>(), coordinates.as_chunks::<3>());
            shares_out(one.0, &weights, ranks);
            shares_out(two.0, &weights, ranks);
            shares_out(three.0, &weights, ranks);
        }

        #[test]
        fn a_lattice_is_cut_anywhere(columns in 1..12usize, rows in 1..12usize, ranks in 1..9usize) {
            let site = |k: usize| [(k % columns) as f64, (k / columns) as f64];
            let points: Vec<[f64; 2]> = (0..columns * rows).map(site).collect();
            shares_out(&points, &vec![1; points.len()], ranks);
        }
    }

    #[test]
    fn coincident_points_and_empty_sets_are_partitioned() {
        shares_out(&[[1.0, 2.0]; 24], &[1; 24], 3);
        shares_out::<2>(&[], &[], 5);
        shares_out(&[[0.0, 1.0]], &[7], 1);
    }

    #[test]
    fn the_longest_axis_is_cut_by_shares() {
        let points: Vec<[f64; 2]> = (0..12).map(|k| [f64::from(k), f64::from(k % 2)]).collect();
        let (cuts, owners) = Bisection::new(&points, &[1; 12], 3);
        assert_eq!(owners, [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2]);
        assert_eq!((cuts.ranks(), cuts.owner(&[-5.0, 0.0]), cuts.owner(&[4.5, 9.0])), (3, 0, 1));
        let heavy = [9, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1];
        assert_eq!(Bisection::new(&points, &heavy, 2).1, [0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1]);
    }
}
