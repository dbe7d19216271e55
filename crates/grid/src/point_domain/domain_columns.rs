//! Columns of the point domains of a body, of any kind.

use std::borrow::Cow;
use std::ops::Range;

use crate::point_domain::{
    ConvectedDomain, ConvectedQuadrilateral, ElementDomain, FixedDomain, GridView, PointDomain,
    ReferenceDomain, RightStretchDiagonal, RightStretchDomain, SquareMatrix, StretchingDomain,
};
use crate::{CpdiBasis, Vector4};

/// Functions of [`PointDomain`] that relate a type to its variant.
macro_rules! domain_column {
    ($kind:ident) => {
        /// Domains of a body as the type of this kind.
        #[inline(always)]
        fn typed_column<'a>(column: &crate::point_domain::DomainSlice<'a, D>) -> &'a [Self] {
            match column {
                crate::point_domain::DomainSlice::$kind(domains) => domains,
                _ => unreachable!("a body has domains of the kind of its sweeps"),
            }
        }

        /// Domains of `count` points, each with its default.
        fn new_column(count: usize) -> crate::point_domain::Domains<D> {
            crate::point_domain::Domains::$kind(vec![Self::default(); count])
        }
    };
}
pub(super) use domain_column;

macro_rules! domain_kinds {
    ($($(#[$meta:meta])* $kind:ident: $type:ty,)+) => {
        /// Domains of the points of a body, in the order of the points.
        #[derive(Clone, Debug, PartialEq)]
        pub enum Domains<const D: usize> {
            $($(#[$meta])* $kind(Vec<$type>),)+
        }

        /// Read-only view of the domains of several points.
        #[derive(Clone, Copy, Debug)]
        pub enum DomainSlice<'a, const D: usize> {
            $($(#[$meta])* $kind(&'a [$type]),)+
        }

        /// Mutable view of the domains of several points.
        #[derive(Debug)]
        pub enum DomainsMut<'a, const D: usize> {
            $($(#[$meta])* $kind(&'a mut [$type]),)+
        }

        impl<const D: usize> Domains<D> {
            /// View of all domains.
            #[inline(always)]
            pub fn as_slice(&self) -> DomainSlice<'_, D> {
                match self { $(Self::$kind(domains) => DomainSlice::$kind(domains),)+ }
            }

            /// All domains, mutably borrowed.
            #[inline(always)]
            pub fn as_mut(&mut self) -> DomainsMut<'_, D> {
                match self { $(Self::$kind(domains) => DomainsMut::$kind(domains),)+ }
            }

            /// Sorts the domains, so that domain `i` was domain `order[i]`; those that are not in `order` are removed.
            pub fn reorder(&mut self, order: &[u32]) {
                match self {
                    $(Self::$kind(domains) => *domains = order.iter().map(|&i| domains[i as usize]).collect(),)+
                }
            }

            /// Moves the domains of `other`, of the same kind, to the end.
            pub fn append(&mut self, other: &mut Self) {
                match (self, other) {
                    $((Self::$kind(domains), Self::$kind(other)) => domains.append(other),)+
                    _ => unreachable!("a body has domains of the kind of its sweeps"),
                }
            }

            /// Restores the domains of `count` points from the numbers of [`Domains::checkpoint_numbers`]; `None` for a wrong number.
            pub fn restore(&mut self, numbers: &[f64], count: usize, right_stretch: RightStretchDiagonal<D>) -> Option<()> {
                match self {
                    $(Self::$kind(domains) => *domains = restore_domains(numbers, count, right_stretch)?,)+
                }
                Some(())
            }

            /// Whether the domains change during a run.
            pub fn stretch(&self) -> bool {
                match self { $(Self::$kind(_) => <$type as PointDomain<D>>::DEFORMS,)+ }
            }

            /// Whether shape functions are evaluated at the initial positions of the points.
            pub fn are_anchored(&self) -> bool {
                match self { $(Self::$kind(_) => <$type as PointDomain<D>>::REFERENCE_CONFIGURATION,)+ }
            }

            /// Memory of a domain (bytes).
            pub fn size(&self) -> usize {
                match self { $(Self::$kind(_) => size_of::<$type>(),)+ }
            }
        }

        impl<'a, const D: usize> DomainSlice<'a, D> {
            /// Domains of a range of points.
            #[inline(always)]
            #[must_use]
            pub fn range(&self, points: Range<usize>) -> Self {
                match self { $(Self::$kind(domains) => Self::$kind(&domains[points]),)+ }
            }
        }

        impl<'a, const D: usize> DomainsMut<'a, D> {
            /// Read-only view of the domains.
            #[inline(always)]
            pub fn as_slice(&self) -> DomainSlice<'_, D> {
                match self { $(Self::$kind(domains) => DomainSlice::$kind(domains),)+ }
            }

            /// Splits off the first `count` domains, or all if there are fewer.
            #[inline(always)]
            #[must_use]
            pub fn split_off_front(&mut self, count: usize) -> Self {
                match self {
                    $(Self::$kind(domains) => {
                        let count = count.min(domains.len());
                        Self::$kind(domains.split_off_mut(..count).unwrap_or_default())
                    })+
                }
            }
        }

        /// Evaluates an expression with the column of any kind.
        macro_rules! each {
            ($of:ident, $this:expr, $domains:ident => $value:expr) => {
                match $this { $($of::$kind($domains) => $value,)+ }
            };
        }
    };
}

domain_kinds! {
    /// Domains of constant size.
    Fixed: FixedDomain,
    /// Domains that stretch with the diagonal of the deformation gradient.
    Stretching: StretchingDomain<D>,
    /// Domains that stretch with the diagonal of the right stretch tensor.
    Turning: RightStretchDomain<D>,
    /// Parallelograms.
    Convected: ConvectedDomain<D>,
    /// Quadrilaterals.
    Corners: ConvectedQuadrilateral,
    /// Initial positions.
    Reference: ReferenceDomain<D>,
    /// Elements of a mesh.
    Elements: ElementDomain,
}

/// Domains of the numbers in a checkpoint; `None` if their number does not fit.
fn restore_domains<const D: usize, P: PointDomain<D>>(
    numbers: &[f64],
    count: usize,
    right_stretch: RightStretchDiagonal<D>,
) -> Option<Vec<P>> {
    if numbers.len() != count * P::CHECKPOINT_NUMBERS {
        return None;
    }
    Some(match P::CHECKPOINT_NUMBERS {
        0 => vec![P::default(); count],
        width => numbers.chunks(width).map(|numbers| P::from_numbers(numbers, right_stretch)).collect(),
    })
}

impl<const D: usize> Domains<D> {
    /// Determines the domains in the initial state.
    ///
    /// # Errors
    /// Index of the first point without a domain, with the reason.
    pub fn initialise(
        &mut self,
        ground: &GridView<'_, D>,
        position: &[[f64; D]],
    ) -> Result<(), (usize, String)> {
        each!(Self, self, domains => {
            for (p, (domain, position)) in domains.iter_mut().zip(position).enumerate() {
                domain.initialise(ground, position).map_err(|reason| (p, reason))?;
            }
        });
        Ok(())
    }

    /// Positions at which shape functions of points at `position` are evaluated (m).
    pub fn evaluation_positions<'a>(&self, position: &'a [[f64; D]]) -> Cow<'a, [[f64; D]]> {
        if self.are_anchored() {
            each!(Self, self, domains => {
                domains.iter().zip(position).map(|(domain, x)| domain.evaluation_position(x)).collect()
            })
        } else {
            Cow::Borrowed(position)
        }
    }

    /// Memory of all domains (bytes).
    pub fn bytes(&self) -> usize {
        each!(Self, self, domains => size_of_val(&domains[..]))
    }

    /// Numbers of the domains for a checkpoint.
    pub fn checkpoint_numbers(&self) -> Vec<f64> {
        let mut numbers = Vec::new();
        each!(Self, self, domains => {
            domains.iter().for_each(|domain| PointDomain::<D>::append_numbers(*domain, &mut numbers));
        });
        numbers
    }
}

impl<const D: usize> DomainSlice<'_, D> {
    /// Indices of the cells at positions (m): the number of the lowest node of each cell, or of the mesh element.
    #[inline]
    pub fn cells(&self, ground: &GridView<'_, D>, position: &[[f64; D]], cells: &mut [usize]) {
        each!(DomainSlice, self, domains => {
            for ((domain, position), cell) in domains.iter().zip(position).zip(cells) {
                *cell = domain.cell(ground, position);
            }
        });
    }

    /// Cell index of one point.
    #[inline]
    pub fn cell(&self, point: usize, ground: &GridView<'_, D>, position: &[f64; D]) -> usize {
        each!(DomainSlice, self, domains => domains[point].cell(ground, position))
    }

    /// Least node spacing around a point (m).
    #[inline(always)]
    pub fn spacing(&self, point: usize, ground: &GridView<'_, D>) -> f64 {
        match self {
            Self::Elements(domains) => domains[point].spacing(ground),
            _ => ground.grid.cell,
        }
    }

    /// Full widths of a point domain (m), from its initial widths and the cell size (m).
    #[inline(always)]
    pub fn extent(&self, point: usize, initial: &[f64; D], cell: f64) -> [f64; D] {
        each!(DomainSlice, self, domains => domains[point].extent(initial, cell))
    }

    /// First point with an invalid domain, and the reason.
    #[inline]
    pub fn first_invalid(&self, initial: &[f64; D], cell: f64) -> Option<(usize, String)> {
        each!(DomainSlice, self, domains => {
            let mut faults = domains.iter().enumerate();
            faults.find_map(|(p, domain)| domain.validity_error(initial, cell).map(|reason| (p, reason)))
        })
    }
}

