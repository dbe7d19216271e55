//! Coarse graining of grains to continuum fields (Goldhirsch; sheet: dem §3.9): density, velocity, kinetic and contact
//! stress at the nodes of a lattice, for any state of a run.
//!
//! Each grain is smoothed by a kernel of the given width, each contact along the line between the two centres. Therefore density
//! integrates to the mass, momentum to the momentum and contact stress to `-Σ F ⊗ l`, whatever the width, which only sets
//! the resolution of the fields. Below two mean diameters they show single grains. Contacts with walls are smoothed from the
//! contact point on the wall to the centre.

use colluvium_case::{Dataset, DatasetGeometry, Field, FieldData, Lattice, spatial};
use colluvium_constitutive::SymTensor;

use crate::boundary::periodic_cell::PeriodicCell;
use crate::contact::Contact;
use crate::output::packing_view::PackingView;
use crate::points::vector::{difference, dot};

/// Points and weights of Gauss–Legendre quadrature along a branch, on 0 to 1.
const GAUSS_RULE: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_5),
    (0.230_765_344_947_158_5, 0.239_314_335_249_683_2),
    (0.5, 0.284_444_444_444_444_4),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_2),
    (0.953_089_922_969_332, 0.118_463_442_528_094_5),
];

/// Nodes at equal distances along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoarseGrainingNodes<const D: usize> {
    /// The first node (m).
    pub origin: [f64; D],
    /// Spacing of the nodes (m).
    pub spacing: f64,
    /// Number of nodes along each axis; the first axis runs fastest.
    pub count: [usize; D],
}

/// Coarse-grained fields at a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoarseFields<const D: usize> {
    /// Mass over volume (kg/m³); in the plane for a thickness of 1 m.
    pub density: f64,
    /// Momentum over mass (m/s); zero without grains in range.
    pub velocity: [f64; D],
    /// Kinetic stress of the velocity fluctuations, `-Σ m v' ⊗ v' W` (Pa, tension-positive).
    pub kinetic: SymTensor,
    /// Symmetric part of the contact stress, `-Σ F ⊗ l ∫ W` (Pa, tension-positive).
    pub contact: SymTensor,
}

impl<const D: usize> CoarseFields<D> {
    /// Fields without grains.
    const EMPTY: Self =
        Self { density: 0.0, velocity: [0.0; D], kinetic: SymTensor::ZERO, contact: SymTensor::ZERO };
}

/// Lucy kernel, `c (1 + 3 q) (1 - q)³` with `q` the distance over the width.
#[derive(Clone, Copy, Debug)]
struct CoarseGrainingKernel<const D: usize> {
    width: f64,
    scale: f64,
}

impl<const D: usize> CoarseGrainingKernel<D> {
    /// Kernel of radius `width` (m) with an integral of one.
    fn new(width: f64) -> Self {
        let pi = std::f64::consts::PI;
        let scale = if D == 2 { 5.0 / (pi * width * width) } else { 105.0 / (16.0 * pi * width.powi(3)) };
        Self { width, scale }
    }

    /// Value of the kernel (1/m³, in the plane 1/m²) at a distance vector (m).
    fn value(&self, apart: &[f64; D]) -> f64 {
        let q = dot(apart, apart).sqrt() / self.width;
        if q < 1.0 { self.scale * (1.0 + 3.0 * q) * (1.0 - q).powi(3) } else { 0.0 }
    }
}

impl<const D: usize> CoarseGrainingNodes<D> {
    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.count.iter().product()
    }

    /// Whether there are no nodes.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Position of node number `index` (m).
    pub fn node_position(&self, index: usize) -> [f64; D] {
        let mut rest = index;
        std::array::from_fn(|c| {
            let k = rest % self.count[c];
            rest /= self.count[c];
            self.origin[c] + self.spacing * k as f64
        })
    }

    /// Calls `visit(node, W)` for the nodes within the width of the kernel around `x`.
    fn for_each_node_around(
        &self,
        kernel: &CoarseGrainingKernel<D>,
        x: &[f64; D],
        mut visit: impl FnMut(usize, f64),
    ) {
        let mut first = [0usize; D];
        let mut number = [0usize; D];
        for c in 0..D {
            let low = ((x[c] - kernel.width - self.origin[c]) / self.spacing).ceil().max(0.0);
            let high = ((x[c] + kernel.width - self.origin[c]) / self.spacing).floor();
            let high = high.min(self.count[c] as f64 - 1.0);
            if high < low {
                return;
            }
            (first[c], number[c]) = (low as usize, (high - low) as usize + 1);
        }
        for k in 0..number.iter().product() {
            let (mut rest, mut node, mut stride) = (k, 0, 1);
            for c in 0..D {
                node += stride * (first[c] + rest % number[c]);
                rest /= number[c];
                stride *= self.count[c];
            }
            let weight = kernel.value(&difference(&self.node_position(node), x));
            if weight > 0.0 {
                visit(node, weight);
            }
        }
    }
}

/// Symmetric part of `a ⊗ b`.
fn outer<const D: usize>(a: &[f64; D], b: &[f64; D]) -> SymTensor {
    let at = |v: &[f64; D], c: usize| v.get(c).copied().unwrap_or(0.0);
    let entry = |i: usize, j: usize| 0.5 * (at(a, i) * at(b, j) + at(a, j) * at(b, i));
    SymTensor([entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(1, 2), entry(2, 0)])
}

