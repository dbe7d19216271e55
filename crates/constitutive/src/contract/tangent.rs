//! Consistent tangents of stress updates, for implicit solvers (sheet: constitutive §3.10).

use crate::tensors::tensor::PAIRS;
use crate::{Mat3, MaterialError, Motion, Spectrum, SymTensor};

/// Consistent tangent of a stress update: derivative of the new Cauchy stress with respect to the strain increment of the step, at fixed
/// spin. Rows are tensor components xx yy zz xy yz zx, columns have engineering shear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tangent(pub [[f64; 6]; 6]);

impl Tangent {
    /// Tangent of a material without stiffness.
    pub const ZERO: Self = Self([[0.0; 6]; 6]);

    /// Adds `factor a ⊗ b`.
    pub(crate) fn add_dyad(&mut self, factor: f64, a: &SymTensor, b: &SymTensor) {
        for (row, a) in self.0.iter_mut().zip(a.0) {
            for (entry, b) in row.iter_mut().zip(b.0) {
                *entry += factor * a * b;
            }
        }
    }

    /// Tangent of a stress that is rotated by `rotation` afterwards.
    pub(crate) fn rotated(&self, rotation: &Mat3) -> Self {
        let mut turned = *self;
        for column in 0..6 {
            let stress = SymTensor(std::array::from_fn(|row| self.0[row][column])).rotated(rotation);
            for (row, value) in stress.0.into_iter().enumerate() {
                turned.0[row][column] = value;
            }
        }
        turned
    }

    /// Stress increment (Pa) of the strain increment `strain` (tensor shear components).
    pub fn apply(&self, strain: &SymTensor) -> SymTensor {
        let [a, b, c, d, e, f] = strain.0;
        let engineering = [a, b, c, 2.0 * d, 2.0 * e, 2.0 * f];
        SymTensor(self.0.map(|row| row.iter().zip(engineering).map(|(c, e)| c * e).sum()))
    }

    /// Contraction `a : D` with the symmetric tensor `a`, as the row to be contracted with a strain increment.
    pub(crate) fn apply_left(&self, a: &SymTensor) -> SymTensor {
        let twice = |row: usize| if row < 3 { 1.0 } else { 2.0 };
        SymTensor(std::array::from_fn(|column| {
            (0..6).map(|row| twice(row) * a[row] * self.0[row][column]).sum()
        }))
    }

    /// Tangent from its principal values (eq. 3.11): normal part `block = ∂σ_A/∂ε_B`, and shear modulus `shear[C]` of the plane normal to
    /// direction `C`, in which `σ_AB = 2 shear ε_AB`.
    pub(crate) fn spectral(spectrum: &Spectrum, block: &[[f64; 3]; 3], shear: [f64; 3]) -> Self {
        let n = spectrum.directions;
        let dyads = n.map(|n| SymTensor::symmetric_dyad(n, n));
        let mut tangent = Self::ZERO;
        for (dyad, row) in dyads.iter().zip(block) {
            for (other, value) in dyads.iter().zip(row) {
                tangent.add_dyad(*value, dyad, other);
            }
        }
        for (c, modulus) in shear.into_iter().enumerate() {
            let dyad = SymTensor::symmetric_dyad(n[(c + 1) % 3], n[(c + 2) % 3]);
            tangent.add_dyad(4.0 * modulus, &dyad, &dyad);
        }
        tangent
    }
}

/// Shear moduli of the planes normal to each principal direction for [`Tangent::spectral`], `(σ_A - σ_B) / (2 (ε_A - ε_B))` or its limit
/// for equal strains.
pub(crate) fn shear_moduli(stress: [f64; 3], strain: [f64; 3], block: &[[f64; 3]; 3]) -> [f64; 3] {
    std::array::from_fn(|c| {
        let (a, b) = ((c + 1) % 3, (c + 2) % 3);
        let gap = strain[a] - strain[b];
        let size = strain[a].abs().max(strain[b].abs());
        if gap.abs() > 1e-8 * size {
            0.5 * (stress[a] - stress[b]) / gap
        } else {
            0.25 * (block[a][a] - block[a][b] + block[b][b] - block[b][a])
        }
    })
}

