//! Fabric and forces of contacts: coordination, rattlers, fabric tensor, contact rose (sheet: dem §3.9).
//!
//! The measures are of contacts between grains; contacts with walls only count in the search for rattlers.

use colluvium_case::measure::ScalarOutput;
use colluvium_case::solver::{FramePoints, PolygonMesh};
use colluvium_case::{Dataset, DatasetGeometry, Field, FieldData, spatial};
use colluvium_constitutive::SymTensor;

use crate::contact::{Contact, FabricSample};
use crate::output::packing_view::PackingView;
use crate::points::vector::{difference, dot, norm, scaled};

/// Averages over the contacts between grains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fabric<const D: usize> {
    /// Number of contacts between grains.
    pub contacts: usize,
    /// Coordination number `Z = 2 N_c / N`, over all grains without prescribed motion.
    pub coordination: f64,
    /// Mechanical coordination number, without rattlers and their contacts.
    pub mechanical_coordination: f64,
    /// Fraction of rattlers: grains with at most one contact, counted repeatedly without contacts to other rattlers.
    pub rattlers: f64,
    /// Fabric tensor `G = Σ n ⊗ n / N_c`, of trace 1.
    pub tensor: [[f64; D]; D],
    /// Norm of `4 (G - 1/2)` in the plane, of `15/2 (G - 1/3)` in space: 0 for contacts that are equally distributed over directions.
    pub anisotropy: f64,
    /// Alignment `A = n_F : n_s` of the unit deviators of fabric and compressive stress, 1 for equal directions. In the plane it is the
    /// cosine of twice the angle between them. Not-a-number if a deviator is zero.
    pub alignment: f64,
    /// Mean normal force (N).
    pub mean_force: f64,
    /// Fraction of the contacts whose normal force is below the mean.
    pub weak_fraction: f64,
}

/// Rattlers among `count` grains with given contacts, in which `None` is a wall.
fn rattlers(count: usize, pairs: &[(u32, Option<u32>)]) -> Vec<bool> {
    let mut out = vec![false; count];
    let mut left = vec![0usize; count];
    loop {
        left.fill(0);
        for (i, j) in pairs.iter().map(|(i, j)| (*i as usize, j.map(|j| j as usize))) {
            if !out[i] && j.is_none_or(|j| !out[j]) {
                left[i] += 1;
                if let Some(j) = j {
                    left[j] += 1;
                }
            }
        }
        let before = out.iter().filter(|out| **out).count();
        out.iter_mut().zip(&left).for_each(|(out, left)| *out |= *left <= 1);
        if out.iter().filter(|out| **out).count() == before {
            return out;
        }
    }
}

/// Contraction of the unit deviators of two tensors.
fn alignment<const D: usize>(a: &[[f64; D]; D], b: &[[f64; D]; D]) -> f64 {
    let deviator = |t: &[[f64; D]; D]| -> [[f64; D]; D] {
        let mean = (0..D).map(|c| t[c][c]).sum::<f64>() / D as f64;
        std::array::from_fn(|i| std::array::from_fn(|j| t[i][j] - if i == j { mean } else { 0.0 }))
    };
    let (a, b) = (deviator(a), deviator(b));
    let product = |a: &[[f64; D]; D], b: &[[f64; D]; D]| -> f64 {
        a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| a * b).sum()
    };
    product(&a, &b) / (product(&a, &a) * product(&b, &b)).sqrt()
}

