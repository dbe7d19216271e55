//! Bed: level, slope and curvature in plan of the surface below the flow (sheet: depth-sph §2.9).

pub(crate) mod bed_path;
mod bicubic_spline;
mod erodible_bed;
mod terrain_bed;
pub mod test_terrain;

use std::fmt;
use std::sync::Arc;

pub use crate::bed::erodible_bed::{ErodibleBed, ErosionState};
pub use crate::bed::terrain_bed::TerrainBed;
use crate::config::choices::DepthFrame;
use crate::config::settings::FlowSettings;
use crate::points::phase_nodes::{PlanVector, dot};

/// Level, slope and curvature of the bed at a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BedPoint<const D: usize> {
    /// Level `Z` (m).
    pub level: f64,
    /// Slope `∇Z` of the bed in plan.
    pub slope: PlanVector<D>,
    /// Second derivatives of `Z` (1/m).
    pub curvature: [PlanVector<D>; D],
}

impl<const D: usize> BedPoint<D> {
    /// A plane at `level` (m).
    pub const fn horizontal(level: f64) -> Self {
        Self { level, slope: [0.0; D], curvature: [[0.0; D]; D] }
    }

    /// Steepness `1 + |∇Z|²` of the bed, the inverse square of the cosine of the slope angle.
    #[inline]
    pub fn steepness(&self) -> f64 {
        1.0 + dot(&self.slope, &self.slope)
    }

    /// Bed in a mirror: `signs` are -1 along mirrored axes, 1 elsewhere.
    #[inline]
    pub fn mirrored(&self, signs: &PlanVector<D>) -> Self {
        let mut point = *self;
        for c in 0..D {
            point.slope[c] *= signs[c];
            (0..D).for_each(|k| point.curvature[c][k] *= signs[c] * signs[k]);
        }
        point
    }

    /// Vertical acceleration of motion along the bed, `vᵀ H v` (m/s²).
    #[inline]
    pub fn curvature_acceleration(&self, velocity: &PlanVector<D>) -> f64 {
        (0..D).map(|c| velocity[c] * dot(&self.curvature[c], velocity)).sum()
    }

    /// Turn of the normal along the direction of a velocity in plan, per distance in plan (rad/m); zero without a velocity.
    #[inline]
    pub fn path_curvature(&self, velocity: &PlanVector<D>) -> f64 {
        let speed = dot(velocity, velocity).sqrt();
        if speed == 0.0 {
            return 0.0;
        }
        let turn: PlanVector<D> = std::array::from_fn(|c| dot(&self.curvature[c], velocity));
        dot(&turn, &turn).sqrt() / (speed * self.steepness())
    }

    /// Speed along the bed of a velocity in plan (m/s).
    #[inline]
    pub fn speed(&self, velocity: &PlanVector<D>) -> f64 {
        let rise = dot(velocity, &self.slope);
        (dot(velocity, velocity) + rise * rise).sqrt()
    }
}

/// Bed surface as a function of the position in plan; `None` outside its extent.
pub trait BedSurface<const D: usize>: Send + Sync {
    /// Bed at a position in plan (m); `None` outside its extent.
    fn bed_point(&self, x: &PlanVector<D>) -> Option<BedPoint<D>>;

    /// Whether the bed is defined at a position in plan (m).
    fn is_defined(&self, x: &PlanVector<D>) -> bool {
        self.bed_point(x).is_some()
    }

    /// Distance of the nodes between which the surface is interpolated (m); `None` for an analytical surface. A node moves by less than this
    /// distance in a step.
    fn cell(&self) -> Option<f64> {
        None
    }
}

impl<const D: usize, F: Fn(&PlanVector<D>) -> BedPoint<D> + Send + Sync> BedSurface<D> for F {
    fn bed_point(&self, x: &PlanVector<D>) -> Option<BedPoint<D>> {
        Some(self(x))
    }
}

/// Bed of a flow.
#[derive(Clone)]
pub enum Bed<const D: usize> {
    /// Horizontal plane, or the plane of a frame that is tilted with it, at this level (m).
    Flat(f64),
    /// Any other surface.
    Surface(Arc<dyn BedSurface<D>>),
    /// Terrain with erosion.
    Erodible(Box<ErodibleBed>),
}

impl<const D: usize> fmt::Debug for Bed<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Flat(level) => write!(f, "Flat({level})"),
            Self::Surface(_) => f.write_str("Surface"),
            Self::Erodible(_) => f.write_str("Worn"),
        }
    }
}

impl<const D: usize> Bed<D> {
    /// Creates a bed from a formula.
    pub fn formula(formula: impl Fn(&PlanVector<D>) -> BedPoint<D> + Send + Sync + 'static) -> Self {
        Self::Surface(Arc::new(formula))
    }

    /// Bed at a position in plan; `None` outside its extent.
    #[inline]
    pub fn bed_point(&self, x: &PlanVector<D>) -> Option<BedPoint<D>> {
        match self {
            Self::Flat(level) => Some(BedPoint::horizontal(*level)),
            Self::Surface(surface) => surface.bed_point(x),
            Self::Erodible(erodible) => erodible.bed_point(x),
        }
    }

    /// Whether there is a bed at `x`.
    #[inline]
    pub fn is_defined(&self, x: &PlanVector<D>) -> bool {
        match self {
            Self::Flat(_) => true,
            Self::Surface(surface) => surface.is_defined(x),
            Self::Erodible(erodible) => erodible.is_defined(x),
        }
    }

