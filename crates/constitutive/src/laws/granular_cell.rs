//! Homogenisation of a cell of grains (sheet: constitutive §2.17; Sun 2020, eqs. 23, 41–57): averages over its
//! contacts, and the kinematics of a cell that represents an interface.

use crate::contract::parameter_checks::positive;
use crate::{Mat3, MaterialError, SymTensor};

/// Stress `1/(2V) Σ (f ⊗ l + l ⊗ f)` of a cell with contacts (Pa, tension-positive). The branch vector `l` (m) is from one grain to the
/// other, and `f` is the force on the first grain by the second (N).
///
/// # Errors
/// Unless the volume (m³) is positive.
pub fn contact_stress(
    volume: f64,
    contacts: impl IntoIterator<Item = ([f64; 3], [f64; 3])>,
) -> Result<SymTensor, MaterialError> {
    positive("volume", volume, "m³")?;
    // A compressive contact has a force against its branch.
    let sum = contacts
        .into_iter()
        .fold(SymTensor::ZERO, |sum, (force, branch)| sum + SymTensor::symmetric_dyad(force, branch));
    Ok(sum * (1.0 / volume))
}

/// Fabric tensor: anisotropy of the contacts of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FabricTensor {
    /// Tensor `G = Σ n ⊗ n / N_c`, of trace 1.
    pub tensor: SymTensor,
}

impl FabricTensor {
    /// Returns the tensor of the unit normals of the contacts; `None` without contacts.
    pub fn from_normals(normals: impl IntoIterator<Item = [f64; 3]>) -> Option<Self> {
        let (sum, count) = normals.into_iter().fold((SymTensor::ZERO, 0.0), |(sum, count), n| {
            (sum + SymTensor::symmetric_dyad(n, n), count + 1.0)
        });
        (count > 0.0).then(|| Self { tensor: sum * (1.0 / count) })
    }

    /// Anisotropy tensor `F = 15/2 (G - 1/3)`; its norm is the degree of anisotropy.
    pub fn anisotropy(&self) -> SymTensor {
        (self.tensor - SymTensor::isotropic(1.0 / 3.0)) * 7.5
    }

    /// Alignment `A = n_F : n_s` of fabric and stress deviators, 1 if the contacts concentrate in the direction of compression. `None` if
    /// either deviator is zero. At the critical state `A = 1` along with `η = η_c` and `e = e_c`.
    pub fn alignment(&self, stress: &SymTensor) -> Option<f64> {
        let (fabric, deviator) = (self.anisotropy(), -stress.deviator());
        let size = fabric.norm() * deviator.norm();
        (size > 0.0).then(|| fabric.dot(&deviator) / size)
    }
}

/// Cell of grains that represents an interface: of height `thickness`, its top displaced against its bottom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InterfaceCell {
    /// Unit normal `N` of the interface in the undeformed configuration.
    pub normal: [f64; 3],
    /// Height `h_0` of the cell (m).
    pub thickness: f64,
}

impl InterfaceCell {
    /// Mean deformation gradient `1 + [u] ⊗ N / h_0` of a jump of displacement (m).
    pub fn deformation(&self, jump: [f64; 3]) -> Mat3 {
        let mut f = Mat3::IDENTITY;
        for (row, u) in f.0.iter_mut().zip(jump) {
            for (entry, n) in row.iter_mut().zip(self.normal) {
                *entry += u * n / self.thickness;
            }
        }
        f
    }

    /// Nominal traction `P N` (Pa) of a first Piola–Kirchhoff stress.
    pub fn traction(&self, stress: &Mat3) -> [f64; 3] {
        stress.apply(self.normal)
    }

    /// Unit normal of the deformed interface, along `F⁻ᵀ N`; `None` if `F` is singular. Eq. 57 of the source interchanges normal and
    /// tangent.
    pub fn deformed_normal(&self, f: &Mat3) -> Option<[f64; 3]> {
        unit(f.inverse()?.transpose().apply(self.normal))
    }
}

/// Unit vector along the deformed tangent `F M` of a surface; `None` if its length is zero.
pub fn deformed_tangent(f: &Mat3, tangent: [f64; 3]) -> Option<[f64; 3]> {
    unit(f.apply(tangent))
}

