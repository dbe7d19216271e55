//! The particles, as a structure of arrays.

use std::sync::Arc;

use colluvium_constitutive::{Material, States, SymTensor};

use crate::walls::Image;

/// A matrix of the space.
pub type Matrix<const D: usize> = [[f64; D]; D];

/// The in-plane (or whole) part of a tensor.
#[inline]
pub fn in_space<const D: usize>(tensor: &SymTensor) -> Matrix<D> {
    std::array::from_fn(|a| std::array::from_fn(|b| tensor.at(a, b)))
}

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
}

impl Group {
    /// The range in the arrays.
    pub fn range(&self) -> std::ops::Range<usize> {
        self.start..self.end
    }
}

/// All particles. The arrays of what acts on neighbours go on behind the `len` particles with their mirror
/// images and the particles of rough walls; the others have one entry per particle.
#[derive(Default)]
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
    /// Positions (m); with images and walls.
    pub position: Vec<[f64; D]>,
    /// Velocities, half a step behind the positions (m/s); with images and walls.
    pub velocity: Vec<[f64; D]>,
    /// Masses (kg); with images and walls.
    pub mass: Vec<f64>,
    /// Densities (kg/m³); with images and walls.
    pub density: Vec<f64>,
    /// Cauchy stresses (Pa); with images and walls.
    pub stress: Vec<SymTensor>,
    /// Speeds of sound (m/s); with images and walls.
    pub sound: Vec<f64>,
    /// What a particle adds to the pair's stress: `σ/ρ²` or `σ/ρ`; with images and walls.
    pub flux: Vec<Matrix<D>>,
    /// Artificial stress over density squared; with images and walls.
    pub repulsion: Vec<Matrix<D>>,
}

fn permute<T: Copy>(values: &mut [T], order: &[u32]) {
    let old = values.to_vec();
    values.iter_mut().zip(order).for_each(|(value, &from)| *value = old[from as usize]);
}

impl<const D: usize> Particles<D> {
    /// Puts the particles of `range` in a new order.
    pub fn permute(&mut self, range: std::ops::Range<usize>, order: &[u32]) {
        permute(&mut self.id[range.clone()], order);
        permute(&mut self.origin[range.clone()], order);
        permute(&mut self.acceleration[range.clone()], order);
        permute(&mut self.position[range.clone()], order);
        permute(&mut self.velocity[range.clone()], order);
        permute(&mut self.mass[range.clone()], order);
        permute(&mut self.density[range.clone()], order);
        permute(&mut self.stress[range.clone()], order);
        permute(&mut self.sound[range], order);
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
        self.flux.resize(total, [[0.0; D]; D]);
        self.repulsion.resize(total, [[0.0; D]; D]);
    }

    /// Removes the particles of `range`, which must be followed by neither images nor walls.
    pub fn remove(&mut self, range: std::ops::Range<usize>) {
        self.resize(self.len);
        self.id.drain(range.clone());
        self.origin.drain(range.clone());
        self.acceleration.drain(range.clone());
        self.position.drain(range.clone());
        self.velocity.drain(range.clone());
        self.mass.drain(range.clone());
        self.density.drain(range.clone());
        self.stress.drain(range.clone());
        self.sound.drain(range);
        self.len = self.id.len();
        self.gradient.clear();
        self.divergence.clear();
        self.resize(self.len);
    }

    /// Places of the images.
    pub fn place_images(&mut self, images: &[Image<D>]) {
        for (image, slot) in images.iter().zip(self.len..) {
            let x = self.position[image.source as usize];
            self.position[slot] = std::array::from_fn(|c| image.flip[c] * x[c] + image.shift[c]);
        }
    }

    /// Velocities of the images.
    pub fn move_images(&mut self, images: &[Image<D>]) {
        for (image, slot) in images.iter().zip(self.len..) {
            let v = self.velocity[image.source as usize];
            self.velocity[slot] = std::array::from_fn(|c| image.flip[c] * v[c]);
        }
    }

    /// Everything else of the images.
    pub fn load_images(&mut self, images: &[Image<D>]) {
        let mirrored = |matrix: &Matrix<D>, flip: &[f64; D]| -> Matrix<D> {
            std::array::from_fn(|a| std::array::from_fn(|b| flip[a] * flip[b] * matrix[a][b]))
        };
        for (image, slot) in images.iter().zip(self.len..) {
            let source = image.source as usize;
            self.mass[slot] = self.mass[source];
            self.density[slot] = self.density[source];
            self.sound[slot] = self.sound[source];
            self.flux[slot] = mirrored(&self.flux[source], &image.flip);
            self.repulsion[slot] = mirrored(&self.repulsion[source], &image.flip);
        }
    }
}
