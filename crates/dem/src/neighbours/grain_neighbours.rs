//! Neighbours of the grains: pair lists, grains near walls, and the displacements since their build.

use colluvium_points::surface::ContactQuery;

use crate::boundary::controlled_cell::ControlledCell;
use crate::boundary::periodic_cell::{inverse, product};
use crate::boundary::walls::RigidWall;
use crate::contact::contact_laws::ContactLaws;
use crate::neighbours::VerletLists;
use crate::neighbours::wall_list::WallList;
use crate::points::grain_extremes::GrainExtremes;
use crate::points::grains::Grains;

/// Lists of grain pairs and of grains near walls, with contact histories.
#[derive(Default)]
pub struct GrainNeighbours<const D: usize, const R: usize> {
    /// Pairs of grains.
    pub pairs: VerletLists<D, R>,
    /// Grains near walls.
    pub walls: WallList<R>,
    /// Changes since the last list build.
    pub since_build: SinceListBuild<D>,
    /// Thickness of the Verlet skin (m).
    pub skin: f64,
    /// Facets in contact with a grain.
    pub facets: ContactQuery<D>,
}

/// Changes since the last list build.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SinceListBuild<const D: usize> {
    /// Cell vectors at the list build (m).
    pub cell: Option<[[f64; D]; D]>,
    /// Largest displacement of a grain (m).
    pub grain_travel: f64,
    /// Displacement of the fastest wall, plus growth of the largest radius (m).
    pub wall_travel: f64,
}

impl<const D: usize, const R: usize> GrainNeighbours<D, R> {
    /// Gap up to which pairs are listed (m).
    pub fn gap(&self, laws: &ContactLaws) -> f64 {
        self.skin + laws.stage.rupture_distance
    }

    /// Whether grains may have moved so far that an unlisted pair is in contact (sheet: dem §3.2).
    pub fn is_stale(&self, laws: &ContactLaws, cell: &ControlledCell<D>, extremes: &GrainExtremes) -> bool {
        let approach = |then| self.max_approach(laws, cell, extremes, &then);
        !self.since_build.cell.is_some_and(|then| approach(then) <= self.skin)
    }

    /// Upper bound of the approach of two grains since the list build (m); `then` is the cell matrix at that time.
    fn max_approach(
        &self,
        laws: &ContactLaws,
        cell: &ControlledCell<D>,
        extremes: &GrainExtremes,
        then: &[[f64; D]; D],
    ) -> f64 {
        let mut strain = 0.0;
        if cell.geometry.is_periodic() && *then != cell.geometry.h {
            let map = product(&cell.geometry.h, &inverse(then).0);
            for (i, row) in map.iter().enumerate() {
                for (j, value) in row.iter().enumerate() {
                    strain += (value - f64::from(u8::from(i == j))).powi(2);
                }
            }
        }
        let reach = 2.0 * extremes.radii.1 + self.gap(laws);
        2.0 * self.since_build.grain_travel + strain.sqrt() * reach + self.since_build.wall_travel
    }

    /// Selects the active pairs of the step, with the shifts of the images.
    pub fn select_active_pairs(
        &mut self,
        laws: &ContactLaws,
        cell: &ControlledCell<D>,
        grains: &Grains<D, R>,
        extremes: &GrainExtremes,
        shifts: &[([f64; D], [f64; D])],
    ) {
        let approach = |then| self.max_approach(laws, cell, extremes, &then);
        let closer = self.since_build.cell.map_or(f64::INFINITY, approach);
        // In a cell that has deformed since, the image shifts differ from those at the list build.
        let shifts = (self.since_build.cell == Some(cell.geometry.h)).then_some(shifts);
        self.pairs.select_active(grains, shifts, closer, self.skin);
    }

    /// Finds the obstacle facets in contact with grains at their present positions.
    pub fn find_facets(&mut self, laws: &ContactLaws, grains: &Grains<D, R>, walls: &[RigidWall<D>]) {
        if !self.walls.facet_key.is_empty() {
            let rupture = laws.stage.rupture_distance;
            self.walls.find_facets(walls, &grains.position, &grains.radius, rupture, &mut self.facets);
        }
    }

    /// Sets the tangential springs of all contacts to zero.
    pub fn reset_contacts(&mut self) {
        for history in [
            &mut self.pairs.slab_pairs.histories,
            &mut self.pairs.periodic_pairs.histories,
            &mut self.walls.history,
        ] {
            history.spring.iter_mut().for_each(|spring| spring[..R].fill(0.0));
            history.roll.fill([0.0; R]);
            history.twist.fill(0.0);
        }
    }

    /// Removes the grains for whose index the condition is false, with their contacts. The lists must be rebuilt afterwards.
    pub fn retain_grains(
        &mut self,
        laws: &ContactLaws,
        grains: &mut Grains<D, R>,
        walls: usize,
        keep: impl Fn(&Grains<D, R>, usize) -> bool,
    ) {
        let kept: Vec<bool> = (0..grains.len()).map(|i| keep(grains, i)).collect();
        let mut index = vec![u32::MAX; kept.len()];
        for (next, (old, _)) in (0u32..).zip(kept.iter().enumerate().filter(|(_, kept)| **kept)) {
            index[old] = next;
        }
        self.pairs.remove_grains(&index, laws.columns);
        let walls: Vec<u32> = (0..walls as u32).collect();
        self.walls.remove(&index, &walls, laws.columns);
        grains.retain(|i| kept[i]);
        self.since_build.cell = None;
    }
}