/// Spatial tangent `c` of the Kirchhoff stress, `L_v τ = c : d`, of an isotropic law in principal logarithmic strains (eq. 3.12). `block`
/// is `∂τ_A/∂ε_B` and `squares` the squared trial stretches `λ_A²`.
pub(crate) fn kirchhoff_tangent(
    spectrum: &Spectrum,
    stress: [f64; 3],
    squares: [f64; 3],
    block: &[[f64; 3]; 3],
) -> Tangent {
    let mut normal = *block;
    for (a, row) in normal.iter_mut().enumerate() {
        row[a] -= 2.0 * stress[a];
    }
    let shear = std::array::from_fn(|c| {
        let (a, b) = ((c + 1) % 3, (c + 2) % 3);
        let gap = squares[a] - squares[b];
        if gap.abs() > 1e-8 {
            (stress[a] * squares[b] - stress[b] * squares[a]) / gap
        } else {
            0.25 * (block[a][a] - block[a][b] + block[b][b] - block[b][a]) - 0.5 * (stress[a] + stress[b])
        }
    });
    Tangent::spectral(spectrum, &normal, shear)
}

/// Tangent with respect to the strain increment of the step, from the spatial tangent `c` of the Kirchhoff stress. A change `δA` of the
/// mid-step gradient changes the deformation by `δl = (1 - A/2)⁻¹ δA (1 + A/2)⁻¹`, and `δσ = (c : δd)/J + δl σ + σ δlᵀ - tr(δl) σ`.
pub(crate) fn from_spatial(
    c: &Tangent,
    motion: &Motion,
    jacobian: f64,
    stress: &SymTensor,
) -> Option<Tangent> {
    let half = motion.velocity_gradient_dt * 0.5;
    let before = (Mat3::IDENTITY - half).inverse()?;
    let after = (Mat3::IDENTITY + half).inverse()?;
    let sigma = stress.to_matrix();
    let mut tangent = Tangent::ZERO;
    for (column, &(i, j)) in PAIRS.iter().enumerate() {
        let mut change = Mat3::ZERO;
        change.0[i][j] += 0.5;
        change.0[j][i] += 0.5;
        let l = before * change * after;
        let material = c.apply(&l.sym()) * (1.0 / jacobian);
        let geometric = (l * sigma).sym() * 2.0 - *stress * l.trace();
        for (row, value) in (material + geometric).0.into_iter().enumerate() {
            tangent.0[row][column] = value;
        }
    }
    Some(tangent)
}

/// Tangent by central differences of a stress update with respect to the strain increment.
pub(crate) fn numerical_tangent(
    motion: &Motion,
    stress: impl Fn(&Motion) -> Result<SymTensor, MaterialError>,
) -> Result<Tangent, MaterialError> {
    // Large enough that the round-off of a density, times the stiffness, is negligible.
    let step = 1e-6 * motion.velocity_gradient_dt.sym().norm().max(1e-2);
    let mut tangent = [[0.0; 6]; 6];
    for (k, &(i, j)) in PAIRS.iter().enumerate() {
        let perturbed = |sign: f64| {
            let mut m = *motion;
            // Engineering shear: half in each of the two entries, the whole on the diagonal.
            m.velocity_gradient_dt.0[i][j] += 0.5 * sign * step;
            m.velocity_gradient_dt.0[j][i] += 0.5 * sign * step;
            let half = m.velocity_gradient_dt * 0.5;
            if let Some(inverse) = (Mat3::IDENTITY - half).inverse() {
                m.deformation = inverse * (Mat3::IDENTITY + half);
            }
            m.density = motion.density * motion.deformation.determinant() / m.deformation.determinant();
            stress(&m)
        };
        let (plus, minus) = (perturbed(1.0)?, perturbed(-1.0)?);
        for row in 0..6 {
            tangent[row][k] = (plus[row] - minus[row]) / (2.0 * step);
        }
    }
    Ok(Tangent(tangent))
}
