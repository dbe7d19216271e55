//! What is compiled once: loops over items in parallel ([`InPieces`]), and functions of the number of dimensions ([`once_per_dimension`]).
//!
//! Of each loop that rayon is given the compiler makes a dozen functions: jobs of each half, the join of them, and each again for a
//! caller from outside the pool, with the body of the loop in several. Here the items are cut into pieces first, and what shares the
//! pieces out among the threads does not know what they are.
//!
//! ```
//! use colluvium_parallel::{InPieces, fill};
//! use rayon::prelude::*;
//!
//! let (velocity, mut position) = (vec![1.0, 2.0, 3.0], vec![0.0; 3]);
//! position.par_iter_mut().zip(&velocity).in_pieces(512, |(x, v)| *x += 0.5 * v);
//! assert_eq!(position, [0.5, 1.0, 1.5]);
//!
//! let mut squares = Vec::new();
//! fill(&mut squares, position.len(), 512, |i| position[i] * position[i]);
//! assert_eq!(squares, [0.25, 1.0, 2.25]);
//! ```

mod once;

use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::iter::plumbing::{Producer, ProducerCallback};
use rayon::prelude::*;

pub use once::same;

/// At most so many pieces: enough for the threads to share when they are not equally fast.
const PIECES: usize = 64;

/// Items that can be worked on in parallel, piece by piece; a piece has at least `least` of them.
pub trait InPieces: IndexedParallelIterator {
    /// Hands each item to `work`.
    fn in_pieces(self, least: usize, work: impl Fn(Self::Item) + Sync) {
        cut(self, least, &Each(work));
    }

    /// Hands each item to `work`, with what `room` made for its piece.
    fn in_pieces_with<R>(
        self,
        least: usize,
        room: impl Fn() -> R + Sync,
        work: impl Fn(&mut R, Self::Item) + Sync,
    ) {
        cut(self, least, &With(room, work));
    }

    /// What `join` makes of the values of all items in their order, from `none` on. To it `none` adds nothing, however often, and its
    /// order of brackets is of no account to the last bit (a least one, a first one, a sum of integers): the pieces follow from the
    /// number of threads.
    fn joined<T: Clone + Send + Sync>(
        self,
        least: usize,
        none: T,
        join: impl Fn(T, T) -> T + Sync,
        value: impl Fn(Self::Item) -> T + Sync,
    ) -> T {
        let found = [const { Mutex::new(None) }; PIECES];
        cut(self, least, &Joined { none: none.clone(), value, join: &join, found: &found });
        let of_pieces =
            found.into_iter().filter_map(|piece| piece.into_inner().unwrap_or_else(PoisonError::into_inner));
        of_pieces.fold(none, join)
    }
}

impl<I: IndexedParallelIterator> InPieces for I {}

/// Puts what `value` says of each number below `len` into `values`; a piece has at least `least` of them.
pub fn fill<T: Clone + Send>(
    values: &mut Vec<T>,
    len: usize,
    least: usize,
    value: impl Fn(usize) -> T + Sync,
) {
    if len == 0 {
        return values.clear();
    }
    // What is there already is only written over.
    if values.len() != len {
        values.resize(len, value(0));
    }
    values.par_iter_mut().enumerate().in_pieces(least, |(i, slot)| *slot = value(i));
}

/// What `value` says of each number below `len`, as [`fill`] finds it.
pub fn filled<T: Clone + Send>(len: usize, least: usize, value: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let mut values = Vec::new();
    fill(&mut values, len, least, value);
    values
}

/// What is to be done with a piece.
trait Work<T>: Sync {
    fn piece(&self, number: usize, items: impl Iterator<Item = T>);
}

struct Each<F>(F);

impl<T, F: Fn(T) + Sync> Work<T> for Each<F> {
    fn piece(&self, _: usize, items: impl Iterator<Item = T>) {
        items.for_each(&self.0);
    }
}

struct With<R, F>(R, F);

impl<T, O, R: Fn() -> O + Sync, F: Fn(&mut O, T) + Sync> Work<T> for With<R, F> {
    fn piece(&self, _: usize, items: impl Iterator<Item = T>) {
        let mut room = self.0();
        items.for_each(|item| self.1(&mut room, item));
    }
}

struct Joined<'a, T, V, J> {
    none: T,
    value: V,
    join: &'a J,
    found: &'a [Mutex<Option<T>>],
}

impl<I, T: Clone + Send + Sync, V: Fn(I) -> T + Sync, J: Fn(T, T) -> T + Sync> Work<I>
    for Joined<'_, T, V, J>
{
    fn piece(&self, number: usize, items: impl Iterator<Item = I>) {
        let of_piece = items.fold(self.none.clone(), |sum, item| (self.join)(sum, (self.value)(item)));
        *hold(&self.found[number]) = Some(of_piece);
    }
}

