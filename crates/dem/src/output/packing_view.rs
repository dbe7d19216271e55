//! View of the packing for measures: its present contacts, and the stress of each grain.

use colluvium_case::spatial;
use colluvium_constitutive::SymTensor;
use colluvium_points::surface::ContactQuery;

use crate::boundary::boundary_conditions::BoundaryConditions;
use crate::boundary::controlled_cell::ControlledCell;
use crate::clock::Clock;
use crate::config::LeverArm;
use crate::contact::bond::Bond;
use crate::contact::contact_histories::PairList;
use crate::contact::contact_laws::ContactLaws;
use crate::contact::{Contact, ContactEnergies, ContactForce};
use crate::force_loop::{ContactInput, probe_contact};
use crate::neighbours::grain_neighbours::GrainNeighbours;
use crate::output::records::Records;
use crate::points::grains::{Grains, volume};
use crate::points::vector::{add, difference, dot, from_tangential, scaled};

/// View of the grains and all that their contacts depend on.
#[derive(Clone, Copy)]
pub struct PackingView<'a, const D: usize, const R: usize> {
    /// Case, stage and time.
    pub clock: &'a Clock,
    /// Contact laws.
    pub laws: &'a ContactLaws,
    /// Grains.
    pub grains: &'a Grains<D, R>,
    /// Cell and its stress.
    pub cell: &'a ControlledCell<D>,
    /// Walls, obstacles and membranes.
    pub boundary: &'a BoundaryConditions<D>,
    /// Pair lists, grains near walls and contact histories.
    pub neighbours: &'a GrainNeighbours<D, R>,
    /// Energy balance, broken bonds and controlled stresses.
    pub records: &'a Records,
}

impl<const D: usize, const R: usize> PackingView<'_, D, R> {
    /// Calls `visit` for every present contact, with its force and energies.
    pub(crate) fn for_each_contact(
        &self,
        mut visit: impl FnMut(Contact<D>, &ContactForce<R>, &ContactEnergies),
    ) {
        let mut shifts = Vec::new();
        self.cell.geometry.shifts(&mut shifts);
        let mut input = ContactInput::new(self.grains.view(), &self.laws.stage.pairs, self.laws.kinds.len());
        input.shifts = &shifts;
        input.radii = self.clock.options.lever_arm == LeverArm::Radius;
        for pairs in [&self.neighbours.pairs.slab_pairs, &self.neighbours.pairs.periodic_pairs] {
            self.visit_pairs(&input, pairs, &mut visit);
        }
        let mut facets = ContactQuery::default();
        for k in 0..self.neighbours.walls.grain.len() {
            let (i, wall) = (
                self.neighbours.walls.grain[k] as usize,
                &self.boundary.walls[self.neighbours.walls.wall[k] as usize],
            );
            let nearest = match wall.current_surface() {
                None => wall.distance(&self.grains.position[i]),
                Some(surface) => {
                    facets.clear();
                    surface.query_contacts(
                        &self.grains.position[i],
                        self.grains.radius[i] + self.laws.stage.rupture_distance,
                        &mut facets,
                    );
                    let own = facets
                        .contacts()
                        .iter()
                        .find(|place| place.feature_id == self.neighbours.walls.facet_key[k]);
                    let Some(place) = own else { continue };
                    (place.distance, place.normal)
                }
            };
            let (geometry, _) = input.wall_contact_geometry(i, wall, nearest);
            let law = wall.law(self.grains.kind[i] as usize, &self.grains.position[i], &nearest);
            let Some((contact, energies)) = probe_contact(
                law,
                &geometry,
                self.neighbours.walls.history.get(k),
                None,
                self.clock.last_step,
            ) else {
                continue;
            };
            let mut force = from_tangential(&contact.tangential, &geometry.normal);
            add(&mut force, contact.normal, &geometry.normal);
            let branch = scaled(self.grains.radius[i] - geometry.overlap, &geometry.normal);
            let (normal, overlap) = (contact.normal, geometry.overlap);
            visit(Contact { grain: i, second: None, branch, force, normal, overlap }, &contact, &energies);
        }
    }

    /// Visits all contacts of a pair list with their forces and energies.
    fn visit_pairs(
        &self,
        input: &ContactInput<'_, D, R>,
        pairs: &PairList<R>,
        visit: &mut impl FnMut(Contact<D>, &ContactForce<R>, &ContactEnergies),
    ) {
        for (i, k) in pairs.first_grains() {
            let j = pairs.second[k] as usize;
            let code = pairs.image.get(k).map_or(0, |code| *code as usize);
            let mut apart = difference(&self.grains.position[i], &self.grains.position[j]);
            apart = difference(&apart, &input.shifts[code].0);
            let distance = dot(&apart, &apart).sqrt();
            let (geometry, _) = input.contact_geometry(i, j, &apart, distance, code);
            let bond: Option<&Bond<R>> = pairs.histories.bond.get(k);
            let Some((contact, energies)) =
                probe_contact(input.law(i, j), &geometry, pairs.histories.get(k), bond, self.clock.last_step)
            else {
                continue;
            };
            let mut force = from_tangential(&contact.tangential, &geometry.normal);
            add(&mut force, contact.normal, &geometry.normal);
            let (normal, overlap) = (contact.normal, geometry.overlap);
            visit(
                Contact { grain: i, second: Some(j), branch: apart, force, normal, overlap },
                &contact,
                &energies,
            );
        }
    }

    /// Overlap of a contact over the smaller radius.
    pub(crate) fn overlap_of(&self, contact: &Contact<D>) -> f64 {
        let radius = &self.grains.radius;
        let small = contact.second.map_or(radius[contact.grain], |j| radius[contact.grain].min(radius[j]));
        contact.overlap / small
    }

    /// All current contacts with their forces.
    pub fn contacts(&self) -> Vec<Contact<D>> {
        let mut all = Vec::new();
        self.for_each_contact(|contact, _, _| all.push(contact));
        all
    }

    /// Stress of each grain from its contacts, over the volume of the grain (Pa), and its number of contacts.
    pub(crate) fn grain_stresses(&self) -> (Vec<SymTensor>, Vec<f64>) {
        let g = &self.grains;
        let (mut sums, mut counts) = (vec![[[0.0; 3]; 3]; g.len()], vec![0.0; g.len()]);
        self.for_each_contact(|contact, _, _| {
            let (force, branch) = (spatial(&contact.force), spatial(&contact.branch));
            let i = contact.grain;
            let mut take = |grain: usize, share: f64| {
                counts[grain] += 1.0;
                for a in 0..3 {
                    for b in 0..3 {
                        // The lever arm points from the centre, opposite to the branch of the first grain.
                        sums[grain][a][b] -= share * force[a] * branch[b];
                    }
                }
            };
            match contact.second {
                None => take(i, 1.0),
                Some(j) => {
                    let share = g.radius[i] / (g.radius[i] + g.radius[j]);
                    take(i, share);
                    take(j, 1.0 - share);
                }
            }
        });
        let stress = sums.iter().zip(&g.radius).map(|(sum, radius)| {
            let v = volume(D, *radius);
            let mean = |a: usize, b: usize| 0.5 * (sum[a][b] + sum[b][a]) / v;
            SymTensor([mean(0, 0), mean(1, 1), mean(2, 2), mean(0, 1), mean(1, 2), mean(2, 0)])
        });
        (stress.collect(), counts)
    }
}
