//! Structures of arrays: operations on all columns.

use std::io;

use colluvium_points::struct_of_arrays::read_column;
use colluvium_points::{ScratchBuffers, struct_of_arrays};
use proptest::prelude::*;

#[derive(Clone, Copy, Debug, PartialEq)]
struct Turn(f64);

impl From<Turn> for [f64; 1] {
    fn from(turn: Turn) -> Self {
        [turn.0]
    }
}

impl From<[f64; 1]> for Turn {
    fn from([turn]: [f64; 1]) -> Self {
        Self(turn)
    }
}

struct_of_arrays! {
    /// Points of the test.
    struct Points<const D: usize> {
        /// Ids.
        id: u32,
        /// Positions.
        place: [f64; D],
        /// Whether the point is held.
        held: bool,
        /// Rotations.
        turn: Turn as [f64; 1],
        /// Matrix of each point; this column may be empty.
        matrix: [[f64; D]; D],
    }
}

fn points(count: usize) -> Points<2> {
    Points {
        id: (0..count as u32).collect(),
        place: (0..count).map(|i| [i as f64, -0.5 * i as f64]).collect(),
        held: (0..count).map(|i| i % 3 == 0).collect(),
        turn: (0..count).map(|i| Turn(0.1 * i as f64)).collect(),
        matrix: Vec::new(),
    }
}

proptest! {
    #[test]
    fn a_permutation_and_its_inverse_restore_all_columns(keys in prop::collection::vec(0u32..50, 0..200)) {
        let mut order: Vec<u32> = (0..keys.len() as u32).collect();
        order.sort_by_key(|&i| (keys[i as usize], i));
        let mut back = vec![0; order.len()];
        order.iter().zip(0..).for_each(|(&from, to)| back[from as usize] = to);
        let (start, mut spare) = (points(keys.len()), ScratchBuffers::default());
        let mut moved = start.clone();
        moved.reorder(&order, &mut spare);
        prop_assert_eq!(&moved.id, &order);
        prop_assert_eq!(moved.uneven(), None);
        moved.reorder(&back, &mut spare);
        prop_assert_eq!(moved, start);
    }

    #[test]
    fn columns_read_back_are_bit_identical(count in 0usize..9000, value in any::<u64>()) {
        let mut written = points(count);
        if let Some(first) = written.place.first_mut() {
            first[0] = f64::from_bits(value);
        }
        let mut bytes = Vec::new();
        written.write(&mut bytes).unwrap();
        let mut read = points(3);
        read.read(&mut bytes.as_slice()).unwrap();
        let bits = |points: &Points<2>| points.place.iter().flatten().map(|v| v.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(&read), bits(&written));
        prop_assert_eq!((read.id, read.held, read.turn), (written.id, written.held, written.turn));
        prop_assert!(points(0).read(&mut &bytes[..bytes.len() - 1]).is_err());
    }
}

#[test]
fn retaining_points_equals_reordering_to_them() {
    let (mut kept, mut named) = (points(20), points(20));
    assert_eq!(kept.retain(|i| i % 4 != 1), 15);
    let order: Vec<u32> = (0..20).filter(|i| i % 4 != 1).collect();
    named.reorder(&order, &mut ScratchBuffers::default());
    assert_eq!(kept, named);
}

#[test]
fn points_picked_out_and_put_back_are_unchanged() {
    let (mut all, from) = (points(7), points(7));
    let (mut even, mut odd) = (points(1), points(0));
    even.gather_from(&from, &[0, 2, 4, 6]);
    odd.gather_from(&from, &[1, 3, 5]);
    assert_eq!(
        (even.id.as_slice(), odd.held.as_slice()),
        ([0, 2, 4, 6].as_slice(), [false, true, false].as_slice())
    );
    assert!(even.matrix.is_empty());
    all.turn.fill(Turn(9.0));
    all.scatter_from(&even, &[0, 2, 4, 6]);
    all.scatter_from(&odd, &[1, 3, 5]);
    assert_eq!(all, from);
    let mut whole = points(2);
    whole.gather(&[&odd, &even], &[(1, 0), (0, 0), (1, 1), (0, 1), (1, 2), (0, 2), (1, 3)]);
    assert_eq!(whole, from);
}

#[test]
fn a_range_is_reordered_and_shortened_by_itself() {
    let mut some = points(6);
    some.reorder_range(2..5, &[2, 0], &mut ScratchBuffers::default());
    assert_eq!(some.id, [0, 1, 4, 2, 5]);
    assert_eq!(some.turn[2..], [Turn(0.4), Turn(0.2), Turn(0.5)]);
    let mut two = points(2);
    some.append(&mut two);
    some.truncate(6);
    assert_eq!((some.id.as_slice(), two.len()), ([0, 1, 4, 2, 5, 0].as_slice(), 0));
    assert_eq!(some.bytes(), 6 * (4 + 16 + 1 + 8));
}

#[test]
fn bytes_of_other_columns_and_counts_without_bytes_are_refused() {
    struct_of_arrays! {
        /// Other points.
        struct Others {
            /// Ids.
            id: u32,
        }
    }
    let mut bytes = Vec::new();
    points(2).write(&mut bytes).unwrap();
    let error = Others::default().read(&mut bytes.as_slice()).unwrap_err();
    assert!(error.to_string().contains("not the columns of Others"), "{error}");
    // A number of entries beyond all memory, without bytes after it.
    let error = read_column::<f64, f64>(&mut Vec::new(), |v| v, &mut [0xff; 8].as_slice()).unwrap_err();
    assert_eq!(error.kind(), io::ErrorKind::UnexpectedEof);
    let mut torn = points(2);
    torn.held.pop();
    assert_eq!(torn.uneven(), Some("held"));
    let mut bytes = Vec::new();
    torn.write(&mut bytes).unwrap();
    assert!(points(0).read(&mut bytes.as_slice()).unwrap_err().to_string().contains("held"));
}
