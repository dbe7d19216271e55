//! Contact between bodies: a velocity field for each, and Coulomb friction with adhesion where they meet
//! (Bardenhagen et al. 2001; MPM sheet §2.12, §3.6).
//!
//! The normal of a node is the difference of the directions of the gradients of the two bodies' volumes, so that it is
//! opposite for the two, and momentum is conserved. Within a body the gradient is noise, and counts by its size. The sum `Σ_p Ω_p ∇N_i` is the integral of `N_i n` over the surface of a body: its
//! component along the normal is the node's share of the contact's area, which sums to the whole area wherever the
//! interface lies between the nodes.

use colluvium_case::{Case, CaseError};
use colluvium_grid::{Basis, Lanes, Node, Support, Walls};
use rayon::prelude::*;

use crate::MpmOptions;
use crate::points::{PointDomain, PointSet, ground};
use crate::solver::MpmSolver;

/// Gradients of volume within a body, over the largest possible: what points make that no longer lie in rows.
const NOISE: f64 = 0.1;

/// How two velocity fields act on each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// The fields, the lower number first.
    pub fields: [usize; 2],
    /// `None`: they stick.
    pub law: Option<ContactLaw>,
}

/// Coulomb friction with adhesion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLaw {
    /// Coefficient of friction.
    pub friction: f64,
    /// Adhesion (Pa).
    pub adhesion: f64,
    /// Unit vector from the first field to the second, where the case gives it.
    pub normal: Option<[f64; 3]>,
}

/// All contacts of a case.
#[derive(Clone, Debug, Default)]
pub struct Contacts {
    /// Every pair of fields, in order; empty for a single field.
    pub pairs: Vec<Pair>,
    /// `Σ_p Ω_p ∇N_i` of each field (m²), and in the fourth lane `Σ_p Ω_p N_i` over the cell size, field after field;
    /// empty for a single field.
    pub surfaces: Vec<Lanes>,
}

impl Contacts {
    /// Number of velocity fields: with `n` of them there are `n (n - 1) / 2` pairs.
    pub fn fields(&self) -> usize {
        self.pairs.last().map_or(1, |pair| pair.fields[1] + 1)
    }
}

/// Gives each body that a contact names a field of its own, and lists the pairs.
pub fn contacts<const D: usize, P: PointDomain<D>>(
    case: &Case,
    options: &MpmOptions,
    sets: &mut [PointSet<D, P>],
) -> Result<Contacts, CaseError> {
    let mut bodies = Vec::new();
    let mut laws: Vec<([usize; 2], ContactLaw)> = Vec::new();
    for (number, contact) in options.contacts.iter().enumerate() {
        let path = |key: &str| format!("methods.mpm.contacts[{number}].{key}");
        let mut pair = [0; 2];
        for (side, name) in contact.bodies.iter().enumerate() {
            let Some(body) = case.bodies.iter().position(|body| body.name == *name) else {
                return Err(CaseError::new(path("bodies"), format!("{name:?} is not a body")));
            };
            pair[side] = body;
            if !bodies.contains(&body) {
                bodies.push(body);
            }
        }
        if pair[0] == pair[1] {
            return Err(CaseError::new(path("bodies"), "a contact is between two bodies"));
        }
        if laws.iter().any(|(other, _)| *other == pair || *other == [pair[1], pair[0]]) {
            return Err(CaseError::new(path("bodies"), "an earlier contact names the same two bodies"));
        }
        for (key, value) in
            [("friction_coefficient", contact.friction_coefficient), ("adhesion", contact.adhesion)]
        {
            if !(value.is_finite() && value >= 0.0) {
                return Err(CaseError::new(path(key), format!("{value} must be finite and not negative")));
            }
        }
        let normal =
            contact.normal.as_deref().map(|n| unit::<D>(n).ok_or("must be a vector of the space, not zero"));
        let normal = normal.transpose().map_err(|problem| CaseError::new(path("normal"), problem))?;
        let (friction, adhesion) = (contact.friction_coefficient, contact.adhesion);
        laws.push((pair, ContactLaw { friction, adhesion, normal }));
    }
    if laws.is_empty() {
        return Ok(Contacts::default());
    }
    bodies.sort_unstable();
    let shared = usize::from(bodies.len() < case.bodies.len());
    for set in sets {
        set.field = bodies.binary_search(&(set.body as usize)).map_or(0, |place| place + shared);
    }
    let field = |body: usize| bodies.binary_search(&body).unwrap_or(0) + shared;
    let mut pairs = Vec::new();
    for second in 1..bodies.len() + shared {
        for first in 0..second {
            let law = laws.iter().find_map(|([a, b], law)| match [field(*a), field(*b)] {
                pair if pair == [first, second] => Some(*law),
                pair if pair == [second, first] => {
                    Some(ContactLaw { normal: law.normal.map(|n| n.map(|c| -c)), ..*law })
                }
                _ => None,
            });
            pairs.push(Pair { fields: [first, second], law });
        }
    }
    Ok(Contacts { pairs, surfaces: Vec::new() })
}