impl<const D: usize, const R: usize> PackingView<'_, D, R> {
    /// Fabric of the present contacts; `None` without contacts between grains. Held grains are never rattlers and are not counted.
    pub fn fabric(&self) -> Option<Fabric<D>> {
        let held = &self.grains.is_held;
        let FabricSample { pairs, forces, dyads, stress_volume: pressed } = self.fabric_sample();
        if forces.is_empty() {
            return None;
        }
        let mean = (dyads * (1.0 / forces.len() as f64)).to_matrix().0;
        let tensor: [[f64; D]; D] = std::array::from_fn(|a| std::array::from_fn(|b| mean[a][b]));
        let loose = rattlers(self.grains.len(), &pairs);
        let free = held.iter().filter(|held| !**held).count() as f64;
        let idle = loose.iter().zip(held).filter(|(loose, held)| **loose && !**held).count() as f64;
        let is_loose = |i: u32| loose[i as usize] && !held[i as usize];
        let inner = &pairs[..forces.len()];
        let bearing = inner.iter().filter(|(i, j)| !is_loose(*i) && !j.is_some_and(is_loose)).count() as f64;
        let count = inner.len() as f64;
        let mut square = 0.0;
        for a in 0..D {
            for b in 0..D {
                let even = if a == b { 1.0 / D as f64 } else { 0.0 };
                square += (tensor[a][b] - even).powi(2);
            }
        }
        let mean_force = forces.iter().sum::<f64>() / count;
        let weak = forces.iter().filter(|normal| **normal < mean_force).count() as f64;
        Some(Fabric {
            contacts: inner.len(),
            coordination: 2.0 * count / free,
            mechanical_coordination: if free > idle { 2.0 * bearing / (free - idle) } else { 0.0 },
            rattlers: idle / free,
            tensor,
            alignment: alignment(&tensor, &pressed),
            anisotropy: if D == 2 { 4.0 } else { 7.5 } * square.sqrt(),
            mean_force,
            weak_fraction: weak / count,
        })
    }

    /// Contact data for the fabric.
    pub(crate) fn fabric_sample(&self) -> FabricSample<D> {
        let held = &self.grains.is_held;
        // The capacity follows the last step. A list of whole contacts would need as much memory as all else for many grains.
        let all = self.records.energy_balance.contacts[0] as usize + self.neighbours.walls.grain.len();
        let (mut pairs, mut forces) = (Vec::with_capacity(all), Vec::with_capacity(all));
        let (mut dyads, mut pressed) = (SymTensor::ZERO, [[0.0; D]; D]);
        self.for_each_contact(|contact, _, _| {
            pairs.push(match contact.second {
                Some(j) if held[contact.grain] => (j as u32, None),
                other => (contact.grain as u32, other.filter(|j| !held[*j]).map(|j| j as u32)),
            });
            if contact.second.is_none() {
                return;
            }
            let normal = spatial(&scaled(1.0 / norm(&contact.branch), &contact.branch));
            dyads += SymTensor::symmetric_dyad(normal, normal);
            forces.push(contact.normal);
            let (f, l) = (&contact.force, &contact.branch);
            for a in 0..D {
                for b in 0..D {
                    pressed[a][b] += 0.5 * (f[a] * l[b] + f[b] * l[a]);
                }
            }
        });
        FabricSample { pairs, forces, dyads, stress_volume: pressed }
    }

    /// Scalar outputs of the fabric: not-a-number without contacts between grains.
    pub(crate) fn fabric_outputs(&self) -> Vec<ScalarOutput> {
        let fabric = self.fabric();
        let number = |of: &dyn Fn(&Fabric<D>) -> f64| fabric.as_ref().map_or(f64::NAN, of);
        let mut all = vec![
            ("fabric.mechanical_coordination".to_owned(), "", number(&|f| f.mechanical_coordination)),
            ("fabric.rattlers".to_owned(), "", number(&|f| f.rattlers)),
            ("fabric.anisotropy".to_owned(), "", number(&|f| f.anisotropy)),
            ("fabric.alignment".to_owned(), "", number(&|f| f.alignment)),
            ("fabric.mean_force".to_owned(), "N", number(&|f| f.mean_force)),
            ("fabric.weak".to_owned(), "", number(&|f| f.weak_fraction)),
        ];
        let axes = ["x", "y", "z"];
        for i in 0..D {
            for j in i..D {
                let name = format!("fabric.{}{}", axes[i], axes[j]);
                all.push((name, "", number(&|f| f.tensor[i][j])));
            }
        }
        all.into_iter().map(|(name, unit, value)| (name, unit.to_owned(), value)).collect()
    }

    /// Broken bonds in the order of breakage: position, time and ids of the grains.
    pub(crate) fn broken_bonds_dataset(&self) -> Dataset {
        let field = |name: &str, unit, data| Field { name: name.to_owned(), unit, data };
        let ids = |k: usize| {
            FieldData::Integer(self.records.broken_bonds.iter().map(|one| i64::from(one.ids[k])).collect())
        };
        let times = FieldData::Scalar(self.records.broken_bonds.iter().map(|one| one.time).collect());
        let points = FramePoints {
            ids: (0..self.records.broken_bonds.len() as u64).collect(),
            positions: self.records.broken_bonds.iter().map(|one| one.midpoint).collect(),
            ..FramePoints::default()
        };
        Dataset {
            name: "broken-bonds".to_owned(),
            geometry: DatasetGeometry::Points(points),
            fields: vec![field("time", "s", times), field("first", "", ids(0)), field("second", "", ids(1))],
        }
    }

    /// Contacts as lines to the centre of the first grain, from the centre of the second one or the contact point on a wall.
    pub(crate) fn contacts_dataset(&self) -> Dataset {
        let all = self.contacts();
        let across = |contact: &Contact<D>| {
            (dot(&contact.force, &contact.force) - contact.normal * contact.normal).max(0.0).sqrt()
        };
        let scalar = |name: &str, unit, of: &dyn Fn(&Contact<D>) -> f64| Field {
            name: name.to_owned(),
            unit,
            data: FieldData::Scalar(all.iter().map(of).collect()),
        };
        let ends = all.iter().map(|contact| {
            let to = &self.grains.position[contact.grain];
            [spatial(&difference(to, &contact.branch)), spatial(to)]
        });
        let force = FieldData::Vector(all.iter().map(|contact| spatial(&contact.force)).collect());
        Dataset {
            name: Dataset::CONTACTS.to_owned(),
            geometry: DatasetGeometry::Mesh(PolygonMesh::of_lines(&ends.collect::<Vec<_>>())),
            fields: vec![
                Field { name: "force".to_owned(), unit: "N", data: force },
                scalar("normal_force", "N", &|contact| contact.normal),
                scalar("tangential_force", "N", &across),
                scalar("overlap", "m", &|contact| contact.overlap),
                scalar("wall", "", &|contact| f64::from(u8::from(contact.second.is_none()))),
            ],
        }
    }

    /// Contact rose: fraction of the contacts between grains in each of `bins` equal sectors of the half turn from the x axis towards y.
    /// Normals are projected along z. All zero without contacts.
    pub fn contact_rose(&self, bins: usize) -> Vec<f64> {
        let mut counts = vec![0.0; bins];
        let mut total = 0.0;
        for contact in self.contacts().iter().filter(|contact| contact.second.is_some()) {
            let angle = contact.branch[1].atan2(contact.branch[0]).rem_euclid(std::f64::consts::PI);
            let bin = (angle / std::f64::consts::PI * bins as f64) as usize;
            if let Some(last) = bins.checked_sub(1) {
                counts[bin.min(last)] += 1.0;
                total += 1.0;
            }
        }
        if total > 0.0 {
            counts.iter_mut().for_each(|count| *count /= total);
        }
        counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alignment_of_rotated_fabric_tensors_is_the_cosine_of_twice_the_angle() {
        let turned = |angle: f64, k: f64| {
            let (sin, cos) = angle.sin_cos();
            [[1.0 + k * cos * cos, k * sin * cos], [k * sin * cos, 1.0 + k * sin * sin]]
        };
        let found = alignment(&turned(0.3, 0.5), &turned(0.7, 9.0));
        assert!((found - 0.8f64.cos()).abs() < 1e-12, "{found}");
        let space = [[3.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert!((alignment(&space, &space) - 1.0).abs() < 1e-12);
        assert!(alignment(&space, &[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]).is_nan());
    }

    #[test]
    fn a_chain_hanging_from_a_ring_consists_of_rattlers() {
        // A ring of three; a chain of two on it; one grain alone.
        let pairs = [(0, Some(1)), (1, Some(2)), (2, Some(0)), (2, Some(3)), (3, Some(4))];
        assert_eq!(rattlers(6, &pairs), [false, false, false, true, true, true]);
        // Between the ring and a wall the chain carries force.
        let pairs = [(0, Some(1)), (1, Some(2)), (2, Some(0)), (2, Some(3)), (3, Some(4)), (4, None)];
        assert_eq!(rattlers(6, &pairs), [false, false, false, false, false, true]);
    }
}