    /// Distance of the nodes between which the bed is interpolated (m); `None` for an analytical bed.
    pub fn cell(&self) -> Option<f64> {
        match self {
            Self::Flat(_) => None,
            Self::Surface(surface) => surface.cell(),
            Self::Erodible(erodible) => erodible.cell(),
        }
    }

    /// Bed below a node; a horizontal one of level zero outside its extent, where nodes remain until the end of the step.
    pub fn bed_below(&self, x: &PlanVector<D>) -> BedPoint<D> {
        self.bed_point(x).unwrap_or(BedPoint::horizontal(0.0))
    }

    /// Erodible bed, where erosion is recorded.
    pub fn erodible(&self) -> Option<&ErodibleBed> {
        if let Self::Erodible(erodible) = self { Some(erodible) } else { None }
    }

    /// Whether velocities are transported between tangent planes: over a bed with slopes, in vertical depths over steep terrain.
    pub(crate) fn transports_velocities(&self, settings: &FlowSettings<D>) -> bool {
        settings.frame == DepthFrame::Horizontal && !self.is_flat()
    }

    /// Whether the bed is horizontal, so that it need not be sampled.
    pub fn is_flat(&self) -> bool {
        matches!(self, Self::Flat(_))
    }
}

/// Paraboloid `Z = a |x - centre|²`: parabola in one dimension, bowl in two.
pub fn paraboloid<const D: usize>(a: f64, centre: PlanVector<D>) -> Bed<D> {
    Bed::formula(move |x: &PlanVector<D>| {
        let from: PlanVector<D> = std::array::from_fn(|c| x[c] - centre[c]);
        let mut point = BedPoint::horizontal(a * dot(&from, &from));
        for c in 0..D {
            point.slope[c] = 2.0 * a * from[c];
            point.curvature[c][c] = 2.0 * a;
        }
        point
    })
}

/// Plane `Z = slope · x`.
pub fn incline<const D: usize>(slope: PlanVector<D>) -> Bed<D> {
    Bed::formula(move |x: &PlanVector<D>| BedPoint { slope, ..BedPoint::horizontal(dot(&slope, x)) })
}

/// Hump `Z = height exp(-|x|²/width²)` at the origin.
pub fn hump<const D: usize>(height: f64, width: f64) -> Bed<D> {
    Bed::formula(move |x: &PlanVector<D>| {
        let square = width * width;
        let level = height * (-dot(x, x) / square).exp();
        let mut point = BedPoint::horizontal(level);
        for c in 0..D {
            point.slope[c] = -2.0 * x[c] / square * level;
            for k in 0..D {
                let own = if c == k { -2.0 / square } else { 0.0 };
                point.curvature[c][k] = (own + 4.0 * x[c] * x[k] / (square * square)) * level;
            }
        }
        point
    })
}

#[cfg(test)]
mod tests {
    use colluvium_points::Raster;

    use super::*;

    /// Checks that slope and curvature are the derivatives of the level.
    fn is_consistent(bed: &Bed<2>, x: [f64; 2]) {
        let step = 1e-5;
        let point = bed.bed_point(&x).unwrap();
        for c in 0..2 {
            let beside = |sign: f64| {
                let mut y = x;
                y[c] += sign * step;
                bed.bed_point(&y).unwrap()
            };
            let (after, before) = (beside(1.0), beside(-1.0));
            let slope = (after.level - before.level) / (2.0 * step);
            assert!((slope - point.slope[c]).abs() < 1e-7, "slope {c}: {slope} for {:?}", point.slope);
            for k in 0..2 {
                let bend = (after.slope[k] - before.slope[k]) / (2.0 * step);
                assert!((bend - point.curvature[c][k]).abs() < 1e-7, "curvature {c} {k}");
            }
        }
    }

    #[test]
    fn formulas_have_their_own_derivatives() {
        for bed in [paraboloid(0.3, [1.0, -2.0]), incline([0.4, -0.2]), hump(0.7, 1.5)] {
            is_consistent(&bed, [0.4, 0.9]);
        }
    }

    #[test]
    fn a_raster_of_a_parabola_is_one_and_ends() {
        let raster = Raster::from_function([21, 11], [-10.0, -5.0], [1.0, 1.0], |x, y| {
            0.3 * ((x - 1.0).powi(2) + (y + 2.0).powi(2))
        });
        let bed = Bed::Surface(Arc::new(TerrainBed::new(raster).unwrap()));
        let (found, exact) = (
            bed.bed_point(&[3.3, 0.8]).unwrap(),
            paraboloid(0.3, [1.0, -2.0]).bed_point(&[3.3, 0.8]).unwrap(),
        );
        assert!((found.level - exact.level).abs() < 1e-12);
        for c in 0..2 {
            assert!((found.slope[c] - exact.slope[c]).abs() < 1e-12);
            assert!((0..2).all(|k| (found.curvature[c][k] - exact.curvature[c][k]).abs() < 1e-11));
        }
        assert_eq!(bed.bed_point(&[10.1, 0.0]), None);
    }

    #[test]
    fn speed_is_that_along_the_bed() {
        let point = incline([3.0f64.sqrt(), 0.0]).bed_point(&[0.0; 2]).unwrap();
        assert!((point.speed(&[1.0, 0.0]) - 2.0).abs() < 1e-14);
        assert!((point.speed(&[0.0, 1.0]) - 1.0).abs() < 1e-14);
        assert!((point.steepness() - 4.0).abs() < 1e-14);
    }
}