fn unit<const D: usize>(vector: &[f64]) -> Option<[f64; 3]> {
    let length = norm(&std::array::from_fn(|c| vector.get(c).copied().unwrap_or(0.0)));
    let holds = vector.len() == D && length.is_finite() && length > 0.0;
    holds.then(|| std::array::from_fn(|c| vector.get(c).copied().unwrap_or(0.0) / length))
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn norm(a: &[f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

fn three(lanes: Lanes) -> [f64; 3] {
    let [x, y, z, _] = lanes.to_array();
    [x, y, z]
}

impl ContactLaw {
    /// Unit normal from the first body to the second and the node's area (m²), from the surface integrals of the two
    /// (in the fourth lane: volumes over the cell size); `None` where there is no telling.
    fn surface(&self, surfaces: [Lanes; 2]) -> Option<([f64; 3], f64)> {
        let [first, second] = surfaces.map(three);
        let normal = match self.normal {
            Some(normal) => normal,
            None => {
                let [one, other] = surfaces.map(direction);
                let across = std::array::from_fn(|c| one[c] - other[c]);
                let length = norm(&across);
                // Written so that NaN tells nothing.
                if !(length > 0.0) {
                    return None;
                }
                across.map(|c| c / length)
            }
        };
        let across = std::array::from_fn(|c| first[c] - second[c]);
        Some((normal, 0.5 * dot(&across, &normal).abs()))
    }

    /// The impulse (N s) on the first body; `None` where they separate. `masses` are inertias (kg), `dt` the step.
    fn impulse(
        &self,
        masses: [f64; 2],
        velocities: [&[f64; 3]; 2],
        (normal, area): ([f64; 3], f64),
        dt: f64,
    ) -> Option<[f64; 3]> {
        // m_a (v_a - v) with the velocity v of the two together.
        let reduced = masses[0] * masses[1] / (masses[0] + masses[1]);
        let relative: [f64; 3] = std::array::from_fn(|c| reduced * (velocities[0][c] - velocities[1][c]));
        let approach = dot(&relative, &normal);
        // Written so that NaN separates; the run then stops by itself.
        if !(approach > 0.0) {
            return None;
        }
        let along: [f64; 3] = std::array::from_fn(|c| relative[c] - approach * normal[c]);
        let shear = norm(&along);
        let strength = self.friction * approach + self.adhesion * area * dt;
        if shear <= strength {
            return Some(relative.map(|c| -c));
        }
        Some(std::array::from_fn(|c| -approach * normal[c] - strength * along[c] / shear))
    }
}

/// Direction of a surface integral, shorter than a unit vector where it is noise: less than `NOISE` of what the volume
/// at the node could make.
fn direction(surface: Lanes) -> [f64; 3] {
    let vector = three(surface);
    let length = norm(&vector).max(NOISE * surface.as_array()[3]);
    vector.map(|c| if length > 0.0 { c / length } else { 0.0 })
}

/// The velocity of two masses together.
fn together(masses: [f64; 2], velocities: [&[f64; 3]; 2]) -> [f64; 3] {
    let sum = masses[0] + masses[1];
    std::array::from_fn(|c| (masses[0] * velocities[0][c] + masses[1] * velocities[1][c]) / sum)
}

/// Two fields of `len` nodes each, borrowed together.
fn two<T>(nodes: &mut [T], len: usize, [first, second]: [usize; 2]) -> (&mut [T], &mut [T]) {
    let (low, high) = nodes.split_at_mut(second * len);
    (&mut low[first * len..(first + 1) * len], &mut high[..len])
}

/// What the contact of a pair of fields needs at every node.
struct Touch<'a, const D: usize> {
    law: Option<ContactLaw>,
    walls: &'a Walls,
    nodes: [usize; D],
    keep_start: bool,
    light: f64,
    inertia: f64,
    dt: f64,
}

impl<const D: usize> Touch<'_, D> {
    fn index(&self, row: usize, number: usize) -> [usize; 3] {
        match D {
            1 => [row, 0, 0],
            2 => [row, number, 0],
            _ => [row, number / self.nodes[D - 1], number % self.nodes[D - 1]],
        }
    }

    /// Lets two solved nodes act on each other.
    fn solved(&self, index: &[usize; 3], pair: [&mut Node; 2], surfaces: [Lanes; 2]) {
        let masses = [pair[0].motion.as_array()[3], pair[1].motion.as_array()[3]];
        if masses[0] <= self.light || masses[1] <= self.light {
            return;
        }
        let ends = [three(pair[0].motion), three(pair[1].motion)];
        let Some(touched) = self.velocities(masses, [&ends[0], &ends[1]], surfaces) else { return };
        for (side, node) in pair.into_iter().enumerate() {
            let rate = three(node.force);
            let mut start: [f64; 3] = std::array::from_fn(|c| ends[side][c] - self.dt * rate[c]);
            let mut end = touched[side];
            self.wall(index, &mut start, &mut end);
            node.motion = Lanes::new([end[0], end[1], end[2], masses[side]]);
            let rate = |c: usize| (end[c] - start[c]) / self.dt;
            node.force = Lanes::new([rate(0), rate(1), rate(2), 0.0]);
        }
    }

    fn wall(&self, index: &[usize; 3], start: &mut [f64; 3], end: &mut [f64; 3]) {
        for axis in 0..D {
            if let Some(wall) = self.walls.at(axis, index) {
                wall.constrain(start, end, self.keep_start);
            }
        }
    }

    /// Velocities after contact; `None` without it.
    fn velocities(
        &self,
        masses: [f64; 2],
        ends: [&[f64; 3]; 2],
        surfaces: [Lanes; 2],
    ) -> Option<[[f64; 3]; 2]> {
        let common = together(masses, ends);
        let Some(law) = &self.law else { return Some([common; 2]) };
        let surface = law.surface(surfaces)?;
        let inertias = masses.map(|mass| self.inertia * mass);
        let impulse = law.impulse(inertias, ends, surface, self.dt)?;
        let moved = |side: usize, sign: f64| -> [f64; 3] {
            std::array::from_fn(|c| ends[side][c] + sign * impulse[c] / inertias[side])
        };
        let touched = [moved(0, 1.0), moved(1, -1.0)];
        // What sticks has the same velocity to the last bit: re-mapping asks for it.
        let relative: [f64; 3] = std::array::from_fn(|c| touched[0][c] - touched[1][c]);
        let before: [f64; 3] = std::array::from_fn(|c| ends[0][c] - ends[1][c]);
        Some(if norm(&relative) <= 1e-12 * norm(&before) { [common; 2] } else { touched })
    }

    /// Re-mapped velocities: no approach, and what stuck sticks.
    fn again(&self, solved: [&Node; 2], pair: [&mut Lanes; 2], surfaces: [Lanes; 2]) {
        let masses = [solved[0].motion.as_array()[3], solved[1].motion.as_array()[3]];
        if masses[0] <= self.light || masses[1] <= self.light {
            return;
        }
        let velocities = [three(*pair[0]), three(*pair[1])];
        let common = together(masses, [&velocities[0], &velocities[1]]);
        let stuck = three(solved[0].motion) == three(solved[1].motion);
        let mut after = [common; 2];
        if let Some(law) = &self.law {
            let Some((normal, _)) = law.surface(surfaces) else { return };
            let relative: [f64; 3] = std::array::from_fn(|c| velocities[0][c] - velocities[1][c]);
            if !(dot(&relative, &normal) > 0.0) {
                return;
            }
            if !stuck {
                for side in 0..2 {
                    let excess: [f64; 3] = std::array::from_fn(|c| velocities[side][c] - common[c]);
                    let into = dot(&excess, &normal);
                    after[side] = std::array::from_fn(|c| velocities[side][c] - into * normal[c]);
                }
            }
        }
        for (velocity, after) in pair.into_iter().zip(after) {
            *velocity = Lanes::new([after[0], after[1], after[2], 0.0]);
        }
    }
}

impl<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>> MpmSolver<D, S, B, P> {
    /// Surface integrals `Σ_p Ω_p ∇N_i` of the bodies, for normals and areas.
    pub(crate) fn scatter_surfaces(&mut self) {
        let strides = self.layout.strides();
        let (sets, ground) = (&self.sets, ground!(self));
        let of_field = |field: usize| sets.iter().filter(move |set| set.field == field);
        for (field, nodes) in self.contacts.surfaces.chunks_exact_mut(self.layout.len()).enumerate() {
            self.layout.reset(nodes);
            self.layout.scatter(nodes, |slab, window, offset| {
                for set in of_field(field) {
                    for p in set.slabs[slab]..set.slabs[slab + 1] {
                        let stencil = set.domain[p].support::<S, B>(&ground, &set.position[p], &set.extent);
                        let columns = std::array::from_fn(|j| {
                            let at = |i: usize| if i == j { set.volume[p] } else { 0.0 };
                            Lanes::new([at(0), at(1), at(2), 0.0])
                        });
                        let volume = Lanes::new([0.0, 0.0, 0.0, set.volume[p] / ground.grid.cell]);
                        stencil.deposit_slopes(window, offset, &strides, volume, &columns, |node| node);
                    }
                }
            });
        }
    }

    fn touching(&self, law: Option<ContactLaw>, dt: f64) -> Touch<'_, D> {
        Touch {
            law,
            walls: &self.walls,
            nodes: self.layout.nodes(),
            keep_start: self.options.fixed_nodes == crate::FixedNodes::Momentum,
            light: self.options.node_mass_cutoff * self.heaviest,
            inertia: self.options.mass_scaling,
            dt,
        }
    }

    /// Contact of the solved velocities, pair after pair.
    pub(crate) fn touch(&mut self, dt: f64) {
        let (len, row_length) = (self.layout.len(), self.layout.strides()[0]);
        let mut nodes = std::mem::take(&mut self.nodes);
        for Pair { fields: [first, second], law } in &self.contacts.pairs {
            let touch = self.touching(*law, dt);
            let surfaces = &self.contacts.surfaces;
            let (a, b) = two(&mut nodes, len, [*first, *second]);
            let rows = a.par_chunks_mut(row_length).zip(b.par_chunks_mut(row_length)).enumerate();
            rows.for_each(|(row, (a, b))| {
                for number in self.layout.active(row) {
                    let place = row * row_length + number;
                    let surfaces = [surfaces[first * len + place], surfaces[second * len + place]];
                    touch.solved(&touch.index(row, number), [&mut a[number], &mut b[number]], surfaces);
                }
            });
        }
        self.nodes = nodes;
    }

    /// Contact of the re-mapped velocities.
    pub(crate) fn touch_again(&mut self) {
        let (len, row_length) = (self.layout.len(), self.layout.strides()[0]);
        let mut velocities = std::mem::take(&mut self.remapped);
        for Pair { fields: [first, second], law } in &self.contacts.pairs {
            let touch = self.touching(*law, 1.0);
            let surfaces = &self.contacts.surfaces;
            let (a, b) = two(&mut velocities, len, [*first, *second]);
            let rows = a.par_chunks_mut(row_length).zip(b.par_chunks_mut(row_length)).enumerate();
            rows.for_each(|(row, (a, b))| {
                for number in self.layout.active(row) {
                    let place = row * row_length + number;
                    let surfaces = [surfaces[first * len + place], surfaces[second * len + place]];
                    let solved = [&self.nodes[first * len + place], &self.nodes[second * len + place]];
                    touch.again(solved, [&mut a[number], &mut b[number]], surfaces);
                }
            });
        }
        self.remapped = velocities;
    }
}
