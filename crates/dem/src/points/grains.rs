//! Grains, one column per quantity.

use colluvium_points::struct_of_arrays;

use crate::points::vector::add;

/// Smallest number of grains of a parallel task.
pub const MIN_GRAINS_PER_TASK: usize = 1024;

struct_of_arrays! {
    /// Grains in `D` dimensions with rotations of `R` components.
    pub struct Grains<const D: usize, const R: usize> {
        /// Id of the grain, constant during the run.
        pub id: u32,
        /// Index into the bodies of the case.
        pub body: u32,
        /// Index into the kinds.
        pub kind: u32,
        /// Whether only the prescribed motion of its body moves the grain.
        pub is_held: bool,
        /// Radius (m).
        pub radius: f64,
        /// Mass (kg; per metre in the plane).
        pub mass: f64,
        /// Position of the centre (m).
        pub position: [f64; D],
        /// Position minus displacement (m): the initial position, displaced at periodic boundaries.
        pub origin: [f64; D],
        /// Position at the last list build (m).
        pub listed_position: [f64; D],
        /// Velocity, half a step ahead (m/s).
        pub velocity: [f64; D],
        /// Angular velocity, half a step ahead (rad/s).
        pub spin: [f64; R],
        /// Contact force of the last step (N).
        pub force: [f64; D],
        /// Contact moment of the last step (N m).
        pub torque: [f64; R],
        /// Rotation since the start as an angle (rad) or a quaternion; empty unless the case requests it.
        pub orientation: [f64; 4],
        /// Body force of a program at the start of the last step (N); empty without one.
        pub body_force: [f64; D],
    }
}

/// View of the grain columns that contact forces need; see [`Grains`].
#[derive(Clone, Copy)]
pub struct GrainView<'a, const D: usize, const R: usize> {
    /// Index of the kind of each grain.
    pub kind: &'a [u32],
    /// Whether each grain has a prescribed motion.
    pub is_held: &'a [bool],
    /// Radii (m).
    pub radius: &'a [f64],
    /// Masses (kg).
    pub mass: &'a [f64],
    /// Positions (m).
    pub position: &'a [[f64; D]],
    /// Velocities (m/s).
    pub velocity: &'a [[f64; D]],
    /// Angular velocities (rad/s).
    pub spin: &'a [[f64; R]],
}

/// Contact forces (N) and moments (N m) of the grains.
pub type GrainForces<'a, const D: usize, const R: usize> = (&'a mut [[f64; D]], &'a mut [[f64; R]]);

/// Moment of inertia over mass times square of the radius.
pub const fn inertia(dimension: usize) -> f64 {
    if dimension == 2 { 0.5 } else { 0.4 }
}

/// Area of a disk or volume of a sphere (m², m³).
pub fn volume(dimension: usize, radius: f64) -> f64 {
    let square = std::f64::consts::PI * radius * radius;
    if dimension == 2 { square } else { 4.0 / 3.0 * square * radius }
}

impl<const D: usize, const R: usize> Grains<D, R> {
    /// Adds a grain at rest without rotation.
    pub fn push(&mut self, body: u32, kind: u32, position: [f64; D], radius: f64, density: f64) {
        self.id.push(self.id.len() as u32);
        self.body.push(body);
        self.kind.push(kind);
        self.is_held.push(false);
        self.radius.push(radius);
        self.mass.push(density * volume(D, radius));
        for column in [&mut self.position, &mut self.origin, &mut self.listed_position] {
            column.push(position);
        }
        self.velocity.push([0.0; D]);
        self.spin.push([0.0; R]);
        self.force.push([0.0; D]);
        self.torque.push([0.0; R]);
        if !self.body_force.is_empty() {
            self.body_force.push([0.0; D]);
        }
    }

    /// View of the columns for the contact forces.
    pub fn view(&self) -> GrainView<'_, D, R> {
        let Self { kind, is_held, radius, mass, position, velocity, spin, .. } = self;
        GrainView { kind, is_held, radius, mass, position, velocity, spin }
    }

    /// View of the columns for the contact forces, and the forces that they update.
    pub fn view_and_forces(&mut self) -> (GrainView<'_, D, R>, GrainForces<'_, D, R>) {
        let Self { kind, is_held, radius, mass, position, velocity, spin, force, torque, .. } = self;
        (GrainView { kind, is_held, radius, mass, position, velocity, spin }, (force, torque))
    }

    /// Moment of inertia (kg m²).
    #[inline]
    pub fn inertia(&self, i: usize) -> f64 {
        inertia(D) * self.mass[i] * self.radius[i] * self.radius[i]
    }

    /// Mean mass (kg) and diameter (m).
    pub fn mean_mass_and_diameter(&self) -> (f64, f64) {
        let count = self.len() as f64;
        let mass: f64 = self.mass.iter().sum();
        (mass / count, 2.0 * self.radius.iter().sum::<f64>() / count)
    }

    /// Centre of mass of the selected grains (m); `None` without grains.
    pub fn centre_of_mass(&self, holds: impl Fn(usize) -> bool) -> Option<[f64; D]> {
        let (mut mass, mut moment) = (0.0, [0.0; D]);
        for i in (0..self.len()).filter(|&i| holds(i)) {
            mass += self.mass[i];
            add(&mut moment, self.mass[i], &self.position[i]);
        }
        (mass > 0.0).then(|| moment.map(|c| c / mass))
    }

    /// Smallest and largest radius (m).
    pub fn radii(&self) -> (f64, f64) {
        self.radius.iter().fold((f64::INFINITY, 0.0f64), |(low, high), r| (low.min(*r), high.max(*r)))
    }
}
