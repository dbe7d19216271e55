//! Facets of obstacles in contact with grains, one contact for each (sheet: dem §2.10).

use colluvium_points::surface::{ContactQuery, NearestPoint};

use crate::boundary::walls::RigidWall;
use crate::contact::ContactState;
use crate::neighbours::wall_list::WallList;
use crate::obstacles::facet::{FacetContact, MAX_FACETS, NO_FACET};

/// Smallest cosine of the angle between two facet normals for which a contact continues on the other facet.
const MIN_NORMAL_COSINE: f64 = 0.999;

impl<const R: usize> WallList<R> {
    /// Finds the facets within the radius plus `rupture` (m) of each grain. A contact stays with its facet; one
    /// whose facet is no longer near continues with a new one of nearly the same normal, and ends otherwise.
    pub fn find_facets<const D: usize>(
        &mut self,
        walls: &[RigidWall<D>],
        position: &[[f64; D]],
        radius: &[f64],
        rupture: f64,
        query: &mut ContactQuery<D>,
    ) {
        let mut k = 0;
        while k < self.facet_key.len() {
            let (i, wall) = (self.grain[k] as usize, &walls[self.wall[k] as usize]);
            let Some(surface) = wall.current_surface() else {
                k += 1;
                continue;
            };
            query.clear();
            let reach = radius[i] + rupture;
            surface.query_contacts(&position[i], reach, query);
            self.match_slots(k, query.contacts(), reach);
            k += MAX_FACETS;
        }
    }

    /// Assigns the facets close to a grain to its list entries, from index `first` on.
    fn match_slots<const D: usize>(&mut self, first: usize, points: &[NearestPoint<D>], reach: f64) {
        let slots = first..first + MAX_FACETS;
        let mut is_used = [false; MAX_FACETS];
        let mut unmatched = [None; MAX_FACETS];
        for (number, point) in points.iter().take(MAX_FACETS).enumerate() {
            match slots.clone().find(|&k| self.facet_key[k] == point.feature_id) {
                Some(k) => {
                    self.facet[k] = FacetContact::from_nearest_point(point);
                    is_used[k - first] = true;
                }
                None => unmatched[number] = Some(point),
            }
        }
        for point in unmatched.into_iter().flatten() {
            let facet = FacetContact::from_nearest_point(point);
            let along = |k: usize| (0..3).map(|c| self.facet[k].normal[c] * facet.normal[c]).sum::<f64>();
            let open = |k: &usize| !is_used[*k - first];
            let continued = slots
                .clone()
                .filter(open)
                .find(|&k| self.history.state[k] != ContactState::Apart && along(k) > MIN_NORMAL_COSINE);
            let new = || slots.clone().filter(open).find(|&k| self.history.state[k] == ContactState::Apart);
            if let Some(k) = continued.or_else(new) {
                (self.facet_key[k], self.facet[k]) = (point.feature_id, facet);
                is_used[k - first] = true;
            }
        }
        for k in slots.filter(|k| !is_used[*k - first]) {
            // Facet no longer near: the remaining contact ends, with its last normal.
            self.facet[k].distance = reach;
            if self.history.state[k] == ContactState::Apart {
                self.facet_key[k] = NO_FACET;
            }
        }
    }
}
