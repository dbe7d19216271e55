//! Mohr–Coulomb pyramid, its cut-off and its tangents.

use super::return_map::{PyramidEdge, PyramidReturn, elastic_strain, stiffness};
use crate::laws::Elasticity;
use crate::laws::multi_surface;
use crate::laws::multi_surface::{ActiveSet, YieldPlane};

/// Mohr–Coulomb pyramid with tension cut-off, at a given plastic strain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pyramid {
    /// Friction coefficient `k = (1 + sin φ)/(1 - sin φ)`.
    pub friction: f64,
    /// Dilatancy coefficient `m`, likewise from the dilatancy angle.
    pub dilatancy: f64,
    /// Uniaxial compressive strength `2 c √k` (Pa).
    pub strength: f64,
    /// Largest principal tension (Pa); infinite without a cut-off.
    pub cut_off: f64,
}

/// Part of the yield surface on which a return ends: a plane, an edge or the apex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum YieldRegion {
    /// Elastic region: no return.
    Elastic,
    /// Plane `σ1 > σ2 > σ3`.
    Plane,
    /// Edge `σ1 = σ2` (triaxial compression).
    CompressionEdge,
    /// Edge `σ2 = σ3` (triaxial extension).
    ExtensionEdge,
    /// Apex.
    Apex,
    /// Active planes with the tension cut-off, see [`Pyramid::planes`].
    CutOff(ActiveSet),
}

/// Scalar product.
pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Vector product.
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

impl Pyramid {
    /// Returns the pyramid from friction angle, cohesion and dilatancy angle (rad, Pa, rad).
    pub fn new(friction_angle: f64, cohesion: f64, dilatancy_angle: f64) -> Self {
        let ratio = |angle: f64| (1.0 + angle.sin()) / (1.0 - angle.sin());
        let friction = ratio(friction_angle);
        let strength = 2.0 * cohesion * friction.sqrt();
        Self { friction, dilatancy: ratio(dilatancy_angle), strength, cut_off: f64::INFINITY }
    }

    /// Returns the pyramid cut off at a principal tension (Pa).
    #[must_use]
    pub fn with_cut_off(self, tensile_strength: Option<f64>) -> Self {
        Self { cut_off: tensile_strength.unwrap_or(f64::INFINITY), ..self }
    }

    /// Yield function `k σ1 - σ3 - 2 c √k` (Pa), or `σ1 - σ_t` where that is larger.
    #[inline]
    pub fn yield_value(&self, principal: [f64; 3]) -> f64 {
        self.shear_excess(principal).max(principal[0] - self.cut_off)
    }

    /// Yield function of the shear plane for ordered principal stresses (Pa), positive outside the surface.
    #[inline]
    pub(super) fn shear_excess(&self, principal: [f64; 3]) -> f64 {
        self.friction * principal[0] - principal[2] - self.strength
    }

    /// Yield planes of sorted principal stresses: shear in the planes 1–3, 1–2 and 2–3, then the tension cut-offs of the three stresses.
    pub fn planes(&self) -> [YieldPlane; 6] {
        let (k, m) = (self.friction, self.dilatancy);
        let shear = |normal, flow| YieldPlane { normal, offset: self.strength, flow };
        let tension = |normal| YieldPlane { normal, offset: self.cut_off, flow: normal };
        [
            shear([k, 0.0, -1.0], [m, 0.0, -1.0]),
            shear([k, -1.0, 0.0], [m, -1.0, 0.0]),
            shear([0.0, k, -1.0], [0.0, m, -1.0]),
            tension([1.0, 0.0, 0.0]),
            tension([0.0, 1.0, 0.0]),
            tension([0.0, 0.0, 1.0]),
        ]
    }

    /// Return map in principal stresses (sheet: constitutive §3.7.2, steps 1–5).
    pub fn return_map(&self, elasticity: &Elasticity, trial: [f64; 3]) -> ([f64; 3], YieldRegion) {
        self.pyramid_return(elasticity).return_map(trial)
    }

    /// Part of the yield surface on which the return of a trial stress ends.
    pub fn region(&self, elasticity: &Elasticity, trial: [f64; 3]) -> YieldRegion {
        self.pyramid_return(elasticity).return_map(trial).1
    }

    /// Principal stresses after the return of a trial stress to a given part of the surface (Pa).
    pub fn return_to(&self, region: YieldRegion, elasticity: &Elasticity, trial: [f64; 3]) -> [f64; 3] {
        self.pyramid_return(elasticity).return_to(region, trial)
    }

    /// Return directions of the pyramid, which all returns have in common.
    pub(super) fn pyramid_return(&self, elasticity: &Elasticity) -> PyramidReturn {
        let (k, m) = (self.friction, self.dilatancy);
        let db = stiffness(elasticity, [m, 0.0, -1.0]);
        let scale = 1.0 / (k * db[0] - db[2]);
        let direction = db.map(|c| c * scale);
        let edges = [([1.0, 1.0, k], [1.0, 1.0, m]), ([1.0, k, k], [1.0, m, m])];
        let edges = edges.map(|(edge, flow)| {
            // Elastic strain along the edge of the potential is not relaxed by the flow.
            let held = elastic_strain(elasticity, flow);
            let scale = 1.0 / dot(held, edge);
            PyramidEdge {
                direction: edge,
                edge_coordinate: held.map(|c| c * scale),
                plane_normal: cross(direction, edge),
            }
        });
        PyramidReturn {
            pyramid: *self,
            elasticity: *elasticity,
            direction,
            edges,
            apex: self.strength / (k - 1.0),
        }
    }

    /// Tangent `∂σ_A/∂ε_B` of a return that ends in `region`, at constant strength (sheet: constitutive §3.10).
    pub fn tangent(&self, elasticity: &Elasticity, region: YieldRegion) -> [[f64; 3]; 3] {
        let (k, m) = (self.friction, self.dilatancy);
        let d = elasticity.principal();
        let apply = |v: [f64; 3]| d.map(|row| dot(row, v));
        match region {
            YieldRegion::Elastic => d,
            YieldRegion::Plane => {
                let (da, db) = (apply([k, 0.0, -1.0]), apply([m, 0.0, -1.0]));
                let scale = 1.0 / dot([k, 0.0, -1.0], db);
                std::array::from_fn(|a| std::array::from_fn(|b| d[a][b] - scale * db[a] * da[b]))
            }
            YieldRegion::CompressionEdge | YieldRegion::ExtensionEdge => {
                let compression = region == YieldRegion::CompressionEdge;
                let along = |x: f64| if compression { [1.0, 1.0, x] } else { [1.0, x, x] };
                let (r, g) = (along(k), along(m));
                let scale = 1.0 / dot(g, elastic_strain(elasticity, r));
                r.map(|r| g.map(|g| scale * r * g))
            }
            YieldRegion::Apex => [[0.0; 3]; 3],
            YieldRegion::CutOff(set) => multi_surface::tangent(&self.planes(), set, elasticity),
        }
    }
}
