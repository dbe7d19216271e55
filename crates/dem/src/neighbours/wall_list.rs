//! List of the grains near walls, with the histories of their contacts.

use crate::boundary::walls::RigidWall;
use crate::contact::contact_histories::{ContactHistories, HistoryColumns};
use crate::obstacles::facet::{FacetContact, MAX_FACETS, NO_FACET};
use crate::points::grains::GrainView;

/// List of grains near walls.
#[derive(Clone, Debug, Default)]
pub struct WallList<const R: usize> {
    /// Grain of each entry, ascending.
    pub grain: Vec<u32>,
    /// Index of the wall of each entry.
    pub wall: Vec<u32>,
    /// First entry of each slab, and the number of entries.
    pub slabs: Vec<u32>,
    /// Contact histories.
    pub history: ContactHistories<R>,
    /// Facet key of each entry at an obstacle, where a grain can have several consecutive entries; empty without obstacles.
    pub facet_key: Vec<u64>,
    /// Distance and normal of the facet of each entry at an obstacle.
    pub facet: Vec<FacetContact>,
    stored_contacts: Vec<(u32, u32, u64)>,
    /// Normals of the contacts whose histories are stored.
    normals: Vec<FacetContact>,
    stored_histories: ContactHistories<R>,
}

impl<const R: usize> WallList<R> {
    /// Stores the contact histories by grain ids, before the grains are sorted.
    pub fn store_histories(&mut self, ids: &[u32], columns: HistoryColumns) {
        self.stored_contacts.clear();
        self.normals.clear();
        self.stored_histories.clear(0, columns);
        for k in 0..self.grain.len() {
            if self.history.is_kept(k) {
                let key = self.facet_key.get(k).copied().unwrap_or(NO_FACET);
                self.stored_contacts.push((ids[self.grain[k] as usize], self.wall[k], key));
                self.normals.extend(self.facet.get(k));
                self.stored_histories.push(&self.history, k);
            }
        }
    }

    /// Removes the entries of removed grains and walls, whose new index is `u32::MAX`. The list must then be rebuilt.
    pub fn remove(&mut self, grains: &[u32], walls: &[u32], columns: HistoryColumns) {
        let mut left = Self::default();
        left.history.clear(0, columns);
        for k in 0..self.grain.len() {
            let (grain, wall) = (grains[self.grain[k] as usize], walls[self.wall[k] as usize]);
            if grain != u32::MAX && wall != u32::MAX {
                left.grain.push(grain);
                left.wall.push(wall);
                left.facet_key.extend(self.facet_key.get(k));
                left.facet.extend(self.facet.get(k));
                left.history.push(&self.history, k);
            }
        }
        *self = left;
    }

    /// Builds the list of grains within `gap` (m) of walls, slab by slab.
    pub fn build<const D: usize>(
        &mut self,
        grains: GrainView<'_, D, R>,
        ids: &[u32],
        walls: &[RigidWall<D>],
        gap: f64,
        slabs: &[u32],
        columns: HistoryColumns,
    ) {
        self.grain.clear();
        self.wall.clear();
        self.slabs.clear();
        for ends in slabs.windows(2) {
            self.slabs.push(self.grain.len() as u32);
            for i in ends[0] as usize..ends[1] as usize {
                for (number, wall) in walls.iter().enumerate() {
                    if grains.is_held[i] || !wall.is_near(&grains.position[i], grains.radius[i] + gap) {
                        continue;
                    }
                    for _ in 0..if wall.surface.is_some() { MAX_FACETS } else { 1 } {
                        self.grain.push(i as u32);
                        self.wall.push(number as u32);
                    }
                }
            }
        }
        self.slabs.push(self.grain.len() as u32);
        self.history.clear(self.grain.len(), columns);
        let facetted = walls.iter().any(|wall| wall.surface.is_some());
        let entries = if facetted { self.grain.len() } else { 0 };
        self.facet_key.clear();
        self.facet_key.resize(entries, NO_FACET);
        self.facet.clear();
        self.facet.resize(entries, FacetContact::OUT_OF_REACH);
        if self.stored_contacts.is_empty() {
            return;
        }
        let mut order: Vec<usize> = (0..self.stored_contacts.len()).collect();
        order.sort_unstable_by_key(|&entry| self.stored_contacts[entry]);
        let mut slot = 0;
        for k in 0..self.grain.len() {
            let (id, wall) = (ids[self.grain[k] as usize], self.wall[k]);
            // The slots of a grain at an obstacle receive its stored contacts one after another.
            let again = k > 0 && self.grain[k - 1] == self.grain[k] && self.wall[k - 1] == wall;
            slot = if again { slot + 1 } else { 0 };
            let first = order.partition_point(|&entry| {
                (self.stored_contacts[entry].0, self.stored_contacts[entry].1) < (id, wall)
            });
            let Some(&entry) = order.get(first + slot) else { continue };
            if (self.stored_contacts[entry].0, self.stored_contacts[entry].1) == (id, wall) {
                self.history.copy_from(k, &self.stored_histories, entry, false);
                if let (Some(key), Some(facet)) = (self.facet_key.get_mut(k), self.facet.get_mut(k)) {
                    *key = self.stored_contacts[entry].2;
                    self.normals.get(entry).inspect(|known| *facet = **known);
                }
            }
        }
    }
}

/// View of a wall list, without the contact histories.
#[derive(Clone, Copy)]
pub struct WallListView<'a> {
    /// Grain of each entry, ascending.
    pub grain: &'a [u32],
    /// Index of the wall of each entry.
    pub wall: &'a [u32],
    /// First entry of each slab, and the number of entries.
    pub slabs: &'a [u32],
    /// Distances and normals of the facets of entries at obstacles.
    pub facet: &'a [FacetContact],
}
