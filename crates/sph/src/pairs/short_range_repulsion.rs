//! Repulsion of fluid particles that come closer than the pressure can prevent.
//!
//! The pressure force between two particles decreases as `F(r) r` with their distance `r`, to zero where they coincide. A particle of a
//! liquid and its own image in a smooth wall approach along one line and can't evade each other: they approach until they coincide in the
//! face. Pairs within [`RANGE`] spacings therefore have the potential energy `s μ c² (1 - r²/r_0²)²` beside that of the law, with
//! `μ = 2 m_i m_j/(m_i + m_j)`, the mean `c²` of both, the range `r_0` and `s`, the option `close_repulsion`. Its forces are central:
//! momentum, angular momentum and energy are conserved.

use std::ops::Range;

use colluvium_points::NeighbourList;

use crate::config::LagrangianFormulation;
use crate::context::SolverContext;
use crate::pairs::PairSums;
use crate::points::packed_particles::Lanes;
use crate::points::particles::{Bodies, ParticleGroup};
use crate::points::vector_algebra::separation;
use crate::walls::{ImageParticle, WallContact, Walls};

/// Range of the repulsion, in spacings. In an even liquid no pair is so close.
pub(crate) const RANGE: f64 = 0.7;

/// Short-range repulsion within the fluids of a case.
#[derive(Clone, Copy)]
pub(crate) struct ShortRangeRepulsion {
    /// Square of the range (m²).
    pub square: f64,
    strength: f64,
}

impl ShortRangeRepulsion {
    /// Returns the repulsion of `setting`; `None` where `groups` have no free fluid.
    pub(crate) fn of_groups<const D: usize>(
        setting: &SolverContext<D>,
        groups: &[ParticleGroup],
    ) -> Option<Self> {
        let strength = setting.options.close_repulsion;
        let reach = RANGE * setting.options.spacing;
        let updated = setting.options.formulation == LagrangianFormulation::Updated;
        (strength > 0.0 && updated && groups.iter().any(ParticleGroup::is_free_fluid))
            .then_some(Self { square: reach * reach, strength })
    }

    /// Repulsive acceleration over the distance vector (1/s²), negative, of a particle of mass `own` by one of mass `other` (kg). `square`
    /// is the squared distance (m²), `sound` the squared speed of sound (m²/s²).
    #[inline]
    fn acceleration_factor(self, square: f64, sound: f64, (own, other): (f64, f64)) -> f64 {
        let share = 2.0 * other / (own + other);
        -4.0 * self.strength * share * sound / self.square * (1.0 - square / self.square).max(0.0)
    }

    /// Energy of a pair (J).
    fn energy(self, square: f64, sound: f64, (own, other): (f64, f64)) -> f64 {
        let left = (1.0 - square / self.square).max(0.0);
        self.strength * 2.0 * own * other / (own + other) * sound * left * left
    }

    /// Largest stable step of two particles that oscillate under the repulsion (s), with a safety margin of a third; `sound` is the speed
    /// of sound (m/s). The stiffness of a pair is at most `8 s c²/r_0²` over the mass, and the reduced mass is half of it.
    pub(crate) fn stable_step(self, sound: f64) -> f64 {
        4.0 / 3.0 * (self.square / (16.0 * self.strength)).sqrt() / sound
    }
}