impl<const D: usize> DomainsMut<'_, D> {
    /// Whether the domains change with the deformation of the points.
    #[inline(always)]
    pub fn are_deformable(&self) -> bool {
        !matches!(self, Self::Fixed(_))
    }

    /// Updates the domains with the deformation gradient `f = 1 + gradient` of each point in the step (row `i`, column `j`: `∂u_i/∂x_j`).
    #[inline]
    pub fn update_deformation(
        &mut self,
        gradients: &[SquareMatrix<D>],
        right_stretch: RightStretchDiagonal<D>,
    ) {
        each!(DomainsMut, self, domains => {
            domains.iter_mut().zip(gradients).for_each(|(domain, f)| domain.update_deformation(f, right_stretch));
        });
    }

    /// Updates the element of a point after a move; has an effect on a mesh only.
    ///
    /// # Errors
    /// When the point is in no element, as a reason.
    #[inline(always)]
    pub fn relocate(
        &mut self,
        point: usize,
        ground: &GridView<'_, D>,
        position: &[f64; D],
    ) -> Result<(), String> {
        match self {
            Self::Elements(domains) => domains[point].relocate(ground, position),
            _ => Ok(()),
        }
    }

    /// Moves the corners of convected domains in a step of `dt` (s). `velocity`, `position` and `initial` are those of the points (m/s, m,
    /// m), and `of` gives the velocity of a node (m/s).
    #[inline]
    pub fn advect_corners(
        &mut self,
        ground: &GridView<'_, D>,
        position: &[[f64; D]],
        initial: &[f64; D],
        velocity: impl Fn(usize) -> [f64; D],
        dt: f64,
        of: impl Fn(usize) -> Vector4,
    ) {
        let Self::Corners(domains) = self else { return };
        for (p, (domain, position)) in domains.iter_mut().zip(position).enumerate() {
            domain.advect_corners(position, initial, &velocity(p), dt, |place| {
                let velocity = CpdiBasis::interpolate_linear(ground.grid, place, &of);
                std::array::from_fn(|c| velocity.as_array()[c])
            });
        }
    }
}
