//! The particles, as a structure of arrays.

use std::sync::Arc;

use colluvium_case::description::Velocity;
use colluvium_case::law::LawPoints;
use colluvium_constitutive::{Material, States, SymTensor};

use crate::config::History;
use crate::lanes::{Record, record};
use crate::walls::{Image, Walls};

/// A matrix of the space.
pub type Matrix<const D: usize> = [[f64; D]; D];

/// Particles of one body: a range of the arrays and what its law keeps.
pub struct Group {
    /// Index into `Case::bodies`.
    pub body: u32,
    /// First particle.
    pub start: usize,
    /// One past the last.
    pub end: usize,
    /// The law.
    pub material: Arc<dyn Material>,
    /// States of the law.
    pub states: States,
    /// Young's modulus (Pa), where the speed of sound is taken from it.
    pub youngs_modulus: Option<f64>,
    /// Initial density (kg/m³).
    pub density: f64,
    /// The velocities it keeps, where it is held.
    pub held: Option<Velocity>,
    /// The factor on these velocities over time; one without.
    pub history: Option<History>,
    /// Its mean over the step.
    pub factor: f64,
    /// Whether others slip along it; only what is held may be smooth.
    pub smooth: bool,
    /// Whether a confining pressure acts on it.
    pub confined: bool,
    /// Whether its law is one of fluids.
    pub fluid: bool,
}

impl Group {
    /// The range in the arrays.
    pub fn range(&self) -> std::ops::Range<usize> {
        self.start..self.end
    }

    /// The same body without particles.
    pub fn hollow(&self) -> Self {
        Self {
            start: 0,
            end: 0,
            material: Arc::clone(&self.material),
            states: States::default(),
            held: self.held.clone(),
            history: self.history.clone(),
            ..*self
        }
    }
}

/// All particles. The arrays of what acts on neighbours go on behind the `len` particles with their images and the
/// particles of walls; the others have one entry per particle.
#[derive(Clone, Default)]
pub struct Particles<const D: usize> {
    /// Number of particles.
    pub len: usize,
    /// Ids, the same for life.
    pub id: Vec<u32>,
    /// Positions from which displacement is counted (m).
    pub origin: Vec<[f64; D]>,
    /// Accelerations of the last step (m/s²).
    pub acceleration: Vec<[f64; D]>,
    /// Velocity gradients of the last step (1/s).
    pub gradient: Vec<Matrix<D>>,
    /// Divergences of velocity of the last step, from the continuity equation (1/s).
    pub divergence: Vec<f64>,
    /// Velocity by which a particle moves beyond its own, by XSPH (m/s); empty without.
    pub drift: Vec<[f64; D]>,
    /// Velocities of the step before, of the scheme that needs them (m/s); empty without.
    pub previous: Vec<[f64; D]>,
    /// Positions (m); with images and walls.
    pub position: Vec<[f64; D]>,
    /// Velocities (m/s); with images and walls.
    pub velocity: Vec<[f64; D]>,
    /// Masses (kg); with images and walls.
    pub mass: Vec<f64>,
    /// Densities (kg/m³); with images and walls.
    pub density: Vec<f64>,
    /// Cauchy stresses (Pa); with images and walls.
    pub stress: Vec<SymTensor>,
    /// Speeds of sound (m/s); with images and walls.
    pub sound: Vec<f64>,
    /// Smoothing lengths (m); with images and walls.
    pub length: Vec<f64>,
    /// `1/ϑ` of the gradient of the smoothing length; one without; with images and walls.
    pub spread: Vec<f64>,
    /// What the pair sums read; with images and walls.
    pub records: Vec<Record>,
    /// Artificial stress over density squared; with images and walls; empty without.
    pub repulsion: Vec<SymTensor>,
    /// Corrections of the gradient; with images; empty where the momentum equation does without.
    pub correction: Vec<Matrix<D>>,
    order: Order<D>,
}

/// Buffers of a permutation.
#[derive(Clone, Default)]
struct Order<const D: usize> {
    scalars: Vec<f64>,
    vectors: Vec<[f64; D]>,
    tensors: Vec<SymTensor>,
    matrices: Vec<Matrix<D>>,
    ids: Vec<u32>,
}

fn permute<T: Copy>(values: &mut [T], order: &[u32], old: &mut Vec<T>) {
    old.clear();
    old.extend_from_slice(values);
    values.iter_mut().zip(order).for_each(|(value, &from)| *value = old[from as usize]);
}

impl<const D: usize> Particles<D> {
    /// The particles of a body as their law sees them.
    pub fn law_points<'a>(&'a self, group: &'a Group) -> LawPoints<'a> {
        LawPoints { material: &*group.material, stress: &self.stress[group.range()], states: &group.states }
    }

    /// What has one vector per particle: origin, acceleration, position, velocity.
    pub fn vectors(&self) -> [&Vec<[f64; D]>; 4] {
        [&self.origin, &self.acceleration, &self.position, &self.velocity]
    }

    /// The same, to change.
    pub fn vectors_mut(&mut self) -> [&mut Vec<[f64; D]>; 4] {
        [&mut self.origin, &mut self.acceleration, &mut self.position, &mut self.velocity]
    }

