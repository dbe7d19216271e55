//! Grains near obstacles: which facets they touch, with a contact for each (sheet: dem §2.10).

use colluvium_points::surface::{Contacts, Nearest};

use crate::contact::APART;
use crate::surfaces::{FREE, Facet, SLOTS};
use crate::walls::{Wall, WallList};

/// Cosine of the angle between normals up to which a contact goes on as it changes from facet to facet.
const SAME: f64 = 0.999;

impl<const R: usize> WallList<R> {
    /// Finds the facets that grains with radii and `bridge` (m) around their places touch. A contact stays with its facet; one
    /// whose facet is no longer touched goes on with a new one of nearly the same normal, and ends otherwise.
    pub fn place<const D: usize>(
        &mut self,
        walls: &[Wall<D>],
        position: &[[f64; D]],
        radius: &[f64],
        bridge: f64,
        found: &mut Contacts<D>,
    ) {
        let mut k = 0;
        while k < self.key.len() {
            let (i, wall) = (self.grain[k] as usize, &walls[self.wall[k] as usize]);
            let Some(surface) = wall.now() else {
                k += 1;
                continue;
            };
            found.clear();
            let reach = radius[i] + bridge;
            surface.touch(&position[i], reach, found);
            self.match_up(k, found.all(), reach);
            k += SLOTS;
        }
    }

    /// Gives the slots from `first` on the places that are touched.
    fn match_up<const D: usize>(&mut self, first: usize, places: &[Nearest<D>], reach: f64) {
        let slots = first..first + SLOTS;
        let mut taken = [false; SLOTS];
        let mut left = [None; SLOTS];
        for (number, place) in places.iter().take(SLOTS).enumerate() {
            match slots.clone().find(|&k| self.key[k] == place.key) {
                Some(k) => {
                    self.facet[k] = Facet::of(place);
                    taken[k - first] = true;
                }
                None => left[number] = Some(place),
            }
        }
        for place in left.into_iter().flatten() {
            let facet = Facet::of(place);
            let along = |k: usize| (0..3).map(|c| self.facet[k].normal[c] * facet.normal[c]).sum::<f64>();
            let open = |k: &usize| !taken[*k - first];
            let goes_on =
                slots.clone().filter(open).find(|&k| self.memory.state[k] != APART && along(k) > SAME);
            let new = || slots.clone().filter(open).find(|&k| self.memory.state[k] == APART);
            if let Some(k) = goes_on.or_else(new) {
                (self.key[k], self.facet[k]) = (place.key, facet);
                taken[k - first] = true;
            }
        }
        for k in slots.filter(|k| !taken[*k - first]) {
            // Out of touch: a contact that is left ends, with the normal it had.
            self.facet[k].distance = reach;
            if self.memory.state[k] == APART {
                self.key[k] = FREE;
            }
        }
    }
}
