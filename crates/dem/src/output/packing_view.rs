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
use crate::contact::{Contact, ContactEnergies, ContactForce, ContactState};
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

/// Contact, its force in tangent coordinates, and its energies.
pub(crate) type ProbedContact<const D: usize, const R: usize> =
    (Contact<D>, ContactForce<R>, ContactEnergies);

impl<'a, const D: usize, const R: usize> PackingView<'a, D, R> {
    /// Calls `visit` for every present contact, with its force and energies.
    pub(crate) fn for_each_contact(
        &self,
        mut visit: impl FnMut(Contact<D>, &ContactForce<R>, &ContactEnergies),
    ) {
        let input = self.contact_input();
        let mut shifts = Vec::new();
        self.cell.geometry.shifts(&mut shifts);
        let mut show = |found: Option<ProbedContact<D, R>>| {
            if let Some((contact, force, energies)) = found {
                visit(contact, &force, &energies);
            }
        };
        for pairs in self.pair_lists() {
            pairs.first_grains().for_each(|pair| show(self.pair_contact(&input, &shifts, pairs, pair)));
        }
        let mut facets = ContactQuery::default();
        (0..self.neighbours.walls.grain.len()).for_each(|k| show(self.wall_contact(&input, &mut facets, k)));
    }

    /// Iterator over the present contacts, each computed when it is reached.
    pub(crate) fn contact_iter(&self) -> impl Iterator<Item = Contact<D>> + use<'a, D, R> {
        let view = *self;
        let mut shifts = Vec::new();
        view.cell.geometry.shifts(&mut shifts);
        let mut facets = ContactQuery::default();
        let pairs = view
            .pair_lists()
            .into_iter()
            .flat_map(|pairs| pairs.first_grains().map(move |pair| (pairs, pair)));
        let of_pairs = pairs
            .filter_map(move |(pairs, pair)| view.pair_contact(&view.contact_input(), &shifts, pairs, pair));
        let of_walls = (0..view.neighbours.walls.grain.len())
            .filter_map(move |k| view.wall_contact(&view.contact_input(), &mut facets, k));
        of_pairs.chain(of_walls).map(|(contact, _, _)| contact)
    }

    /// Lists of the pairs of grains.
    fn pair_lists(&self) -> [&'a PairList<R>; 2] {
        [&self.neighbours.pairs.slab_pairs, &self.neighbours.pairs.periodic_pairs]
    }

    /// Input of the contact laws, without images.
    fn contact_input(&self) -> ContactInput<'a, D, R> {
        let mut input = ContactInput::new(self.grains.view(), &self.laws.stage.pairs, self.laws.kinds.len());
        input.radii = self.clock.options.lever_arm == LeverArm::Radius;
        input
    }

    /// Contact of entry `k` of the list of grains near walls; `None` without a force.
    fn wall_contact(
        &self,
        input: &ContactInput<'_, D, R>,
        facets: &mut ContactQuery<D>,
        k: usize,
    ) -> Option<ProbedContact<D, R>> {
        let near = &self.neighbours.walls;
        let (i, wall) = (near.grain[k] as usize, &self.boundary.walls[near.wall[k] as usize]);
        let x = &self.grains.position[i];
        let nearest = match wall.current_surface() {
            None => wall.distance(x),
            Some(surface) => {
                facets.clear();
                surface.query_contacts(x, self.grains.radius[i] + self.laws.stage.rupture_distance, facets);
                let place = facets.contacts().iter().find(|place| place.feature_id == near.facet_key[k])?;
                (place.distance, place.normal)
            }
        };
        let (geometry, _) = input.wall_contact_geometry(i, wall, nearest);
        let law = wall.law(self.grains.kind[i] as usize, x, &nearest);
        let history = near.history.get(k);
        let is_bonded = history.state == ContactState::Bonded;
        let (contact, energies) = probe_contact(law, &geometry, history, None, self.clock.last_step)?;
        let branch = scaled(self.grains.radius[i] - geometry.overlap, &geometry.normal);
        let found = Contact {
            grain: i,
            second: None,
            ids: (self.grains.id[i], None),
            wall: Some(wall.boundary),
            unit_normal: geometry.normal,
            branch,
            force: total_force(&contact, &geometry.normal),
            normal: contact.normal,
            overlap: geometry.overlap,
            is_bonded,
        };
        Some((found, contact, energies))
    }

    /// Contact of the grain `i` of the pair `k` of a list; `None` without a force. `shifts` are those of the images.
    fn pair_contact(
        &self,
        input: &ContactInput<'_, D, R>,
        shifts: &[([f64; D], [f64; D])],
        pairs: &PairList<R>,
        (i, k): (usize, usize),
    ) -> Option<ProbedContact<D, R>> {
        let j = pairs.second[k] as usize;
        let code = pairs.image.get(k).map_or(0, |code| *code as usize);
        let mut apart = difference(&self.grains.position[i], &self.grains.position[j]);
        apart = difference(&apart, &shifts[code].0);
        let distance = dot(&apart, &apart).sqrt();
        let (geometry, _) = ContactInput { shifts, ..*input }.contact_geometry(i, j, &apart, distance, code);
        let bond: Option<&Bond<R>> = pairs.histories.bond.get(k);
        let history = pairs.histories.get(k);
        let is_bonded = history.state == ContactState::Bonded || bond.is_some_and(Bond::is_intact);
        let (contact, energies) =
            probe_contact(input.law(i, j), &geometry, history, bond, self.clock.last_step)?;
        let found = Contact {
            grain: i,
            second: Some(j),
            ids: (self.grains.id[i], Some(self.grains.id[j])),
            wall: None,
            unit_normal: geometry.normal,
            branch: apart,
            force: total_force(&contact, &geometry.normal),
            normal: contact.normal,
            overlap: geometry.overlap,
            is_bonded,
        };
        Some((found, contact, energies))
    }

    /// Overlap of a contact over the smaller radius.
    pub(crate) fn overlap_of(&self, contact: &Contact<D>) -> f64 {
        let radius = &self.grains.radius;
        let small = contact.second.map_or(radius[contact.grain], |j| radius[contact.grain].min(radius[j]));
        contact.overlap / small
    }

    /// All current contacts with their forces.
    pub fn contacts(&self) -> Vec<Contact<D>> {
        self.contact_iter().collect()
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

/// Force of a contact on its first grain (N), from its normal and tangential parts.
fn total_force<const D: usize, const R: usize>(contact: &ContactForce<R>, normal: &[f64; D]) -> [f64; D] {
    let mut force = from_tangential(&contact.tangential, normal);
    add(&mut force, contact.normal, normal);
    force
}
