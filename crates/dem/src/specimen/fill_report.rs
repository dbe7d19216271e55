//! Reports on the filling of bodies with grains.

use crate::config::Fill;
use crate::points::grains::volume;
use crate::points::vector::{difference, dot};
use crate::setup::fill_of_body;
use crate::solver::DemSolver;
use crate::specimen::Specimen;

/// Gap over the smaller radius up to which grains count as in contact: dropped ones are in contact to round-off.
const CONTACT_TOLERANCE: f64 = 1e-9;

impl<const D: usize, const R: usize> DemSolver<D, R> {
    /// Bodies that were filled with grains at the start, except single grains, points, specimens from files and bodies filled by
    /// pluviation.
    pub fn specimens(&self) -> &[Specimen] {
        &self.specimens
    }

    /// Reports on the bodies as they are filled at present.
    pub(crate) fn find_specimens(&self) -> Vec<Specimen> {
        let mut counts = vec![0usize; self.case.bodies.len()];
        let mut solid = vec![0.0; counts.len()];
        for (body, radius) in self.grains.body.iter().zip(&self.grains.radius) {
            counts[*body as usize] += 1;
            solid[*body as usize] += volume(D, *radius);
        }
        let touching = self.touching_grains();
        let specimen = |(number, body): (usize, &colluvium_case::description::Body)| {
            let asked = match fill_of_body(&self.options, body)? {
                _ if body.points.is_some() || self.specimen_source.has(number) => return None,
                _ if self.sources.iter().any(|source| source.body as usize == number) => return None,
                Fill::Single | Fill::Sleeve { .. } => return None,
                Fill::Lattice { .. } | Fill::DropAndRoll => None,
                Fill::Random { solid_fraction } | Fill::Layers { solid_fraction, .. } => {
                    Some(1.0 - solid_fraction)
                }
            };
            let space = body.shape.volume(D, false);
            (counts[number] > 0).then(|| Specimen {
                body: body.name.clone(),
                grains: counts[number],
                porosity: 1.0 - solid[number] / space,
                requested_porosity: asked,
                coordination: touching[number] as f64 / counts[number] as f64,
            })
        };
        self.case.bodies.iter().enumerate().filter_map(specimen).collect()
    }

    /// Number of contacts of the grains of each body, each counted for both of its grains.
    fn touching_grains(&self) -> Vec<usize> {
        let mut counts = vec![0usize; self.case.bodies.len()];
        let (g, mut shifts) = (&self.grains, Vec::new());
        self.cell.shifts(&mut shifts);
        for pairs in [&self.lists.slab_pairs, &self.lists.periodic_pairs] {
            for (i, k) in pairs.firsts() {
                let j = pairs.other[k] as usize;
                let code = pairs.image.get(k).map_or(0, |code| *code as usize);
                let apart = difference(&difference(&g.position[i], &g.position[j]), &shifts[code].0);
                let reach = g.radius[i] + g.radius[j] + CONTACT_TOLERANCE * g.radius[i].min(g.radius[j]);
                if dot(&apart, &apart) <= reach * reach {
                    counts[g.body[i] as usize] += 1;
                    counts[g.body[j] as usize] += 1;
                }
            }
        }
        counts
    }
}
