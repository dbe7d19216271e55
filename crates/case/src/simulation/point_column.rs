//! One quantity of all points, as slices of the arrays of a solver.

use std::ops::Index;

/// One quantity of all points: slices of the arrays of the solver, one for each body where its points are stored apart. Nothing is copied.
#[derive(Clone, Debug)]
pub struct PointColumn<'a, T> {
    slices: Vec<&'a [T]>,
}

impl<'a, T> PointColumn<'a, T> {
    /// Column of the slices, in the order of the points.
    pub fn new(slices: impl IntoIterator<Item = &'a [T]>) -> Self {
        Self { slices: slices.into_iter().collect() }
    }

    /// Slices of the column, in the order of the points.
    pub fn slices(&self) -> &[&'a [T]] {
        &self.slices
    }

    /// Column as one slice; `None` where its points are stored apart.
    pub fn as_slice(&self) -> Option<&'a [T]> {
        match self.slices[..] {
            [] => Some(&[]),
            [one] => Some(one),
            _ => None,
        }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.slices.iter().map(|slice| slice.len()).sum()
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Iterator over the values, in the order of the points.
    pub fn iter(&self) -> impl Iterator<Item = &'a T> + use<'a, '_, T> {
        self.slices.iter().copied().flatten()
    }

    /// Value of a point by its position in the order of the points; `None` beyond the last.
    pub fn get(&self, index: usize) -> Option<&'a T> {
        let mut left = index;
        for slice in &self.slices {
            match slice.get(left) {
                Some(value) => return Some(value),
                None => left -= slice.len(),
            }
        }
        None
    }
}

impl<T> Index<usize> for PointColumn<'_, T> {
    type Output = T;

    /// Value of a point by its position in the order of the points.
    ///
    /// # Panics
    /// Beyond the last point.
    fn index(&self, index: usize) -> &T {
        match self.get(index) {
            Some(value) => value,
            None => panic!("point {index} of {}", self.len()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_of_slices_is_read_as_one_list() {
        let (first, second) = ([1, 2], [3]);
        let column = PointColumn::new([&first[..], &[], &second[..]]);
        assert_eq!(column.iter().copied().collect::<Vec<i32>>(), [1, 2, 3]);
        assert_eq!((column.len(), column[2], column.get(3)), (3, 3, None));
        assert!(column.as_slice().is_none());
        assert_eq!(PointColumn::new([&first[..]]).as_slice().map(<[i32]>::as_ptr), Some(first.as_ptr()));
    }
}
