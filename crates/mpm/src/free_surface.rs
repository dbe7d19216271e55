//! Free surface of liquids (MPM sheet §2.18; Anura3D manual 2021, eqs. 6.38–6.40).
//!
//! Nodes get a fill ratio: the volume that the mass of the points has at rest, over the volume of the cells around that
//! hold a point. Where the ratio interpolated to a liquid point is small the point lies on the free surface: it carries
//! no stress, and has the volume that goes with that, so that it comes back into the liquid as it is at rest. Weights are those of linear shape functions, whatever the solver uses, since the ratio is one of cells.

use colluvium_case::description::{Body, Space};
use colluvium_case::{Case, CaseError};
use colluvium_grid::{Basis, Grid, Lanes, Layout, Linear, Stencil, Support};
use rayon::prelude::*;

use crate::MpmOptions;
use crate::points::{PointDomain, PointSet};
use crate::solver::MpmSolver;

/// What detection needs.
pub struct FreeSurface<const D: usize> {
    /// Fill ratio below which a point is on the surface.
    factor: f64,
    /// Nodes of the cells.
    layout: Layout<D>,
    /// `Σ N m_p/ρ_0` (m³) of the nodes; in the second lane, whether a point lies in the cell above the node.
    sums: Vec<Lanes>,
    /// Fill ratios of the nodes.
    fill: Vec<f64>,
    /// Of the bodies of the case: density at rest (kg/m³).
    densities: Vec<f64>,
    /// Of the bodies of the case: whether it is a liquid.
    liquid: Vec<bool>,
}

/// The detection of a case; `None` where it is off.
pub fn free_surface<const D: usize>(
    case: &Case,
    options: &MpmOptions,
    grid: &Grid<D>,
    own: &Layout<D>,
) -> Result<Option<Box<FreeSurface<D>>>, CaseError> {
    let Some(factor) = options.free_surface else { return Ok(None) };
    let spec = |body: &Body| &case.materials[&body.material];
    let liquid: Vec<bool> = case.bodies.iter().map(|body| spec(body).is_fluid()).collect();
    if !liquid.contains(&true) {
        return Err(CaseError::new("methods.mpm.free_surface", "needs a body of a fluid"));
    }
    if !case.domain.periodic.is_empty() {
        return Err(CaseError::new("methods.mpm.free_surface", "is not available in a periodic domain"));
    }
    if case.space == Space::Axisymmetric {
        return Err(CaseError::new("methods.mpm.free_surface", "is not available in axisymmetry"));
    }
    let layout = Layout::new::<2, Linear>(grid).with_slabs_of(own);
    Ok(Some(Box::new(FreeSurface {
        factor,
        sums: vec![Lanes::ZERO; layout.len()],
        fill: vec![0.0; layout.len()],
        layout,
        densities: case.bodies.iter().map(|body| spec(body).density()).collect(),
        liquid,
    })))
}

impl<const D: usize> FreeSurface<D> {
    /// Takes the stress off the points of a set where the fill ratio is small.
    fn relieve<P>(&self, grid: &Grid<D>, set: &mut PointSet<D, P>) {
        let strides = self.layout.strides();
        let density = self.densities[set.body as usize];
        let own = set.stress.par_iter_mut().zip(&mut set.volume);
        own.zip(&set.position).zip(&set.mass).for_each(|(((stress, volume), position), mass)| {
            let stencil = Stencil::<D, 2>::new::<Linear>(grid, position, &[0.0; D]);
            let ratio = stencil.interpolate(&self.fill, &strides, |fill| Lanes::splat(*fill));
            if ratio.as_array()[0] <= self.factor {
                stress.0 = [0.0; 6];
                *volume = mass / density;
            }
        });
    }

    /// Fill ratios from the sums.
    fn divide(&mut self, grid: &Grid<D>) {
        let Self { sums, fill, .. } = self;
        let strides = self.layout.strides();
        let share = (0.5 * grid.cell).powi(D as i32);
        fill.par_chunks_mut(strides[0]).enumerate().for_each(|(row, line)| {
            for (number, ratio) in line.iter_mut().enumerate() {
                let node = row * strides[0] + number;
                let held = sums[node].as_array()[0];
                if held == 0.0 {
                    *ratio = 0.0;
                    continue;
                }
                let around = (0..1 << D).filter(|corner| {
                    let back: usize =
                        (0..D).filter(|axis| corner >> axis & 1 == 1).map(|axis| strides[axis]).sum();
                    node >= back && sums[node - back].as_array()[1] > 0.0
                });
                *ratio = held / (share * around.count() as f64);
            }
        });
    }
}

