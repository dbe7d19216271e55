//! Solver in ranks, for distributed memory (sheet: sph §3.9; Bui & Nguyen 2021, §3.7).
//!
//! Orthogonal recursive bisection gives each rank the particles of a box. A rank is a solver of its own for them and for copies of the
//! particles around: its halo, wide enough for one exchange per step. Beyond these copies ranks share the boxes and cuts, and global sums
//! and extremes: the least time step, the largest displacement, the largest smoothing length. All of this passes through
//! [`ParticleMessage`]s and returned values, so that
//! a message transport can replace the mailbox; here the ranks are tasks of one process.
//!
//! Neighbours are listed for all ranks at the same step. Then particles move to the rank whose box contains them (migration), and where the
//! loads of the ranks differ by more than a tenth the cuts are recomputed. In every rank the particles are in the sequence of the solver
//! without ranks, so that every sum runs over the same neighbours in
//! the same order: results are bitwise equal with any number of ranks.

mod particle_message;
mod solver_trait;

use colluvium_case::{SolverError, TimeStep};
use colluvium_points::{Bisection, BoundingBox, CellList};
use rayon::prelude::*;

use crate::config::{
    ContinuityEquation, DensityReset, MomentumEquation, Regularisation, SphOptions, Symmetrisation,
    WallStress,
};
use crate::critical_step::{critical_step, limit_by_obstacle_motion, to_time_step};
use crate::momentum::body_force::update_body_forces;
use crate::ranks::particle_message::{ParticleMessage, assemble};
use crate::rates::{ReactionSample, ReactionSum};
use crate::solver::{EquilibriumTerms, SphSolver, equilibrium_terms};
use crate::stress::regularisation::is_regularisation_due;
use crate::walls::ObstacleEnergies;

/// Largest load of a rank over the mean load, above which the partition is recomputed (sheet: sph §3.9).
const IMBALANCE: f64 = 1.1;

/// Width of the halo in kernel supports: one for the accelerations, one for the velocity gradients of neighbours, and one or two for each
/// further sum of an option.
fn halo_passes(options: &SphOptions) -> usize {
    let summed = options.continuity == ContinuityEquation::Summation
        || options.symmetrisation == Symmetrisation::GradH;
    let once = [
        summed,
        options.momentum == MomentumEquation::Corrected,
        options.confining.is_some(),
        options.regularisation != Regularisation::None,
        options.density_reset != DensityReset::None,
        // Shifting needs the free surface, which depends on the walls, and these on the soil around them.
        options.shifting > 0.0 && options.wall_stress != WallStress::Pairwise,
    ];
    // Extrapolated walls lie between a particle and the soil they use, with the accelerations and again with the
    // gradients; shifting needs the surface state of neighbours.
    let twice = [options.wall_stress != WallStress::Pairwise, options.shifting > 0.0];
    let count = |options: &[bool]| options.iter().filter(|on| **on).count();
    2 + count(&once) + 2 * count(&twice)
}

/// Rank: the particles of a box, and their halo.
struct Rank<const D: usize> {
    /// Solver for both; the particles of the halo are its ghosts.
    domain: SphSolver<D>,
    /// Index of each of its particles, halo included, in the sequence of a solver without ranks.
    sequence: Vec<u32>,
    /// For each rank, the indices of particles here that are in its halo.
    sent_particles: Vec<Vec<u32>>,
    /// For each rank, the indices of its particles in the halo here.
    received_particles: Vec<Vec<u32>>,
}

impl<const D: usize> Rank<D> {
    /// Rank with its subdomain, before the first exchange with the others.
    fn new(domain: SphSolver<D>, ranks: usize) -> Self {
        let sequence = (0..domain.bodies.particles.len() as u32).collect();
        Self {
            domain,
            sequence,
            sent_particles: vec![Vec::new(); ranks],
            received_particles: vec![Vec::new(); ranks],
        }
    }

    /// Indices of its own particles.
    fn own_particles(&self) -> impl Iterator<Item = u32> {
        (0..self.domain.bodies.particles.len() as u32).filter(|&i| !self.domain.bodies.is_ghost(i as usize))
    }

    /// Loads of the own particles of the rank: number of neighbours in the last list plus one.
    fn weights(&self) -> impl Iterator<Item = u32> {
        let listed = &self.domain.lists.neighbours;
        self.own_particles().map(|i| {
            1 + if (i as usize) < listed.len() { listed.neighbours(i as usize).len() } else { 0 } as u32
        })
    }

