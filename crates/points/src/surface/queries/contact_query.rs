//! Contacts of balls with a surface.

use crate::surface::queries::nearest_on_facet::nearest_on_facet;
use crate::surface::vector::{difference, dot};
use crate::surface::{NearestPoint, Surface};

/// Distance within which two surface points coincide, over the radius of the ball. It is far above round-off and far below the size of a
/// facet.
const COINCIDENCE_TOLERANCE: f64 = 1e-7;

/// Contacts of several balls with a surface. The caller reuses its buffers, so that no memory is allocated.
#[derive(Clone, Debug, Default)]
pub struct ContactQuery<const D: usize> {
    contacts: Vec<NearestPoint<D>>,
    row_ends: Vec<usize>,
    candidates: Vec<FacetCandidate<D>>,
    /// Contacts of a plane section, for surfaces that a section generates.
    planar: Option<Box<ContactQuery<2>>>,
}

/// Facet near a ball, with its nearest point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FacetCandidate<const D: usize> {
    /// Vertices of the facet (m).
    pub(crate) corners: [[f64; D]; D],
    /// Its point nearest to the centre of the ball.
    pub(crate) nearest: NearestPoint<D>,
}

impl<const D: usize> ContactQuery<D> {
    /// Removes all contacts.
    pub fn clear(&mut self) {
        self.contacts.clear();
        self.row_ends.clear();
    }

    /// Contacts of all balls in the order of the balls; those of a ball are sorted by distance.
    pub fn contacts(&self) -> &[NearestPoint<D>] {
        &self.contacts
    }

    /// Number of contacts of all balls.
    pub fn len(&self) -> usize {
        self.contacts.len()
    }

    /// Whether there are no contacts.
    pub fn is_empty(&self) -> bool {
        self.contacts.is_empty()
    }

    /// Contacts of ball number `ball` of [`Surface::query_contacts_of_all`](crate::surface::Surface::query_contacts_of_all).
    pub fn contacts_of_ball(&self, ball: usize) -> &[NearestPoint<D>] {
        let start = if ball == 0 { 0 } else { self.row_ends[ball - 1] };
        &self.contacts[start..self.row_ends[ball]]
    }

    /// Ends the list of the contacts of a ball.
    pub fn end_ball(&mut self) {
        self.row_ends.push(self.contacts.len());
    }

    /// Contacts found since the number of contacts was `start`.
    pub(crate) fn contacts_since_mut(&mut self, start: usize) -> &mut [NearestPoint<D>] {
        &mut self.contacts[start..]
    }

    /// Adds a contact where the centre of the ball is outside the surface.
    pub(crate) fn add_if_outside(&mut self, place: Option<NearestPoint<D>>) {
        self.contacts.extend(place.filter(|place| place.distance >= 0.0));
    }

    /// Adds the contacts of a disk around `x` with a plane section. `out` transforms them to space.
    pub(crate) fn add_planar_contacts(
        &mut self,
        section: &impl Surface<2>,
        x: &[f64; 2],
        radius: f64,
        out: impl Fn(&NearestPoint<2>) -> NearestPoint<D>,
    ) {
        let flat = self.planar.get_or_insert_default();
        flat.clear();
        section.query_contacts(x, radius, flat);
        self.contacts.extend(flat.contacts.iter().map(out));
    }

    /// Candidate facets near the point, the input of [`ContactQuery::select_distinct`].
    pub(crate) fn candidates(&mut self) -> &mut Vec<FacetCandidate<D>> {
        &mut self.candidates
    }

    /// Selects the distinct contacts of a ball among the candidate facets. A candidate whose position also belongs to a nearer facet is
    /// left out: it is the edge at which that facet ends, or lies beyond it on the same side.
    pub(crate) fn select_distinct(&mut self, radius: f64) {
        let key = |c: &FacetCandidate<D>| (c.nearest.distance, c.nearest.feature_id);
        self.candidates.sort_unstable_by(|a, b| {
            let (a, b) = (key(a), key(b));
            a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
        });
        let same = (COINCIDENCE_TOLERANCE * radius).powi(2);
        for (number, candidate) in self.candidates.iter().enumerate() {
            let place = &candidate.nearest.position;
            let ends = |nearer: &FacetCandidate<D>| {
                let from = difference(place, &nearest_on_facet(&nearer.corners, place).0);
                dot(&from, &from) <= same
            };
            if !self.candidates[..number].iter().any(ends) {
                self.contacts.push(candidate.nearest);
            }
        }
        self.candidates.clear();
    }
}