impl<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>> MpmSolver<D, S, B, P> {
    /// Takes the stress off the liquid points on the free surface.
    pub(crate) fn free_surface(&mut self) {
        let Some(mut surface) = self.free_surface.take() else { return };
        self.fill_ratios(&mut surface);
        for set in self.sets.iter_mut().filter(|set| surface.liquid[set.body as usize]) {
            surface.relieve(&self.grid, set);
        }
        self.free_surface = Some(surface);
    }

    fn fill_ratios(&self, surface: &mut FreeSurface<D>) {
        let FreeSurface { layout, sums, densities, .. } = surface;
        sums.fill(Lanes::ZERO);
        let (grid, strides) = (&self.grid, layout.strides());
        layout.scatter(sums, |slab, window, offset| {
            for set in &self.sets {
                let scale = 1.0 / densities[set.body as usize];
                for p in set.slabs[slab]..set.slabs[slab + 1] {
                    let stencil = Stencil::<D, 2>::new::<Linear>(grid, &set.position[p], &[0.0; D]);
                    let volume = Lanes::new([scale * set.mass[p], 0.0, 0.0, 0.0]);
                    stencil.deposit_motion(window, offset, &strides, volume);
                    let lowest: usize = (0..D).map(|axis| stencil.first[axis] * strides[axis]).sum();
                    window[lowest - offset] = window[lowest - offset] * Lanes::new([1.0, 0.0, 0.0, 0.0])
                        + Lanes::new([0.0, 1.0, 0.0, 0.0]);
                }
            }
        });
        surface.divide(grid);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::points::FixedDomain;
    use crate::setup;

    /// A stack of water of two whole cells and half a cell, in a tank as wide.
    fn stack() -> MpmSolver<2, 2, Linear, FixedDomain> {
        let text = r#"{
            "title": "stack", "space": "plane-strain", "domain": { "min": [0, 0], "max": [3, 4] }, "gravity": [0, -1],
            "materials": { "water": { "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 1e6 } },
            "bodies": [{ "name": "b", "material": "water", "shape": { "kind": "box", "min": [0, 0], "max": [3, 2.5] },
                         "stress": { "kind": "uniform", "value": [-10, -10, -10, 0, 0, 0] } }],
            "stages": [{ "name": "s", "duration": 1 }],
            "methods": { "mpm": { "cell_size": 1, "points_per_cell": 20, "shape": "linear", "free_surface": 0.7 } }
        }"#;
        let case = Case::from_json(text).unwrap();
        setup::solver(&case, &setup::options(&case).unwrap()).unwrap()
    }

    #[test]
    fn fill_ratios_are_those_of_the_sheet() {
        let mut solver = stack();
        let mut surface = solver.free_surface.take().unwrap();
        solver.fill_ratios(&mut surface);
        // A surface cell filled to f = 0.5: f² above and (1 + 2 f - f²)/2 below it, but for the points' midpoint rule.
        let at = |x: usize, y: usize| surface.fill[x * surface.layout.strides()[0] + y];
        for x in 0..4 {
            assert!((at(x, 3) - 0.25).abs() < 1e-3, "{}", at(x, 3));
            assert!((at(x, 2) - 0.875).abs() < 1e-3, "{}", at(x, 2));
            assert!((at(x, 1) - 1.0).abs() < 1e-12 && (at(x, 0) - 1.0).abs() < 1e-2 && at(x, 4) == 0.0);
        }
    }

    #[test]
    fn points_near_the_surface_carry_no_stress() {
        let mut solver = stack();
        solver.sets[0].volume.iter_mut().for_each(|volume| *volume *= 0.9);
        solver.free_surface();
        // Between 0.875 and 0.25 the ratio falls to 0.7 at 0.28 of the cell.
        let set = &solver.sets[0];
        for p in 0..set.len() {
            let relieved = set.position[p][1] > 2.28;
            assert_eq!(set.stress[p].0 == [0.0; 6], relieved, "{:?}", set.position[p]);
            assert!((set.volume[p] * 1000.0 / set.mass[p] - if relieved { 1.0 } else { 0.9 }).abs() < 1e-12);
        }
    }
}
