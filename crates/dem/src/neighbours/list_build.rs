//! Rebuild of the Verlet lists: criterion and steps.

use colluvium_case::SolverError;

use crate::boundary::periodic_cell::{apply, inverse, product};
use crate::force_loop::ContactInput;
use crate::neighbours::{ListError, ListReach};
use crate::points::vector::difference;
use crate::solver::DemSolver;

impl<const D: usize, const R: usize> DemSolver<D, R> {
    /// Gap up to which pairs are listed (m).
    pub(crate) fn gap(&self) -> f64 {
        self.skin + self.laws.rupture_distance
    }

    /// Whether a pair that is not listed may have come near (sheet: dem §3.2).
    pub(crate) fn is_stale(&self) -> bool {
        !self.since_list_build.cell.is_some_and(|then| self.max_approach(&then) <= self.skin)
    }

    /// Bound on the approach of two neighbouring grains since the list build (m), with the cell matrix `then` of that time.
    fn max_approach(&self, then: &[[f64; D]; D]) -> f64 {
        let mut strain = 0.0;
        if self.cell.is_periodic() && *then != self.cell.h {
            let map = product(&self.cell.h, &inverse(then).0);
            for (i, row) in map.iter().enumerate() {
                for (j, value) in row.iter().enumerate() {
                    strain += (value - f64::from(u8::from(i == j))).powi(2);
                }
            }
        }
        let reach = 2.0 * self.radii.1 + self.gap();
        2.0 * self.since_list_build.grain_travel + strain.sqrt() * reach + self.since_list_build.wall_travel
    }

    /// Selects the active pairs of the step.
    pub(crate) fn select_active_pairs(&mut self) {
        let closer = self.since_list_build.cell.map_or(f64::INFINITY, |then| self.max_approach(&then));
        // In a cell that has deformed since, the image shifts differ from those at the list build.
        let shifts =
            (self.since_list_build.cell == Some(self.cell.h)).then_some(self.scratch.shifts.as_slice());
        self.lists.select_active(&self.grains, shifts, closer, self.skin);
    }

    /// Sorts the grains, and builds the pair lists and the list of grains near walls.
    pub(crate) fn build_lists(&mut self) -> Result<(), SolverError> {
        self.cell.reduce();
        self.wrap()?;
        self.radii = self.grains.radii();
        let reach = ListReach { gap: self.gap(), radius: self.radii.1 };
        self.wall_list.store_histories(&self.grains.id, self.columns);
        self.membranes.clear();
        let built = self.lists.build(&mut self.grains, &self.cell, reach, self.columns);
        built.map_err(|error| self.list_error(&error))?;
        let scene = ContactInput::new(self.grains.view(), &self.laws.pairs, self.kinds.len());
        let (gap, slabs) = (self.gap(), &self.lists.slabs);
        self.wall_list.build(&scene, &self.grains.id, &self.walls, gap, slabs, self.columns);
        self.find_facets();
        self.find_membranes();
        self.since_list_build =
            crate::solver::SinceListBuild { cell: Some(self.cell.h), grain_travel: 0.0, wall_travel: 0.0 };
        Ok(())
    }

    /// Finds the obstacle facets in contact with grains at their present positions.
    pub(crate) fn find_facets(&mut self) {
        if !self.wall_list.key.is_empty() {
            let (grains, bridge) = (&self.grains, self.laws.rupture_distance);
            let found = &mut self.scratch.facets;
            self.wall_list.find_facets(&self.walls, &grains.position, &grains.radius, bridge, found);
        }
    }

    /// Wraps grains into a periodic cell; fails for grains that have left the domain along other axes.
    fn wrap(&mut self) -> Result<(), SolverError> {
        let (unit, _) = inverse(&self.cell.h);
        let cell = self.cell;
        for i in 0..self.grains.len() {
            let s = cell.reduced(&unit, &self.grains.position[i]);
            let mut steps = [0; D];
            for axis in 0..D {
                let place = s[axis].floor();
                if place == 0.0 {
                    continue;
                }
                if !cell.periodic[axis] {
                    if !self.grains.held[i] && !(-1e-9..=1.0 + 1e-9).contains(&s[axis]) {
                        let reason = "has left the domain: make it larger, or put a wall there".to_owned();
                        return Err(self.grain_error(i, reason));
                    }
                    continue;
                }
                steps[axis] = place as i32;
            }
            if steps == [0; D] {
                continue;
            }
            let shift = cell.shift(&steps);
            let jump = apply(&cell.velocity_gradient, &shift);
            let g = &mut self.grains;
            let before = crate::points::vector::dot(&g.velocity[i], &g.velocity[i]);
            g.position[i] = difference(&g.position[i], &shift);
            g.origin[i] = difference(&g.origin[i], &shift);
            g.velocity[i] = difference(&g.velocity[i], &jump);
            if !g.held[i] {
                let after = crate::points::vector::dot(&g.velocity[i], &g.velocity[i]);
                self.energy_balance.boundary += 0.5 * g.mass[i] * (after - before);
            }
        }
        Ok(())
    }

    fn list_error(&self, error: &ListError) -> SolverError {
        let reason = match error {
            ListError::Search(error) => error.to_string(),
            ListError::Narrow(axis, width, reach) => format!(
                "the periodic cell is {width:.4e} m wide along axis {axis}, less than twice {reach:.4e} m, the reach of a \
                 grain: two grains would meet twice"
            ),
            ListError::Stretched(grain) => {
                format!(
                    "a bond of grain {grain} is longer than the skin: give it a tensile_strength that it can reach"
                )
            }
        };
        SolverError::Step { step: self.step, time: self.time, reason }
    }
}

impl<const D: usize, const R: usize> DemSolver<D, R> {
    /// Sets the tangential springs of all contacts to zero.
    pub(crate) fn reset_contacts(&mut self) {
        for memory in [
            &mut self.lists.slab_pairs.histories,
            &mut self.lists.periodic_pairs.histories,
            &mut self.wall_list.memory,
        ] {
            memory.spring.iter_mut().for_each(|spring| spring[..R].fill(0.0));
            memory.roll.fill([0.0; R]);
            memory.twist.fill(0.0);
        }
    }

    /// Keeps the grains that `keep` selects; contacts of the others are removed.
    pub(crate) fn retain_grains(&mut self, keep: impl Fn(u32, &[f64; D]) -> bool) {
        let kept: Vec<bool> = {
            let g = &self.grains;
            g.body.iter().zip(&g.position).map(|(body, x)| keep(*body, x)).collect()
        };
        let mut place = vec![u32::MAX; kept.len()];
        for (next, (old, _)) in (0u32..).zip(kept.iter().enumerate().filter(|(_, kept)| **kept)) {
            place[old] = next;
        }
        self.lists.remove_grains(&place, self.columns);
        let walls: Vec<u32> = (0..self.walls.len() as u32).collect();
        self.wall_list.remove(&place, &walls, self.columns);
        self.grains.retain(|i| kept[i]);
        self.membranes.clear();
        self.since_list_build.cell = None;
    }
}