    /// Own particles of the rank in the halo of a box, directly or by an image.
    fn halo_of(
        &self,
        bounds: &BoundingBox<D>,
        width: f64,
        images: &[crate::walls::ImageParticle<D>],
    ) -> Vec<u32> {
        let x = &self.domain.lists.listed_positions.positions;
        let mut near: Vec<u32> =
            self.own_particles().filter(|&i| bounds.contains_within(&x[i as usize], width)).collect();
        let image_near = |image: &&crate::walls::ImageParticle<D>| {
            let x = &x[image.source as usize];
            bounds
                .contains_within(&std::array::from_fn(|c| image.axis_sign[c] * x[c] + image.shift[c]), width)
        };
        near.extend(images.iter().filter(image_near).map(|image| image.source));
        near.sort_unstable();
        near.dedup();
        near
    }
}

/// Explicit SPH solver in `D` dimensions, in ranks.
pub struct RankedSolver<const D: usize> {
    ranks: Vec<Rank<D>>,
    /// Last message of each rank to each other one.
    messages: Vec<Vec<ParticleMessage<D>>>,
    cuts: Option<Bisection<D>>,
    /// Whether the particles are distributed, and neighbours listed.
    is_distributed: bool,
}

/// Applies a function to all ranks in parallel.
fn on_all<const D: usize, T: Send>(
    ranks: &mut [Rank<D>],
    work: impl Fn(&mut Rank<D>) -> Result<T, SolverError> + Send + Sync,
) -> Result<Vec<T>, SolverError> {
    // Of several errors, that of the first rank.
    ranks.par_iter_mut().map(work).collect::<Vec<_>>().into_iter().collect()
}

impl<const D: usize> RankedSolver<D> {
    /// Solver with the particles of `whole` distributed over `ranks` ranks.
    pub fn new(whole: SphSolver<D>, ranks: usize) -> Self {
        let mail = vec![vec![ParticleMessage::default(); ranks]; ranks];
        let mut solver = Self { ranks: Vec::new(), messages: mail, cuts: None, is_distributed: false };
        solver.move_to_first(whole);
        solver
    }

    /// Moves all particles to the first rank.
    fn move_to_first(&mut self, whole: SphSolver<D>) {
        let ranks = self.messages.len();
        let others: Vec<_> = (1..ranks).map(|_| whole.empty_like()).collect();
        let all = std::iter::once(whole).chain(others);
        self.ranks = all.map(|domain| Rank::new(domain, ranks)).collect();
        (self.cuts, self.is_distributed) = (None, false);
    }

    /// First rank, for data common to all ranks: time, stage, options.
    fn first(&self) -> &SphSolver<D> {
        &self.ranks[0].domain
    }

    /// Solver without ranks in the same state.
    fn gather(&self) -> SphSolver<D> {
        let of_rank = |rank: &Rank<D>| {
            let mut parcel = ParticleMessage::default();
            parcel.fill(&rank.domain, &rank.sequence, &rank.own_particles().collect::<Vec<_>>(), true);
            parcel
        };
        let parcels: Vec<ParticleMessage<D>> = self.ranks.iter().map(of_rank).collect();
        let mut whole = self.first().empty_like();
        whole.rates.reactions.clone_from(&self.first().rates.reactions);
        assemble(&mut whole, &parcels.iter().collect::<Vec<_>>());
        if self.first().lists.listed_positions.positions.is_empty() && !self.is_distributed {
            whole.lists.listed_positions.positions.clear();
        }
        whole
    }

    /// Critical time step, the smallest one of all ranks.
    fn critical_step(&mut self) -> TimeStep {
        let clock = &self.first().clock;
        if let Some(limit) = clock.limit.filter(|_| !clock.is_limit_due()) {
            return limit;
        }
        // Of equal steps, that of the first particle in the sequence.
        let of_rank = |rank: &mut Rank<D>| {
            let SphSolver { setting, bodies, rates, .. } = &mut rank.domain;
            let limit = critical_step(setting, bodies, rates);
            (limit.0, limit.2.map(|i| rank.sequence[i]), to_time_step(limit, &bodies.particles))
        };
        let found: Vec<_> = self.ranks.par_iter_mut().map(of_rank).collect();
        let smallest = found.into_iter().min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (.., smallest) = smallest.expect("at least one rank");
        let SphSolver { setting, clock, walls, .. } = self.first();
        let smallest =
            limit_by_obstacle_motion(smallest, &walls.obstacles, (clock.time, setting.options.spacing));
        let fixed = setting.options.time_step;
        let all = self.ranks.iter_mut().map(|rank| rank.domain.clock.set_limit(smallest, fixed));
        all.last().expect("at least one rank")
    }

