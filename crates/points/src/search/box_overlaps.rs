//! Overlapping pairs among many boxes.

/// Pairs of boxes, given by their lowest and highest corners, that have inner points in common. The first index is the smaller one; pairs
/// are sorted by the second index and then by the first. Sort and sweep along the longest axis keeps the number of comparisons small for
/// boxes side by side.
pub fn overlapping_boxes<C: AsRef<[f64]>>(boxes: &[(C, C)]) -> Vec<(usize, usize)> {
    let boxes: Vec<(&[f64], &[f64])> =
        boxes.iter().map(|(low, high)| (low.as_ref(), high.as_ref())).collect();
    let dimension = boxes.iter().map(|(low, _)| low.len()).min().unwrap_or(0);
    let spread = |axis: usize| {
        let low = boxes.iter().map(|(low, _)| low[axis]).fold(f64::INFINITY, f64::min);
        let size: f64 = boxes.iter().map(|(low, high)| high[axis] - low[axis]).sum();
        let high = boxes.iter().map(|(_, high)| high[axis]).fold(f64::NEG_INFINITY, f64::max);
        (high - low) / size
    };
    let Some(axis) = (0..dimension).max_by(|a, b| spread(*a).total_cmp(&spread(*b))) else {
        return Vec::new();
    };
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    order.sort_by(|a, b| boxes[*a].0[axis].total_cmp(&boxes[*b].0[axis]).then(a.cmp(b)));
    let (mut open, mut pairs): (Vec<usize>, Vec<(usize, usize)>) = (Vec::new(), Vec::new());
    for &number in &order {
        let (low, high) = boxes[number];
        open.retain(|other| boxes[*other].1[axis] > low[axis]);
        let meets = |other: &&usize| {
            let (from, to) = boxes[**other];
            (0..dimension).all(|c| from[c] < high[c] && low[c] < to[c])
        };
        pairs.extend(open.iter().filter(meets).map(|other| (number.min(*other), number.max(*other))));
        open.push(number);
    }
    pairs.sort_unstable_by_key(|(first, second)| (*second, *first));
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn overlapping_boxes_are_those_of_an_all_pairs_search() {
        let corner = || prop::collection::vec(0..20i32, 3);
        let one = (corner(), prop::collection::vec(1..6i32, 3));
        proptest!(|(boxes in prop::collection::vec(one, 0..40))| {
            let real = |v: &[i32]| v.iter().map(|x| f64::from(*x)).collect::<Vec<f64>>();
            let boxes: Vec<_> = boxes
                .iter()
                .map(|(low, size)| (real(low), low.iter().zip(size).map(|(a, b)| f64::from(a + b)).collect::<Vec<f64>>()))
                .collect();
            let meet = |a: usize, b: usize| (0..3).all(|c| boxes[a].0[c] < boxes[b].1[c] && boxes[b].0[c] < boxes[a].1[c]);
            let pairs = (0..boxes.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
            let expected: Vec<_> = pairs.filter(|(a, b)| meet(*a, *b)).collect();
            prop_assert_eq!(overlapping_boxes(&boxes), expected);
        });
    }
}
