//! Onset of a band: the plane on which the intact band yields first, or on which the surroundings lose ellipticity.

use crate::laws::double_scale::{BandSurroundings, DoubleScale, Onset};
use crate::localisation::least_isotropic_ellipticity;
use crate::{InterfaceLaw, Mat3, Motion, Point, Spectrum, SymTensor};

impl<B: InterfaceLaw, M: BandSurroundings> DoubleScale<B, M> {
    /// Yield value of an intact band (Pa) on the plane closest to yield, and `cos 2α` of that plane.
    pub(super) fn intact_yield(&self, stress: &SymTensor) -> (f64, f64) {
        let [highest, _, lowest] = stress.principal_values();
        self.plane(highest, lowest)
    }

    /// Onset function (Pa) and slope of the critical plane, from the highest and lowest principal stress (Pa).
    fn plane(&self, highest: f64, lowest: f64) -> (f64, f64) {
        match self.onset {
            Onset::BandYield => self.band.critical_plane(highest, lowest),
            Onset::Rankine => (highest - self.band.tensile_strength(), 1.0),
            Onset::Ellipticity => (f64::NEG_INFINITY, 1.0),
        }
    }

    /// Frame of the band that forms in a step from `old` to the intact stress `trial`; `None` if the point remains intact.
    pub(super) fn onset(
        &self,
        old: &Point<M::State>,
        trial: &Point<M::State>,
        strain: &SymTensor,
        motion: &Motion,
    ) -> Option<Mat3> {
        if self.onset == Onset::Ellipticity {
            return self.bifurcation(old, trial, strain, motion);
        }
        self.first_yield_plane(&old.stress, &trial.stress, strain, motion)
    }

    /// Plane on which the yield value of the intact band first becomes positive between `old` and `trial`. It does not depend on the length
    /// of the step.
    fn first_yield_plane(
        &self,
        old: &SymTensor,
        trial: &SymTensor,
        strain: &SymTensor,
        motion: &Motion,
    ) -> Option<Mat3> {
        if !(self.intact_yield(trial).0 > 16.0 * f64::EPSILON * trial.norm()) {
            return None;
        }
        let on_the_way = |share: f64| *old + (*trial - *old) * share;
        let (mut below, mut above) = (0.0, 1.0);
        while above - below > f64::EPSILON {
            let middle = 0.5 * (below + above);
            if self.intact_yield(&on_the_way(middle)).0 > 0.0 {
                above = middle;
            } else {
                below = middle;
            }
        }
        let spectrum = on_the_way(above).spectrum();
        let [highest, _, lowest] = spectrum.values;
        let (_, cosine) = self.plane(highest, lowest);
        Some(conjugate_plane_frame(&spectrum, cosine, strain, motion))
    }

    /// Plane on which the yielding surroundings have lost ellipticity.
    fn bifurcation(
        &self,
        old: &Point<M::State>,
        trial: &Point<M::State>,
        strain: &SymTensor,
        motion: &Motion,
    ) -> Option<Mat3> {
        let elastic = old.stress + self.elasticity().stress(strain);
        if (elastic - trial.stress).norm() <= 1e-12 * elastic.norm() {
            return None;
        }
        let tangent = self.outside.tangent(strain, motion, old)?;
        let spectrum = elastic.spectrum();
        let found = least_isotropic_ellipticity(&tangent, &spectrum.rotation());
        if found.determinant > 0.0 {
            return None;
        }
        let [along, across, aside] = Mat3(spectrum.directions).apply(found.normal);
        // The plane that is lost first contains the intermediate direction.
        let length = along.hypot(aside);
        if length <= across {
            return None;
        }
        let cosine = (along * along - aside * aside) / (length * length);
        Some(conjugate_plane_frame(&spectrum, cosine, strain, motion))
    }
}

/// Frame of the plane with `cos 2α = cosine` between the extreme principal directions. Of the two conjugate planes it has the larger shear
/// strain or opening; the spin decides if both are equal.
fn conjugate_plane_frame(spectrum: &Spectrum, cosine: f64, strain: &SymTensor, motion: &Motion) -> Mat3 {
    let [first, second, third] = spectrum.directions;
    let across = |v: [f64; 3]| (0..3).map(|i| first[i] * v[i]).sum::<f64>();
    let strained = across(strain.apply(third));
    let spin = across(motion.velocity_gradient_dt.skew().apply(third));
    // Planes at 45° have equal shear; one of them opens more.
    let sign = if (cosine * strained).abs() > 1e-6 * strain.norm() {
        -cosine * strained
    } else if strained.abs() > 1e-6 * strain.norm() {
        strained
    } else {
        spin
    };
    let along = (0.5 * (1.0 + cosine)).sqrt();
    let aside = (0.5 * (1.0 - cosine)).sqrt().copysign(sign);
    frame_between(first, third, second, along, aside)
}

/// Frame of a plane whose normal has the components `along` and `aside` in the directions `first` and `third`.
fn frame_between(first: [f64; 3], third: [f64; 3], second: [f64; 3], along: f64, aside: f64) -> Mat3 {
    let normal = std::array::from_fn(|i| along * first[i] + aside * third[i]);
    let tangent = std::array::from_fn(|i| along * third[i] - aside * first[i]);
    Mat3([normal, tangent, second])
}