    /// Advances the solver by one step.
    fn advance(&mut self, dt: f64) -> Result<(), SolverError> {
        if self.first().bodies.loads.body_force.is_some() {
            let of_rank = |rank: &mut Rank<D>| {
                let SphSolver { clock, bodies, .. } = &mut rank.domain;
                update_body_forces(clock, bodies)
            };
            on_all(&mut self.ranks, of_rank)?;
        }
        if self.first().clock.limit.is_none() {
            self.critical_step();
        }
        if self.is_distributed {
            self.exchange();
        }
        let support = self.refresh()?;
        let reactions = self.first().rates.reactions.clone();
        on_all(&mut self.ranks, |rank| {
            let SphSolver { setting, clock, bodies, walls, lists, .. } = &mut rank.domain;
            walls.obstacles.set_mean_velocity(clock.time + dt, dt);
            lists.place_images_and_walls(setting, clock, bodies, walls, support)?;
            rank.domain.advance_listed(dt)
        })?;
        let SphSolver { setting, clock, .. } = self.first();
        if setting.needs_equilibrium(clock) {
            self.sum_equilibrium(dt);
        }
        self.sum_obstacle_energies();
        self.sum_reactions(reactions, dt);
        self.ranks.iter_mut().for_each(|rank| rank.domain.clock.end_step(dt));
        Ok(())
    }

    /// Rebuilds the neighbour lists of all ranks if particles have moved too far. Returns the largest kernel support (m).
    fn refresh(&mut self) -> Result<f64, SolverError> {
        let of_rank = |rank: &mut Rank<D>| {
            let SphSolver { setting, clock, bodies, walls, lists, .. } = &mut rank.domain;
            bodies.follow_density(setting);
            Ok((
                bodies.max_smoothing_length(setting),
                lists.max_approach(setting, clock, &bodies.particles, walls),
            ))
        };
        let found = on_all(&mut self.ranks, of_rank)?;
        let (longest, reached) =
            found.into_iter().fold((0.0f64, 0.0f64), |(a, b), (c, d)| (a.max(c), b.max(d)));
        let SphSolver { setting, clock, lists, .. } = self.first();
        let support = setting.support(longest);
        if self.is_distributed && reached + support <= lists.listed_positions.list_radius {
            return Ok(support);
        }
        let is_sort_due = lists.is_sort_due(clock);
        self.ranks.par_iter_mut().for_each(|rank| {
            let SphSolver { bodies, walls, .. } = &mut rank.domain;
            let p = &mut bodies.particles;
            walls.planes.wrap_into_period(&mut p.position[..p.id.len()], &mut p.origin);
        });
        if is_sort_due {
            self.sort()?;
        }
        self.ranks.par_iter_mut().for_each(|rank| {
            let SphSolver { setting, clock, bodies, lists, rates, .. } = &mut rank.domain;
            lists.set_list_positions(setting, clock, &bodies.particles, support);
            rates.is_current = false;
        });
        self.distribute()?;
        Ok(support)
    }

