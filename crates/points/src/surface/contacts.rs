//! The places at which balls touch a surface.

use super::simplex::nearest;
use super::vector::{dot, minus};
use super::{Nearest, Surface};

/// Share of a ball's radius within which two places of a surface are the same: far above round-off, far below a facet.
const SAME: f64 = 1e-7;

/// Places at which balls touch a surface, ball after ball. Kept by who asks, so that asking again allocates nothing.
#[derive(Clone, Debug, Default)]
pub struct Contacts<const D: usize> {
    found: Vec<Nearest<D>>,
    ends: Vec<usize>,
    candidates: Vec<Candidate<D>>,
    /// Those of a section, of surfaces that a section makes.
    flat: Option<Box<Contacts<2>>>,
}

/// A facet near a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate<const D: usize> {
    pub(super) corners: [[f64; D]; D],
    pub(super) place: Nearest<D>,
}

impl<const D: usize> Contacts<D> {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.found.clear();
        self.ends.clear();
    }

    /// All places, ball after ball, of each the nearest first.
    pub fn all(&self) -> &[Nearest<D>] {
        &self.found
    }

    /// Number of places of all balls.
    pub fn len(&self) -> usize {
        self.found.len()
    }

    /// Whether nothing is touched.
    pub fn is_empty(&self) -> bool {
        self.found.is_empty()
    }

    /// The places of ball number `ball` of [`Surface::touch_all`](super::Surface::touch_all).
    pub fn of(&self, ball: usize) -> &[Nearest<D>] {
        let start = if ball == 0 { 0 } else { self.ends[ball - 1] };
        &self.found[start..self.ends[ball]]
    }

    /// Ends the list of a ball.
    pub fn next(&mut self) {
        self.ends.push(self.found.len());
    }

    pub(super) fn since(&mut self, start: usize) -> &mut [Nearest<D>] {
        &mut self.found[start..]
    }

    pub(super) fn add_if_outside(&mut self, place: Option<Nearest<D>>) {
        self.found.extend(place.filter(|place| place.distance >= 0.0));
    }

    /// Adds what a disk around `x` touches of a section in the plane, brought into space by `out`.
    pub(super) fn touch_flat(
        &mut self,
        section: &impl Surface<2>,
        x: &[f64; 2],
        radius: f64,
        out: impl Fn(&Nearest<2>) -> Nearest<D>,
    ) {
        let flat = self.flat.get_or_insert_default();
        flat.clear();
        section.touch(x, radius, flat);
        self.found.extend(flat.found.iter().map(out));
    }

    /// Facets near the point that [`Contacts::resolve`] is to choose from.
    pub(super) fn candidates(&mut self) -> &mut Vec<Candidate<D>> {
        &mut self.candidates
    }

    /// Of the candidates those that are contacts of their own. One whose place also belongs to a facet that is nearer is the
    /// edge at which that facet ends, or lies beyond it on the same side.
    pub(super) fn resolve(&mut self, radius: f64) {
        let key = |c: &Candidate<D>| (c.place.distance, c.place.key);
        self.candidates.sort_unstable_by(|a, b| {
            let (a, b) = (key(a), key(b));
            a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
        });
        let same = (SAME * radius).powi(2);
        for (number, candidate) in self.candidates.iter().enumerate() {
            let place = &candidate.place.place;
            let ends = |nearer: &Candidate<D>| {
                let from = minus(place, &nearest(&nearer.corners, place).0);
                dot(&from, &from) <= same
            };
            if !self.candidates[..number].iter().any(ends) {
                self.found.push(candidate.place);
            }
        }
        self.candidates.clear();
    }
}
