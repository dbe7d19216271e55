//! The choice of shape functions, and the sweeps that are compiled for each.

use std::marker::PhantomData;

use crate::domain::{
    ConvectedDomain, ConvectedQuadrilateral, ElementDomain, FixedDomain, ReferenceDomain, RightStretchDomain,
    StretchingDomain,
};
use crate::transfers::CompiledTransfers;
use crate::{
    ContiguousGimpBasis, CpdiBasis, CubicSpline, GimpBasis, LinearBasis, QuadraticSpline, SimplexBasis,
    Transfers,
};

/// Shape functions with the domains of points that they are evaluated over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShapeFunctionKind {
    /// Hat functions.
    Linear,
    /// Hat functions averaged over domains that keep their size (uGIMP).
    Gimp,
    /// The same over domains that stretch with the diagonal of the deformation gradient (cpGIMP).
    StretchingGimp,
    /// The same over domains that stretch with the diagonal of the right stretch tensor.
    RightStretchGimp,
    /// Quadratic B-splines.
    Quadratic,
    /// Cubic B-splines.
    Cubic,
    /// Hat functions at the corners of parallelograms (CPDI).
    Convected,
    /// Hat functions at the corners of quadrilaterals (CPDI2); in the plane only.
    ConvectedQuadrilateral,
    /// Hat functions of the places at the start (total-Lagrangian).
    ReferenceLinear,
    /// Quadratic B-splines of the places at the start.
    ReferenceQuadratic,
    /// Triangles or tetrahedra; not in one dimension.
    Elements,
}

macro_rules! for_dimension {
    ($(#[$meta:meta])* $name:ident, $d:literal, $corners:literal $(, $more:ident: $sweeps:expr)*) => {
        $(#[$meta])*
        // Compiled here: what calls it would compile each of them again.
        #[inline(never)]
        pub fn $name(self) -> Option<&'static dyn Transfers<$d>> {
            Some(match self {
                Self::Linear => &CompiledTransfers::<2, LinearBasis, FixedDomain>(PhantomData),
                Self::Gimp => &CompiledTransfers::<3, GimpBasis, FixedDomain>(PhantomData),
                Self::StretchingGimp => &CompiledTransfers::<4, ContiguousGimpBasis, StretchingDomain<$d>>(PhantomData),
                Self::RightStretchGimp => &CompiledTransfers::<4, ContiguousGimpBasis, RightStretchDomain<$d>>(PhantomData),
                Self::Quadratic => &CompiledTransfers::<3, QuadraticSpline, FixedDomain>(PhantomData),
                Self::Cubic => &CompiledTransfers::<4, CubicSpline, FixedDomain>(PhantomData),
                Self::Convected => &CompiledTransfers::<$corners, CpdiBasis, ConvectedDomain<$d>>(PhantomData),
                Self::ReferenceLinear => &CompiledTransfers::<2, LinearBasis, ReferenceDomain<$d>>(PhantomData),
                Self::ReferenceQuadratic => &CompiledTransfers::<3, QuadraticSpline, ReferenceDomain<$d>>(PhantomData),
                $(Self::$more => $sweeps,)*
                #[allow(unreachable_patterns, reason = "the plane has them all")]
                _ => return None,
            })
        }
    };
}

impl ShapeFunctionKind {
    for_dimension! {
        /// The sweeps in one dimension; `None` where there are none.
        on_line, 1, 4
    }
    for_dimension! {
        /// The sweeps in two dimensions.
        in_plane, 2, 16,
        ConvectedQuadrilateral: &CompiledTransfers::<16, CpdiBasis, ConvectedQuadrilateral>(PhantomData),
        Elements: &CompiledTransfers::<3, SimplexBasis, ElementDomain>(PhantomData)
    }
    for_dimension! {
        /// The sweeps in three dimensions; `None` where there are none.
        in_space, 3, 64,
        Elements: &CompiledTransfers::<4, SimplexBasis, ElementDomain>(PhantomData)
    }
}