    /// Sums the equilibrium terms over all particles in their sequence, for the first rank.
    fn sum_equilibrium(&mut self, dt: f64) {
        let of_rank = |rank: &'_ Rank<D>| -> Vec<(u32, EquilibriumTerms)> {
            let SphSolver { setting, clock, bodies, rates, .. } = &rank.domain;
            let own = equilibrium_terms(setting, clock, bodies, rates, dt);
            own.map(|(i, own)| (rank.sequence[i], own)).collect()
        };
        let mut found: Vec<(u32, EquilibriumTerms)> = self.ranks.par_iter().flat_map_iter(of_rank).collect();
        found.sort_unstable_by_key(|(place, _)| *place);
        let first = &mut self.ranks[0].domain;
        first.equilibrium_terms = first.equilibrium_terms.next_terms(found.into_iter().map(|(_, own)| own));
    }

    /// Sums the energies that obstacles remove over all particles in their original order.
    fn sum_obstacle_energies(&mut self) {
        if self.first().walls.obstacles.is_empty() {
            return;
        }
        let of_rank = |rank: &'_ Rank<D>| -> Vec<(u32, ObstacleEnergies)> {
            rank.own_particles()
                .map(|i| (rank.sequence[i as usize], rank.domain.rates.obstacle_energies[i as usize]))
                .collect()
        };
        let mut found: Vec<(u32, ObstacleEnergies)> = self.ranks.par_iter().flat_map_iter(of_rank).collect();
        found.sort_unstable_by_key(|(place, _)| *place);
        let first = &mut self.ranks[0].domain;
        found.iter().for_each(|(_, own)| first.obstacle_energies.add(own));
    }

    /// Sums the reactions of obstacles in a step of `dt` (s) over all particles in their original order, added to `reactions`. The sums of
    /// a single rank include ghosts.
    fn sum_reactions(&mut self, mut reactions: Vec<ReactionSum>, dt: f64) {
        let SphSolver { setting, walls, .. } = self.first();
        if walls.obstacles.recorded_obstacles().next().is_none() {
            return;
        }
        let bodies = setting.case.bodies.len();
        reactions.resize(bodies + setting.case.obstacles.len(), ReactionSum::default());
        let mut samples: Vec<(u32, ReactionSample<D>)> = Vec::new();
        for Rank { domain, sequence, .. } in &self.ranks {
            let is_guest = |i: u32| domain.bodies.ghost_particles.get(i as usize).is_some_and(|guest| *guest);
            let own = domain.rates.reaction_samples.iter().filter(|one| !is_guest(one.particle));
            samples.extend(own.map(|one| (sequence[one.particle as usize], *one)));
        }
        samples.sort_by_key(|(place, one)| (one.impulse.is_some(), *place));
        let (sums, stops) = samples.split_at(samples.partition_point(|(_, one)| one.impulse.is_none()));
        reactions[bodies..].iter_mut().for_each(ReactionSum::begin_step);
        sums.iter().for_each(|(_, one)| reactions[one.reaction_index as usize].accumulate(one));
        reactions[bodies..].iter_mut().for_each(|reactions| reactions.add_impulse(dt));
        stops.iter().for_each(|(_, one)| reactions[one.reaction_index as usize].accumulate(one));
        self.ranks[0].domain.rates.reactions = reactions;
    }

    /// Updates the copies in the halos.
    fn exchange(&mut self) {
        // Smoothed stresses are returned to yield, by the law and its state.
        let SphSolver { setting, clock, .. } = self.first();
        let whole = is_regularisation_due(setting, clock);
        self.ranks.par_iter().zip(&mut self.messages).for_each(|(rank, parcels)| {
            for (parcel, indices) in parcels.iter_mut().zip(&rank.sent_particles) {
                parcel.fill(&rank.domain, &rank.sequence, indices, whole);
            }
        });
        let mail = &self.messages;
        self.ranks.par_iter_mut().enumerate().for_each(|(to, rank)| {
            for (parcels, places) in mail.iter().zip(&rank.received_particles) {
                parcels[to].update_ghosts(&mut rank.domain, places);
            }
        });
    }

    /// Computes the sequence after a sort by cell. The first rank receives positions, and returns indices in the sequence.
    fn sort(&mut self) -> Result<(), SolverError> {
        let total: usize = self.ranks.iter().map(|rank| rank.own_particles().count()).sum();
        let mut positions = vec![[0.0; D]; total];
        for rank in &self.ranks {
            for i in rank.own_particles() {
                positions[rank.sequence[i as usize] as usize] =
                    rank.domain.bodies.particles.position[i as usize];
            }
        }
        let mut places = vec![0; total];
        let SphSolver { setting, clock, bodies, .. } = self.first();
        let (mut cells, radius) = (CellList::new(), setting.smoothing.radius());
        let mut start = 0;
        for number in 0..bodies.groups.len() {
            let own = |rank: &Rank<D>| {
                let range = rank.domain.bodies.groups[number].range();
                rank.own_particles().filter(|&i| range.contains(&(i as usize))).count()
            };
            let end = start + self.ranks.iter().map(own).sum::<usize>();
            cells.build(&positions[start..end], radius).map_err(|error| {
                bodies.particles.particle_error(clock, 0, format!("neighbour search: {error}"))
            })?;
            for (place, &old) in cells.order().iter().enumerate() {
                places[start + old as usize] = (start + place) as u32;
            }
            start = end;
        }
        for rank in &mut self.ranks {
            let own: Vec<u32> = rank.own_particles().collect();
            own.into_iter().for_each(|i| {
                let place = &mut rank.sequence[i as usize];
                *place = places[*place as usize];
            });
            rank.domain.lists.last_sort = Some(rank.domain.clock.step);
        }
        Ok(())
    }

    /// Moves particles to the ranks of their boxes and copies to the halos, and rebuilds the neighbour lists.
    fn distribute(&mut self) -> Result<(), SolverError> {
        let loads: Vec<u64> = self.ranks.iter().map(|rank| rank.weights().map(u64::from).sum()).collect();
        let largest = loads.iter().copied().max().unwrap_or(0) as f64;
        let mean = loads.iter().sum::<u64>() as f64 / loads.len() as f64;
        let cuts = match self.cuts.take() {
            Some(cuts) if largest <= IMBALANCE * mean => cuts,
            _ => self.new_bisection(),
        };
        self.migrate(&cuts);
        self.cuts = Some(cuts);
        self.fill_halos();
        on_all(&mut self.ranks, |rank| {
            let SphSolver { setting, clock, bodies, walls, lists, .. } = &mut rank.domain;
            lists.build(setting, clock, bodies, walls)
        })?;
        self.is_distributed = true;
        Ok(())
    }

    /// Computes a new partition. The first rank receives positions and weights, and returns the cuts.
    fn new_bisection(&self) -> Bisection<D> {
        let (mut positions, mut weights) = (Vec::new(), Vec::new());
        for rank in &self.ranks {
            positions.extend(
                rank.own_particles().map(|i| rank.domain.lists.listed_positions.positions[i as usize]),
            );
            weights.extend(rank.weights());
        }
        Bisection::new(&positions, &weights, self.ranks.len()).0
    }

    /// Sends the particles outside the box of each rank to the ranks to which they belong.
    fn migrate(&mut self, cuts: &Bisection<D>) {
        self.ranks.par_iter().zip(&mut self.messages).for_each(|(rank, parcels)| {
            let mut shares = vec![Vec::new(); parcels.len()];
            for i in rank.own_particles() {
                shares[cuts.owner(&rank.domain.lists.listed_positions.positions[i as usize]) as usize]
                    .push(i);
            }
            for (parcel, share) in parcels.iter_mut().zip(&shares) {
                parcel.fill(&rank.domain, &rank.sequence, share, true);
            }
        });
        let mail = &self.messages;
        self.ranks.par_iter_mut().enumerate().for_each(|(to, rank)| {
            let parcels: Vec<&ParticleMessage<D>> = mail.iter().map(|parcels| &parcels[to]).collect();
            (rank.sequence, _) = assemble(&mut rank.domain, &parcels);
            rank.domain.bodies.ghost_particles.clear();
        });
    }

    /// Sends copies of the particles of each rank to the halos of the other ranks.
    fn fill_halos(&mut self) {
        let boxes: Vec<Option<BoundingBox<D>>> = self
            .ranks
            .iter()
            .map(|rank| BoundingBox::enclosing(&rank.domain.lists.listed_positions.positions))
            .collect();
        let width = halo_passes(&self.first().setting.options) as f64
            * self.first().lists.listed_positions.list_radius;
        let send = |(me, (rank, parcels)): (usize, (&mut Rank<D>, &mut Vec<ParticleMessage<D>>))| {
            let (listed, mut images) = (&rank.domain.lists.listed_positions, Vec::new());
            rank.domain.walls.planes.move_to(listed.time);
            rank.domain.walls.planes.images(&listed.positions, width, &mut images);
            let wanted = |(to, bounds): (usize, &Option<BoundingBox<D>>)| match bounds {
                _ if to == me => rank.own_particles().collect(),
                Some(bounds) => rank.halo_of(bounds, width, &images),
                None => Vec::new(),
            };
            rank.sent_particles = boxes.iter().enumerate().map(wanted).collect();
            for (parcel, indices) in parcels.iter_mut().zip(&rank.sent_particles) {
                parcel.fill(&rank.domain, &rank.sequence, indices, true);
            }
        };
        self.ranks.par_iter_mut().zip(&mut self.messages).enumerate().for_each(send);
        let mail = &self.messages;
        self.ranks.par_iter_mut().enumerate().for_each(|(to, rank)| {
            let parcels: Vec<&ParticleMessage<D>> = mail.iter().map(|parcels| &parcels[to]).collect();
            (rank.sequence, rank.received_particles) = assemble(&mut rank.domain, &parcels);
            rank.domain.bodies.ghost_particles.clear();
            rank.domain.bodies.ghost_particles.resize(rank.sequence.len(), true);
            let own = std::mem::take(&mut rank.received_particles[to]);
            own.iter().for_each(|&i| rank.domain.bodies.ghost_particles[i as usize] = false);
            rank.sent_particles[to].clear();
            for indices in &mut rank.sent_particles {
                indices.iter_mut().for_each(|i| *i = own[*i as usize]);
            }
        });
    }
}
