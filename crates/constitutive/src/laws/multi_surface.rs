//! Return to a surface of several planes in principal stresses (sheet: constitutive §3.7.3): Mohr–Coulomb
//! with a tension cut-off, and the independent check of its return without one.
//!
//! Planes `a_i · σ ≤ b_i` with flow directions `g_i`, elastic law linear, so the return to a set of active
//! planes is a linear system: `(A D Gᵀ) λ = A σ - b`. The solution is the first set whose multipliers are not negative and
//! whose stress violates no other plane and remains sorted. Limit: sets whose system is
//! singular (the apex without dilatancy) are skipped.

use super::Elasticity;

/// Plane of a yield surface, in principal stresses sorted `σ1 ≥ σ2 ≥ σ3`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct YieldPlane {
    /// Outward normal `a` of the yield plane.
    pub normal: [f64; 3],
    /// Offset `b` of the plane (Pa): stresses with `a · σ ≤ b` do not yield.
    pub offset: f64,
    /// Direction `g` of plastic flow on the plane.
    pub flow: [f64; 3],
}

/// Set of active planes of a return, one bit per plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ActiveSet(pub u16);

/// Rows of a matrix of at most three active planes.
type Matrix3Rows = [[f64; 3]; 3];

/// Scalar product.
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl YieldPlane {
    /// Yield excess `a · σ - b` (Pa).
    #[inline]
    pub fn excess(&self, stress: [f64; 3]) -> f64 {
        dot(self.normal, stress) - self.offset
    }
}

impl ActiveSet {
    /// All combinations of one, two and three out of `count` planes, the smaller ones first.
    fn combinations(count: usize) -> impl Iterator<Item = Self> {
        (1..=3).flat_map(move |size| (1u16..1 << count).filter(move |s| s.count_ones() == size)).map(Self)
    }

    /// Active planes of the set, at most three, and their number.
    fn planes(self, planes: &[YieldPlane]) -> ([YieldPlane; 3], usize) {
        let mut active = [YieldPlane { normal: [0.0; 3], offset: 0.0, flow: [0.0; 3] }; 3];
        let mut count = 0;
        for (index, plane) in planes.iter().enumerate() {
            if self.0 >> index & 1 == 1 && count < 3 {
                active[count] = *plane;
                count += 1;
            }
        }
        (active, count)
    }
}

/// Inverse of the leading `n` by `n` submatrix; `None` if it is singular.
fn inverse(m: Matrix3Rows, n: usize) -> Option<Matrix3Rows> {
    let mut a = m;
    let mut inverse = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let size = m[..n].iter().flat_map(|row| &row[..n]).fold(0.0, |s: f64, c| s.max(c.abs()));
    for column in 0..n {
        let pivot = (column..n).max_by(|i, j| a[*i][column].abs().total_cmp(&a[*j][column].abs()))?;
        if a[pivot][column].abs() <= 1e-12 * size {
            return None;
        }
        a.swap(column, pivot);
        inverse.swap(column, pivot);
        let scale = 1.0 / a[column][column];
        a[column] = a[column].map(|c| c * scale);
        inverse[column] = inverse[column].map(|c| c * scale);
        for row in (0..n).filter(|row| *row != column) {
            let factor = a[row][column];
            for k in 0..3 {
                a[row][k] -= factor * a[column][k];
                inverse[row][k] -= factor * inverse[column][k];
            }
        }
    }
    Some(inverse)
}

/// Principal stresses of principal elastic strains (Pa).
fn stiffness(elasticity: &Elasticity, v: [f64; 3]) -> [f64; 3] {
    let volumetric = elasticity.lame() * (v[0] + v[1] + v[2]);
    v.map(|c| volumetric + 2.0 * elasticity.shear_modulus * c)
}

/// Return of a trial stress to the planes of `set`: stress (Pa) and multipliers; `None` if the system is singular.
fn solve(
    planes: &[YieldPlane],
    set: ActiveSet,
    elasticity: &Elasticity,
    trial: [f64; 3],
) -> Option<([f64; 3], [f64; 3])> {
    let (active, n) = set.planes(planes);
    let steps = active.map(|plane| stiffness(elasticity, plane.flow));
    let system = std::array::from_fn(|i| std::array::from_fn(|j| dot(active[i].normal, steps[j])));
    let inverse = inverse(system, n)?;
    let excess = active.map(|plane| plane.excess(trial));
    let mut multipliers = [0.0; 3];
    let mut stress = trial;
    for i in 0..n {
        multipliers[i] = (0..n).map(|j| inverse[i][j] * excess[j]).sum();
        for c in 0..3 {
            stress[c] -= multipliers[i] * steps[i][c];
        }
    }
    // At the intersection of three planes the stress is the corner itself: a corner without stress has no round-off.
    if n == 3
        && let Some(corner) = plane_intersection(&active)
    {
        stress = corner;
    }
    Some((stress, multipliers))
}

/// Intersection of three planes (Pa); `None` where that is no point.
fn plane_intersection(active: &[YieldPlane; 3]) -> Option<[f64; 3]> {
    let inverse = inverse(active.map(|plane| plane.normal), 3)?;
    Some(inverse.map(|row| dot(row, active.map(|plane| plane.offset))))
}

/// Stress after the return of a trial stress to the planes of `set` (Pa); the trial stress if the system is singular.
pub fn return_to(
    planes: &[YieldPlane],
    set: ActiveSet,
    elasticity: &Elasticity,
    trial: [f64; 3],
) -> [f64; 3] {
    solve(planes, set, elasticity, trial).map_or(trial, |(stress, _)| stress)
}

/// Active planes of the return of a sorted trial stress outside the surface; `None` if no combination has valid multipliers.
pub fn active_set(planes: &[YieldPlane], elasticity: &Elasticity, trial: [f64; 3]) -> Option<ActiveSet> {
    let size = trial.iter().fold(0.0, |s: f64, c| s.max(c.abs()));
    let slack = 1e-11 * (size + planes.iter().fold(0.0, |s: f64, plane| s.max(plane.offset.abs())));
    ActiveSet::combinations(planes.len()).find(|set| {
        solve(planes, *set, elasticity, trial).is_some_and(|(stress, multipliers)| {
            let ordered = stress[0] >= stress[1] - slack && stress[1] >= stress[2] - slack;
            let flows = multipliers.iter().all(|m| *m >= -slack / elasticity.bulk_modulus);
            ordered && flows && planes.iter().all(|plane| plane.excess(stress) <= slack)
        })
    })
}

/// Tangent `∂σ_A/∂ε_B` of the return to the planes of `set` (Pa): `D - D Gᵀ (A D Gᵀ)⁻¹ A D`.
pub fn tangent(planes: &[YieldPlane], set: ActiveSet, elasticity: &Elasticity) -> [[f64; 3]; 3] {
    let mut tangent = elasticity.principal();
    let (active, n) = set.planes(planes);
    let steps = active.map(|plane| stiffness(elasticity, plane.flow));
    let normals = active.map(|plane| stiffness(elasticity, plane.normal));
    let system = std::array::from_fn(|i| std::array::from_fn(|j| dot(active[i].normal, steps[j])));
    let Some(inverse) = inverse(system, n) else { return tangent };
    for i in 0..n {
        for j in 0..n {
            for (a, row) in tangent.iter_mut().enumerate() {
                for (b, entry) in row.iter_mut().enumerate() {
                    *entry -= steps[i][a] * inverse[i][j] * normals[j][b];
                }
            }
        }
    }
    tangent
}