/// Shifts (m) of the images of a periodic cell, the cell itself included, and their velocities (m/s).
fn images<const D: usize>(cell: &PeriodicCell<D>) -> Vec<([f64; D], [f64; D])> {
    let mut all = Vec::new();
    cell.shifts(&mut all);
    let allowed = |code: usize| {
        let steps = PeriodicCell::<D>::image_steps(code as u8);
        steps.iter().zip(&cell.periodic).all(|(step, periodic)| *step == 0 || *periodic)
    };
    all.into_iter().enumerate().filter(|(code, _)| allowed(*code)).map(|(_, shift)| shift).collect()
}

impl<const D: usize, const R: usize> PackingView<'_, D, R> {
    /// Continuum fields of the grains at `nodes`, by a Lucy kernel of radius `width` (m), periodic images included. Velocities are those
    /// half a step before the positions, as stored.
    pub fn coarse_grained(&self, nodes: &CoarseGrainingNodes<D>, width: f64) -> Vec<CoarseFields<D>> {
        let kernel = CoarseGrainingKernel::<D>::new(width);
        let images = images(&self.cell.geometry);
        let mut fields = vec![CoarseFields::EMPTY; nodes.len()];
        let g = &self.grains;
        let spread = |x: &[f64; D], visit: &mut dyn FnMut(usize, f64, &[f64; D])| {
            for (shift, lift) in &images {
                let image = std::array::from_fn(|c| x[c] + shift[c]);
                nodes.for_each_node_around(&kernel, &image, |node, weight| visit(node, weight, lift));
            }
        };
        for i in 0..g.len() {
            spread(&g.position[i], &mut |node, weight, lift| {
                let field = &mut fields[node];
                field.density += g.mass[i] * weight;
                for c in 0..D {
                    field.velocity[c] += g.mass[i] * (g.velocity[i][c] + lift[c]) * weight;
                }
            });
        }
        for field in fields.iter_mut().filter(|field| field.density > 0.0) {
            field.velocity = field.velocity.map(|momentum| momentum / field.density);
        }
        for i in 0..g.len() {
            spread(&g.position[i], &mut |node, weight, lift| {
                let mean = fields[node].velocity;
                let own: [f64; D] = std::array::from_fn(|c| g.velocity[i][c] + lift[c] - mean[c]);
                fields[node].kinetic -= outer(&own, &own) * (g.mass[i] * weight);
            });
        }
        for Contact { grain, branch, force, .. } in self.contacts() {
            let stress = outer(&force, &branch);
            for (along, share) in GAUSS_RULE {
                let x: [f64; D] = std::array::from_fn(|c| g.position[grain][c] - along * branch[c]);
                spread(&x, &mut |node, weight, _| fields[node].contact -= stress * (share * weight));
            }
        }
        fields
    }
}

impl<const D: usize, const R: usize> PackingView<'_, D, R> {
    /// Coarse-grained fields at the nodes of `output.grid`.
    pub(crate) fn coarse_grained_dataset(&self, lattice: Lattice) -> Dataset {
        let nodes = CoarseGrainingNodes {
            origin: std::array::from_fn(|c| lattice.low[c]),
            spacing: lattice.spacing,
            count: std::array::from_fn(|c| lattice.count[c]),
        };
        let mean = 2.0 * self.grains.radius.iter().sum::<f64>() / self.grains.len().max(1) as f64;
        let width = self.clock.options.coarse_graining * mean;
        let fields = if mean > 0.0 {
            self.coarse_grained(&nodes, width)
        } else {
            vec![CoarseFields::EMPTY; nodes.len()]
        };
        let tensor =
            |of: fn(&CoarseFields<D>) -> SymTensor| FieldData::Tensor(fields.iter().map(of).collect());
        let field = |name: &str, unit, data| Field { name: name.to_owned(), unit, data };
        let fields = vec![
            field("density", "kg/m3", FieldData::Scalar(fields.iter().map(|own| own.density).collect())),
            field(
                "velocity",
                "m/s",
                FieldData::Vector(fields.iter().map(|own| spatial(&own.velocity)).collect()),
            ),
            field("stress", "Pa", tensor(|own| own.contact + own.kinetic)),
            field("kinetic_stress", "Pa", tensor(|own| own.kinetic)),
        ];
        let support = DatasetGeometry::Lattice { nodes: lattice, mask: Vec::new() };
        Dataset { name: Dataset::GRID.to_owned(), geometry: support, fields }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernel_integrates_to_one() {
        let nodes = CoarseGrainingNodes::<2> { origin: [-1.0; 2], spacing: 0.02, count: [101; 2] };
        let mut sum = 0.0;
        nodes.for_each_node_around(&CoarseGrainingKernel::new(0.7), &[0.013, -0.04], |_, weight| {
            sum += weight * 4e-4;
        });
        assert!((sum - 1.0).abs() < 1e-4, "{sum}");
        let nodes = CoarseGrainingNodes::<3> { origin: [-1.0; 3], spacing: 0.04, count: [51; 3] };
        let mut sum = 0.0;
        nodes.for_each_node_around(&CoarseGrainingKernel::new(0.7), &[0.013, -0.04, 0.02], |_, weight| {
            sum += weight * 6.4e-5;
        });
        assert!((sum - 1.0).abs() < 1e-3, "{sum}");
        assert!((GAUSS_RULE.iter().map(|(_, share)| share).sum::<f64>() - 1.0).abs() < 1e-15);
    }
}
