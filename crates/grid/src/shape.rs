//! The choice of shape functions, and the sweeps that are compiled for each.

use std::marker::PhantomData;

use crate::domain::{
    ConvectedCorners, ConvectedDomain, FixedDomain, InElement, ReferencePoint, StretchingDomain,
    TurningDomain,
};
use crate::sweeps::Of;
use crate::{Corners, CubicSpline, Gimp, Linear, QuadraticSpline, Simplex, Sweeps, WideGimp};

/// Shape functions with the domains of points that they are evaluated over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Hat functions.
    Linear,
    /// Hat functions averaged over domains that keep their size (uGIMP).
    Gimp,
    /// The same over domains that stretch with the diagonal of the deformation gradient (cpGIMP).
    StretchingGimp,
    /// The same over domains that stretch with the diagonal of the right stretch tensor.
    TurningGimp,
    /// Quadratic B-splines.
    Quadratic,
    /// Cubic B-splines.
    Cubic,
    /// Hat functions at the corners of parallelograms (CPDI).
    Convected,
    /// Hat functions at the corners of quadrilaterals (CPDI2); in the plane only.
    ConvectedCorners,
    /// Hat functions of the places at the start (total-Lagrangian).
    ReferenceLinear,
    /// Quadratic B-splines of the places at the start.
    ReferenceQuadratic,
    /// Triangles or tetrahedra; not in one dimension.
    Elements,
}

macro_rules! in_space {
    ($(#[$meta:meta])* $name:ident, $d:literal, $corners:literal $(, $more:ident: $sweeps:expr)*) => {
        $(#[$meta])*
        // Compiled here: what calls it would compile each of them again.
        #[inline(never)]
        pub fn $name(self) -> Option<&'static dyn Sweeps<$d>> {
            Some(match self {
                Self::Linear => &Of::<2, Linear, FixedDomain>(PhantomData),
                Self::Gimp => &Of::<3, Gimp, FixedDomain>(PhantomData),
                Self::StretchingGimp => &Of::<4, WideGimp, StretchingDomain<$d>>(PhantomData),
                Self::TurningGimp => &Of::<4, WideGimp, TurningDomain<$d>>(PhantomData),
                Self::Quadratic => &Of::<3, QuadraticSpline, FixedDomain>(PhantomData),
                Self::Cubic => &Of::<4, CubicSpline, FixedDomain>(PhantomData),
                Self::Convected => &Of::<$corners, Corners, ConvectedDomain<$d>>(PhantomData),
                Self::ReferenceLinear => &Of::<2, Linear, ReferencePoint<$d>>(PhantomData),
                Self::ReferenceQuadratic => &Of::<3, QuadraticSpline, ReferencePoint<$d>>(PhantomData),
                $(Self::$more => $sweeps,)*
                #[allow(unreachable_patterns, reason = "the plane has them all")]
                _ => return None,
            })
        }
    };
}

impl Shape {
    in_space! {
        /// The sweeps in one dimension; `None` where there are none.
        on_line, 1, 4
    }
    in_space! {
        /// The sweeps in two dimensions.
        in_plane, 2, 16,
        ConvectedCorners: &Of::<16, Corners, ConvectedCorners>(PhantomData),
        Elements: &Of::<3, Simplex, InElement>(PhantomData)
    }
    in_space! {
        /// The sweeps in three dimensions; `None` where there are none.
        in_space, 3, 64,
        Elements: &Of::<4, Simplex, InElement>(PhantomData)
    }
}