    /// What has one number per particle: mass, density, speed of sound, smoothing length.
    pub fn scalars(&self) -> [&Vec<f64>; 4] {
        [&self.mass, &self.density, &self.sound, &self.length]
    }

    /// The same, to change.
    pub fn scalars_mut(&mut self) -> [&mut Vec<f64>; 4] {
        [&mut self.mass, &mut self.density, &mut self.sound, &mut self.length]
    }

    /// Puts the particles of `range` in a new order.
    pub fn permute(&mut self, range: std::ops::Range<usize>, order: &[u32]) {
        let mut old = std::mem::take(&mut self.order);
        permute(&mut self.id[range.clone()], order, &mut old.ids);
        for vectors in self.vectors_mut() {
            permute(&mut vectors[range.clone()], order, &mut old.vectors);
        }
        if !self.previous.is_empty() {
            permute(&mut self.previous[range.clone()], order, &mut old.vectors);
        }
        for scalars in self.scalars_mut() {
            permute(&mut scalars[range.clone()], order, &mut old.scalars);
        }
        permute(&mut self.stress[range.clone()], order, &mut old.tensors);
        // Rates of the step before, which one of the schemes predicts from.
        permute(&mut self.gradient[range.clone()], order, &mut old.matrices);
        permute(&mut self.divergence[range], order, &mut old.scalars);
        self.order = old;
    }

    /// Makes room for so many particles, images and walls; what is new is zero.
    pub fn resize(&mut self, total: usize) {
        self.acceleration.resize(self.len, [0.0; D]);
        self.gradient.resize(self.len, [[0.0; D]; D]);
        self.divergence.resize(self.len, 0.0);
        self.position.resize(total, [0.0; D]);
        self.velocity.resize(total, [0.0; D]);
        self.mass.resize(total, 0.0);
        self.density.resize(total, 0.0);
        self.stress.resize(total, SymTensor::ZERO);
        self.sound.resize(total, 0.0);
        self.length.resize(total, 0.0);
        self.spread.resize(total, 1.0);
        self.records.resize(total, [[0.0; 4]; 4]);
    }

    /// Removes the particles of `range`, which must be followed by neither images nor walls.
    pub fn remove(&mut self, range: std::ops::Range<usize>) {
        self.resize(self.len);
        self.id.drain(range.clone());
        for vectors in self.vectors_mut() {
            vectors.drain(range.clone());
        }
        if !self.previous.is_empty() {
            self.previous.drain(range.clone());
        }
        for scalars in self.scalars_mut() {
            scalars.drain(range.clone());
        }
        // Rates of the step before, as in a permutation.
        self.gradient.drain(range.clone());
        self.divergence.drain(range.clone());
        self.stress.drain(range);
        self.len = self.id.len();
        self.resize(self.len);
    }

    /// Places of the images, and of the particles of walls.
    pub fn place(&mut self, images: &[Image<D>], walls: &Walls<D>) {
        for (image, slot) in images.iter().zip(self.len..) {
            let x = self.position[image.source as usize];
            self.position[slot] = std::array::from_fn(|c| image.flip[c] * x[c] + image.shift[c]);
        }
        walls.place(&mut self.position[self.len + images.len()..]);
    }

    /// Velocities of the images.
    pub fn move_images(&mut self, images: &[Image<D>]) {
        for (image, slot) in images.iter().zip(self.len..) {
            let v = self.velocity[image.source as usize];
            self.velocity[slot] = std::array::from_fn(|c| image.turn[c] * v[c] + image.lift[c]);
            crate::lanes::set_velocity(&mut self.records[slot], &self.velocity[slot]);
        }
    }

    /// Everything else of the images.
    pub fn load_images(&mut self, images: &[Image<D>]) {
        for (image, slot) in images.iter().zip(self.len..) {
            let source = image.source as usize;
            self.mass[slot] = self.mass[source];
            self.density[slot] = self.density[source];
            self.sound[slot] = self.sound[source];
            self.length[slot] = self.length[source];
            self.spread[slot] = self.spread[source];
            self.stress[slot] = mirrored(&self.stress[source], &image.bend);
            if !self.repulsion.is_empty() {
                self.repulsion[slot] = mirrored(&self.repulsion[source], &image.bend);
            }
        }
    }

    /// The record of particle `i`, its stress times `scale`.
    #[inline]
    pub fn record(&self, i: usize, scale: f64) -> Record {
        let scalars = [self.mass[i] / self.density[i], self.density[i], self.sound[i], self.length[i]];
        record(&self.position[i], &self.velocity[i], scalars, (self.stress[i] * scale).0)
    }
}

/// `H σ H` with `H = diag flip`.
#[inline]
pub fn mirrored<const D: usize>(stress: &SymTensor, flip: &[f64; D]) -> SymTensor {
    let sign = |c: usize| if c < D { flip[c] } else { 1.0 };
    let [xx, yy, zz, xy, yz, zx] = stress.0;
    let (x, y, z) = (sign(0), sign(1), sign(2));
    SymTensor([xx, yy, zz, x * y * xy, y * z * yz, z * x * zx])
}