fn cut<I: IndexedParallelIterator>(items: I, least: usize, work: &impl Work<I::Item>) {
    let len = items.len();
    items.with_producer(Cut { len, most: len / least.max(1), work });
}

/// Cuts what it is given into at most `most` pieces.
struct Cut<'a, W> {
    len: usize,
    most: usize,
    work: &'a W,
}

impl<T, W: Work<T>> ProducerCallback<T> for Cut<'_, W> {
    type Output = ();

    fn callback<P: Producer<Item = T>>(self, producer: P) {
        let pieces = if rayon::current_num_threads() == 1 { 1 } else { self.most.clamp(1, PIECES) };
        if pieces == 1 {
            return work_on(&[Mutex::new(Some(producer))], self.work);
        }
        let all: [Mutex<Option<P>>; PIECES] = [const { Mutex::new(None) }; PIECES];
        let ends = |piece: usize| self.len * piece / pieces;
        let mut rest = producer;
        for (number, piece) in all[..pieces - 1].iter().enumerate() {
            let (first, others) = rest.split_at(ends(number + 1) - ends(number));
            *hold(piece) = Some(first);
            rest = others;
        }
        *hold(&all[pieces - 1]) = Some(rest);
        work_on(&all[..pieces], self.work);
    }
}

/// A lock that nobody else holds: each piece is put down once and taken once.
fn hold<P>(piece: &Mutex<P>) -> MutexGuard<'_, P> {
    piece.lock().unwrap_or_else(PoisonError::into_inner)
}

#[inline(never)]
fn work_on<P: Producer>(pieces: &[Mutex<Option<P>>], work: &impl Work<P::Item>) {
    share_out(pieces.len(), &|number| {
        let piece = hold(&pieces[number]).take();
        if let Some(piece) = piece {
            work.piece(number, piece.into_iter());
        }
    });
}

/// Calls `task` for each number below `count`, on all threads.
fn share_out(count: usize, task: &(dyn Fn(usize) + Sync)) {
    if count == 1 {
        task(0);
    } else {
        (0..count).into_par_iter().for_each(task);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pool(threads: usize) -> rayon::ThreadPool {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
    }

    #[test]
    fn each_item_is_worked_on_once_whatever_the_pieces() {
        for threads in [1, 2, 3] {
            for (len, least) in
                [(0, 1), (1, 1), (63, 1), (64, 0), (65, 1), (1000, 7), (1000, 600), (1000, 5000)]
            {
                let mut counts = vec![0; len];
                pool(threads)
                    .install(|| counts.par_iter_mut().enumerate().in_pieces(least, |(i, n)| *n += i + 1));
                assert!(
                    counts.iter().enumerate().all(|(i, n)| *n == i + 1),
                    "{threads} threads, {len} by {least}"
                );
                let first = |a: Option<usize>, b: Option<usize>| a.or(b);
                let numbers = (0..len).into_par_iter();
                let third = pool(threads)
                    .install(|| numbers.joined(least, None, first, |i| (i % 5 == 2).then_some(i)));
                assert_eq!(third, (len > 2).then_some(2), "{threads} threads, {len} by {least}");
                let found = pool(threads).install(|| filled(len, least, |i| 3 * i));
                assert_eq!(
                    found,
                    (0..len).map(|i| 3 * i).collect::<Vec<_>>(),
                    "{threads} threads, {len} by {least}"
                );
            }
        }
    }

    #[test]
    fn a_room_is_of_one_piece() {
        let mut counts = [0; 200];
        let count = |seen: &mut usize, slot: &mut usize| {
            *seen += 1;
            *slot = *seen;
        };
        pool(2).install(|| counts.par_iter_mut().in_pieces_with(50, || 0, count));
        assert_eq!(counts.iter().filter(|n| **n == 1).count(), 4);
        assert_eq!(counts.iter().max(), Some(&50));
    }

    #[test]
    fn pieces_have_their_least_length_and_are_worked_on_beside_one_another() {
        let workers = Mutex::new(Vec::new());
        let barrier = std::sync::Barrier::new(2);
        let mut items = [0_u8; 20];
        pool(2).install(|| {
            items.par_iter_mut().enumerate().in_pieces(10, |(i, _)| {
                if i % 10 == 0 {
                    barrier.wait();
                }
                workers.lock().unwrap().push((i / 10, std::thread::current().id()));
            });
        });
        let workers = workers.into_inner().unwrap();
        let of = |half| {
            let mut ids: Vec<_> = workers.iter().filter(|(of, _)| *of == half).map(|(_, id)| *id).collect();
            ids.dedup();
            ids
        };
        assert_eq!((of(0).len(), of(1).len()), (1, 1));
        assert_ne!(of(0), of(1));
    }

    #[test]
    #[should_panic(expected = "seven")]
    fn a_panic_goes_to_the_caller() {
        pool(2).install(|| (0..100).into_par_iter().in_pieces(1, |i| assert!(i != 7, "seven")));
    }
}
