//! Reports on the filling of bodies with grains.

use crate::config::Fill;
use crate::output::packing_view::PackingView;
use crate::points::grains::volume;
use crate::points::vector::{difference, dot};
use crate::specimen::Specimen;
use crate::specimen::specimen_preparation::SpecimenPreparation;

/// Gap over the smaller radius up to which grains are regarded as in contact; dropped grains touch to round-off.
const CONTACT_TOLERANCE: f64 = 1e-9;

/// Reports on the bodies as they are filled at present.
pub fn fill_reports<const D: usize, const R: usize>(
    view: &PackingView<'_, D, R>,
    specimen: &SpecimenPreparation,
) -> Vec<Specimen> {
    let case = &view.clock.case;
    let mut counts = vec![0usize; case.bodies.len()];
    let mut solid = vec![0.0; counts.len()];
    for (body, radius) in view.grains.body.iter().zip(&view.grains.radius) {
        counts[*body as usize] += 1;
        solid[*body as usize] += volume(D, *radius);
    }
    let touching = contacts_of_bodies(view);
    let report = |(number, body): (usize, &colluvium_case::description::Body)| {
        let requested_porosity = match view.clock.options.fill_of_body(body)? {
            _ if body.points.is_some() || specimen.source.has_body(number) => return None,
            _ if specimen.sources.iter().any(|source| source.body as usize == number) => return None,
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
            requested_porosity,
            coordination: touching[number] as f64 / counts[number] as f64,
        })
    };
    case.bodies.iter().enumerate().filter_map(report).collect()
}

/// Number of contacts of the grains of each body, each counted for both of its grains.
fn contacts_of_bodies<const D: usize, const R: usize>(view: &PackingView<'_, D, R>) -> Vec<usize> {
    let mut counts = vec![0usize; view.clock.case.bodies.len()];
    let (g, mut shifts) = (view.grains, Vec::new());
    view.cell.geometry.shifts(&mut shifts);
    let lists = &view.neighbours.pairs;
    for pairs in [&lists.slab_pairs, &lists.periodic_pairs] {
        for (i, k) in pairs.first_grains() {
            let j = pairs.second[k] as usize;
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
