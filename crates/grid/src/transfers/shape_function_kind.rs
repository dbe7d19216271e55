//! Kinds of shape functions, and the transfers compiled for each.

use std::marker::PhantomData;

use crate::point_domain::{
    ConvectedDomain, ConvectedQuadrilateral, ElementDomain, FixedDomain, ReferenceDomain, RightStretchDomain,
    StretchingDomain,
};
use crate::transfers::CompiledTransfers;
use crate::{
    ContiguousGimpBasis, CpdiBasis, CubicSpline, GimpBasis, LinearBasis, QuadraticSpline, SimplexBasis,
    Transfers,
};

/// Kind of shape functions with the point domains over which they are averaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShapeFunctionKind {
    /// Linear shape functions.
    Linear,
    /// Linear shape functions averaged over domains of constant size (uGIMP).
    Gimp,
    /// Linear shape functions averaged over domains that stretch with the diagonal of the deformation gradient (cpGIMP).
    StretchingGimp,
    /// Linear shape functions averaged over domains that stretch with the diagonal of the right stretch tensor.
    RightStretchGimp,
    /// Quadratic B-splines.
    Quadratic,
    /// Cubic B-splines.
    Cubic,
    /// Linear shape functions at the corners of parallelograms (CPDI).
    Convected,
    /// Linear shape functions at the corners of quadrilaterals (CPDI2); in the plane only.
    ConvectedQuadrilateral,
    /// Linear shape functions at the initial positions (total-Lagrangian).
    ReferenceLinear,
    /// Quadratic B-splines at the initial positions (total-Lagrangian).
    ReferenceQuadratic,
    /// Linear shape functions of triangles or tetrahedra; not in one dimension.
    Elements,
}

macro_rules! for_dimension {
    ($(#[$meta:meta])* $name:ident, $d:literal, $corners:literal $(, $more:ident: $sweeps:expr)*) => {
        $(#[$meta])*
        // Compiled here, since each caller would compile all of them again.
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
        /// Returns the transfers in one dimension; `None` where there are none.
        on_line, 1, 4
    }
    for_dimension! {
        /// Returns the transfers in two dimensions.
        in_plane, 2, 16,
        ConvectedQuadrilateral: &CompiledTransfers::<16, CpdiBasis, ConvectedQuadrilateral>(PhantomData),
        Elements: &CompiledTransfers::<3, SimplexBasis, ElementDomain>(PhantomData)
    }
    for_dimension! {
        /// Returns the transfers in three dimensions; `None` where there are none.
        in_space, 3, 64,
        Elements: &CompiledTransfers::<4, SimplexBasis, ElementDomain>(PhantomData)
    }
}
