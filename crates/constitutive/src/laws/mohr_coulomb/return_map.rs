//! Return in principal stresses, region by region (sheet: constitutive §3.7.2; §3.7.3 with a cut-off).

use super::pyramid::{Pyramid, YieldRegion, dot};
use crate::laws::Elasticity;
use crate::laws::multi_surface;
use crate::laws::multi_surface::active_set;

/// Pyramid with the common data of its returns.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PyramidReturn {
    /// Yield pyramid of the return.
    pub pyramid: Pyramid,
    /// Elasticity of the return, which maps plastic strain to stress.
    pub elasticity: Elasticity,
    /// Return direction `D b / (aᵀ D b)`: change of stress of a return to the plane, per unit of the yield function.
    pub direction: [f64; 3],
    /// Edges of triaxial compression and of triaxial extension.
    pub edges: [PyramidEdge; 2],
    /// Principal stress at the apex (Pa); infinite without friction.
    pub apex: f64,
}

/// Edge of the pyramid; positions are relative to the apex.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PyramidEdge {
    /// Direction of the edge in the space of principal stresses.
    pub direction: [f64; 3],
    /// Vector whose scalar product with a trial stress (from the apex) is the position on the edge at the end of the return.
    pub edge_coordinate: [f64; 3],
    /// Normal of the plane through the edge and the direction of return.
    pub plane_normal: [f64; 3],
}

impl PyramidReturn {
    /// Stress after the return of a trial stress, and the part of the surface on which it ends.
    #[inline]
    pub(super) fn return_map(&self, trial: [f64; 3]) -> ([f64; 3], YieldRegion) {
        let region = self.shear_region(trial);
        let stress = self.return_to(region, trial);
        let slack = 8.0 * f64::EPSILON * (trial[0].abs() + self.pyramid.strength);
        if stress[0] <= self.pyramid.cut_off + slack {
            return (stress, region);
        }
        let set = active_set(&self.pyramid.planes(), &self.elasticity, trial);
        let region = set.map_or(YieldRegion::Apex, YieldRegion::CutOff);
        (self.return_to(region, trial), region)
    }

    /// Region of the surface without its cut-off.
    #[inline]
    fn shear_region(&self, trial: [f64; 3]) -> YieldRegion {
        let pyramid = &self.pyramid;
        // Round-off of an earlier return does not count as flow.
        let scale = pyramid.friction * trial[0].abs() + trial[2].abs() + pyramid.strength;
        if pyramid.shear_excess(trial) <= 8.0 * f64::EPSILON * scale {
            return YieldRegion::Elastic;
        }
        if pyramid.friction == 1.0 {
            // Without friction there is no apex: the prism of Tresca (sheet: constitutive §3.7.4).
            let plane = self.return_to(YieldRegion::Plane, trial);
            return if trial[1] > plane[0] {
                YieldRegion::CompressionEdge
            } else if trial[1] < plane[2] {
                YieldRegion::ExtensionEdge
            } else {
                YieldRegion::Plane
            };
        }
        let from_apex = trial.map(|s| s - self.apex);
        let [first, second] = &self.edges;
        if dot(first.edge_coordinate, from_apex) > 0.0 && dot(second.edge_coordinate, from_apex) > 0.0 {
            YieldRegion::Apex
        } else if dot(first.plane_normal, from_apex) < 0.0 {
            YieldRegion::CompressionEdge
        } else if dot(second.plane_normal, from_apex) > 0.0 {
            YieldRegion::ExtensionEdge
        } else {
            YieldRegion::Plane
        }
    }

    /// Principal stresses after the return of a trial stress to a given part of the surface (Pa).
    #[inline]
    pub(super) fn return_to(&self, region: YieldRegion, trial: [f64; 3]) -> [f64; 3] {
        let pyramid = &self.pyramid;
        match region {
            YieldRegion::Elastic => trial,
            YieldRegion::Plane => {
                let onto = |s: [f64; 3]| {
                    let excess = pyramid.shear_excess(s);
                    std::array::from_fn(|i| s[i] - excess * self.direction[i])
                };
                // Twice: round-off is then that of the result, not of the trial.
                onto(onto(trial))
            }
            YieldRegion::Apex => [pyramid.cut_off.min(self.apex); 3],
            YieldRegion::CutOff(set) => {
                let onto = |s| multi_surface::return_to(&pyramid.planes(), set, &self.elasticity, s);
                onto(onto(trial))
            }
            _ if pyramid.friction == 1.0 => {
                let mean = (trial[0] + trial[1] + trial[2]) / 3.0;
                let third = pyramid.strength / 3.0;
                if region == YieldRegion::CompressionEdge {
                    [mean + third, mean + third, mean - 2.0 * third]
                } else {
                    [mean + 2.0 * third, mean - third, mean - third]
                }
            }
            YieldRegion::CompressionEdge | YieldRegion::ExtensionEdge => {
                let edge = &self.edges[usize::from(region == YieldRegion::ExtensionEdge)];
                let position = dot(edge.edge_coordinate, trial.map(|s| s - self.apex));
                edge.direction.map(|r| self.apex + position * r)
            }
        }
    }
}

/// Principal stresses of principal elastic strains (Pa).
pub(super) fn stiffness(elasticity: &Elasticity, v: [f64; 3]) -> [f64; 3] {
    let volumetric = elasticity.lame() * (v[0] + v[1] + v[2]);
    v.map(|c| volumetric + 2.0 * elasticity.shear_modulus * c)
}

/// Principal elastic strains of principal stresses (Pa).
pub(super) fn elastic_strain(elasticity: &Elasticity, v: [f64; 3]) -> [f64; 3] {
    let mean = (v[0] + v[1] + v[2]) / 3.0;
    v.map(|c| (c - mean) / (2.0 * elasticity.shear_modulus) + mean / (3.0 * elasticity.bulk_modulus))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_region_is_decided_by_the_quantities_of_the_sheet() {
        // §3.7.2, first row with ψ = 10° (kPa).
        let elasticity = Elasticity::new(20_000.0, 0.3).unwrap();
        let pyramid = Pyramid::new(30f64.to_radians(), 10.0, 10f64.to_radians());
        let trial = [-50.0, -120.0, -400.0];
        let returns = pyramid.pyramid_return(&elasticity);
        let near = |found: f64, exact: f64| assert!((found - exact).abs() < 1e-6, "{found} for {exact}");
        near(pyramid.shear_excess(trial), 215.358_984);
        for (found, exact) in returns.direction.into_iter().zip([0.294_587, 0.053_504, -0.116_239]) {
            near(found, exact);
        }
        let from_apex = trial.map(|s| s - returns.apex);
        let [first, second] = &returns.edges;
        near(dot(first.plane_normal, from_apex), 18.080_696);
        near(dot(second.plane_normal, from_apex), -243.444_231);
        assert!((dot(first.edge_coordinate, from_apex) + 132.408_58).abs() < 1e-5);
        near(dot(second.edge_coordinate, from_apex), -91.579_157);
    }
}