impl<const D: usize> PairSums<'_, D> {
    /// Whether particle `i` belongs to a fluid that moves by itself.
    fn is_free_fluid(&self, i: usize) -> bool {
        self.groups.iter().any(|group| group.is_free_fluid() && group.range().contains(&i))
    }

    /// Adds the repulsion on particle `i` by up to four neighbours that are too close, with their distance vectors (m).
    #[cold]
    pub(crate) fn add_repulsion(
        &self,
        i: usize,
        (close, four): (ShortRangeRepulsion, [usize; 4]),
        (apart, square): (&[Lanes; D], Lanes),
        sum: &mut [f64; D],
    ) {
        let p = self.particles;
        for (lane, (j, square)) in four.into_iter().zip(square.to_array()).enumerate() {
            let counts = j != i && j < self.first_wall_particle && square < close.square;
            if !(counts && self.is_free_fluid(i) && self.is_free_fluid(self.source(j))) {
                continue;
            }
            let sound = 0.5 * (p.sound[i] * p.sound[i] + p.sound[j] * p.sound[j]);
            let acceleration = close.acceleration_factor(square, sound, (p.mass[i], p.mass[j]));
            (0..D).for_each(|c| sum[c] += acceleration * apart[c].to_array()[lane]);
        }
    }

    /// Adds the repulsion on `i` by its image in smooth walls of particles.
    pub(crate) fn add_image_repulsion(&self, i: usize, close: ShortRangeRepulsion, sum: &mut [f64; D]) {
        let p = self.particles;
        for plane in self.walls.planes.faces.iter().filter(|plane| plane.contact == WallContact::FreeSlip) {
            let between = 2.0 * plane.distance(&p.position[i]);
            if between * between < close.square && self.is_free_fluid(i) {
                let acceleration = close.acceleration_factor(
                    between * between,
                    p.sound[i] * p.sound[i],
                    (p.mass[i], p.mass[i]),
                );
                sum[plane.axis] +=
                    if plane.is_upper { acceleration * between } else { -acceleration * between };
            }
        }
    }
}

/// Energy of the repulsion (J): half the energy of each pair with particles and images.
pub(crate) fn repulsion_energy<const D: usize>(
    setting: &SolverContext<D>,
    bodies: &Bodies<D>,
    walls: &Walls<D>,
    time: f64,
) -> f64 {
    let Some(close) = ShortRangeRepulsion::of_groups(setting, &bodies.groups) else { return 0.0 };
    let (p, reach) = (&bodies.particles, close.square.sqrt());
    let free: Vec<Range<usize>> =
        bodies.groups.iter().filter(|group| group.is_free_fluid()).map(ParticleGroup::range).collect();
    let numbers: Vec<usize> = free.into_iter().flatten().collect();
    let mut positions: Vec<[f64; D]> = numbers.iter().map(|&i| p.position[i]).collect();
    let (mut planes, mut images) = (walls.planes.clone(), Vec::<ImageParticle<D>>::new());
    planes.move_to(time);
    planes.images(&positions, reach, &mut images);
    for image in &images {
        let x = positions[image.source as usize];
        positions.push(std::array::from_fn(|c| image.axis_sign[c] * x[c] + image.shift[c]));
    }
    let mut near = NeighbourList::new();
    let keeps = |k: u32, other: u32| {
        let [k, other] = [k, other].map(|number| number as usize);
        let own = (numbers.get(other).copied(), &positions[other]);
        !walls.obstacles.separates((numbers[k], &positions[k]), own, setting.options.spacing)
    };
    if near.build_first(&positions, numbers.len(), reach, keeps).is_err() {
        return f64::NAN;
    }
    let source = |k: usize| k.checked_sub(numbers.len()).map_or(k, |image| images[image].source as usize);
    let mut sum = 0.0;
    for (k, &i) in numbers.iter().enumerate() {
        let own = p.sound[i] * p.sound[i];
        for &other in near.neighbours(k) {
            let (j, (_, square)) =
                (numbers[source(other as usize)], separation(&positions[k], &positions[other as usize]));
            let sound = 0.5 * (own + p.sound[j] * p.sound[j]);
            sum += 0.5 * close.energy(square, sound, (p.mass[i], p.mass[j]));
        }
        for plane in planes.faces.iter().filter(|plane| plane.contact == WallContact::FreeSlip) {
            let between = 2.0 * plane.distance(&p.position[i]);
            sum += 0.5 * close.energy(between * between, own, (p.mass[i], p.mass[i]));
        }
    }
    sum
}