/// Permeability `J F⁻¹ k F⁻ᵀ` in the reference configuration of a spatial permeability `k`; `None` if `F` is singular.
pub fn pulled_back_permeability(permeability: &SymTensor, f: &Mat3) -> Option<SymTensor> {
    Some(permeability.rotated(&f.inverse()?) * f.determinant())
}

/// Unit vector of `v`; `None` for a zero vector.
fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    (length > 0.0).then(|| v.map(|c| c / length))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tensors::strain_measures::first_piola_kirchhoff;

    #[test]
    fn a_lattice_under_pressure_has_that_pressure() {
        // Cubic cell of side a, one contact along each axis that carries p a².
        let (side, pressure) = (0.01, 50e3);
        let axis = |k: usize, x: f64| std::array::from_fn(|i| if i == k { x } else { 0.0 });
        let contacts = (0..3).map(|k| (axis(k, -pressure * side * side), axis(k, side)));
        let stress = contact_stress(side.powi(3), contacts).unwrap();
        assert!((stress - SymTensor::isotropic(-pressure)).norm() < 1e-9 * pressure);
        let refused = contact_stress(0.0, []).unwrap_err().to_string();
        assert!(refused.starts_with("volume: 0"), "{refused}");
    }

    #[test]
    fn fabric_is_isotropic_or_points_where_the_contacts_are() {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let even = FabricTensor::from_normals(axes).unwrap();
        assert!((even.tensor.trace() - 1.0).abs() < 1e-15 && even.anisotropy().norm() < 1e-15);
        assert_eq!(FabricTensor::from_normals([]), None);
        let uneven = FabricTensor::from_normals([axes[2], axes[2], axes[0], axes[1]]).unwrap();
        // G = (1/4, 1/4, 1/2): F = 15/2 (-1/12, -1/12, 1/6).
        assert!((uneven.anisotropy() - SymTensor::diagonal(-0.625, -0.625, 1.25)).norm() < 1e-15);
        let compression = SymTensor::diagonal(-1.0, -1.0, -3.0);
        assert!((uneven.alignment(&compression).unwrap() - 1.0).abs() < 1e-15);
        assert!((uneven.alignment(&-compression).unwrap() + 1.0).abs() < 1e-15);
        assert_eq!(uneven.alignment(&SymTensor::IDENTITY), None);
    }

    #[test]
    fn the_work_of_an_interface_cell_is_that_of_its_traction() {
        // h_0 P : Ḟ = T · [u̇].
        let normal = [0.6, 0.0, 0.8];
        let cell = InterfaceCell { normal, thickness: 2e-3 };
        let f = cell.deformation([1e-4, -2e-4, 3e-4]);
        let stress = first_piola_kirchhoff(&SymTensor([-3.0, 2.0, 1.0, 0.5, -0.7, 1.2]), &f).unwrap();
        let rate = [0.3, -0.1, 0.2];
        let gradient = cell.deformation(rate) - Mat3::IDENTITY;
        let inside: f64 =
            stress.0.as_flattened().iter().zip(gradient.0.as_flattened()).map(|(a, b)| a * b).sum();
        let across: f64 = cell.traction(&stress).iter().zip(rate).map(|(a, b)| a * b).sum();
        assert!((cell.thickness * inside - across).abs() < 1e-14);
    }

    #[test]
    fn a_sheared_interface_keeps_normal_and_tangent_at_right_angles() {
        let cell = InterfaceCell { normal: [0.0, 1.0, 0.0], thickness: 1.0 };
        let f = Mat3([[1.0, 0.5, 0.0], [0.2, 1.1, 0.0], [0.0, 0.0, 1.0]]);
        let normal = cell.deformed_normal(&f).unwrap();
        let tangent = deformed_tangent(&f, [1.0, 0.0, 0.0]).unwrap();
        assert!((0..3).map(|i| normal[i] * tangent[i]).sum::<f64>().abs() < 1e-15);
        assert_eq!(cell.deformed_normal(&Mat3::ZERO), None);
        // An isotropic permeability in the reference configuration of a body stretched by 2 along x: J F⁻¹ k F⁻ᵀ = k (1/2, 2, 2).
        let stretch = Mat3([[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let back = pulled_back_permeability(&SymTensor::isotropic(3.0), &stretch).unwrap();
        assert!((back - SymTensor::diagonal(1.5, 6.0, 6.0)).norm() < 1e-15);
    }
}
