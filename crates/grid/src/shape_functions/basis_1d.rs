//! Shape functions of one axis, chosen at run time for code outside the compiled transfers.

use crate::Basis;

/// Largest number of nodes of a point along an axis.
const MAX_NODES: usize = 4;

/// Properties of a [`Basis`] that are known at run time.
#[derive(Clone, Copy, Debug)]
pub struct Basis1d {
    /// Name of the family.
    pub name: &'static str,
    /// Number of node layers outside the domain at each end.
    pub ghosts: usize,
    /// Number of nodes in the support of a point below the lower node of its cell.
    pub nodes_below: usize,
    /// Number of nodes in the support of a point above the lower node of its cell.
    pub nodes_above: usize,
    /// Whether fixed nodes on a grid line inside the domain also fix the material there.
    pub allows_interior_walls: bool,
    nodes: fn(usize) -> usize,
    coordinate: fn(usize, usize) -> f64,
    evaluate: fn(f64, f64, usize) -> BasisValues1d,
}

/// Nodes of a point along an axis, with weights and gradients.
#[derive(Clone, Copy, Debug)]
pub struct BasisValues1d {
    /// Index of the first node with a non-zero weight.
    pub first: usize,
    /// Number of nodes.
    pub count: usize,
    weights: [f64; MAX_NODES],
    gradients: [f64; MAX_NODES],
}

impl BasisValues1d {
    /// Weights of the nodes.
    pub fn weights(&self) -> &[f64] {
        &self.weights[..self.count]
    }

    /// Gradients of the nodes (per cell).
    pub fn gradients(&self) -> &[f64] {
        &self.gradients[..self.count]
    }

    /// Weight of a node, zero outside the support.
    pub fn weight_of(&self, node: usize) -> f64 {
        node.checked_sub(self.first).and_then(|k| self.weights().get(k)).copied().unwrap_or(0.0)
    }
}

impl Basis1d {
    /// Returns the properties of a basis.
    pub fn from_basis<const S: usize, B: Basis<S>>() -> Self {
        Self {
            name: B::NAME,
            ghosts: B::GHOSTS,
            nodes_below: B::NODES_BELOW,
            nodes_above: B::NODES_ABOVE,
            allows_interior_walls: B::ALLOWS_INTERIOR_WALLS,
            nodes: B::nodes,
            coordinate: B::coordinate,
            evaluate: |x, width, cells| {
                let (first, w, g) = B::evaluate(x, width, cells);
                let four = |values: [f64; S]| std::array::from_fn(|k| values.get(k).copied().unwrap_or(0.0));
                // A basis with more nodes in total, at the corners of its domain, has two along an axis.
                BasisValues1d { first, count: S.min(MAX_NODES), weights: four(w), gradients: four(g) }
            },
        }
    }

    /// Number of nodes with `cells` cells, ghosts included.
    pub fn nodes(&self, cells: usize) -> usize {
        (self.nodes)(cells)
    }

    /// Coordinate of a node in cells from the lower end; for splines the Greville abscissa.
    pub fn coordinate(&self, index: usize, cells: usize) -> f64 {
        (self.coordinate)(index, cells)
    }

    /// Nodes at `x`, for a point of full width `width` (both in cells).
    pub fn evaluate(&self, x: f64, width: f64, cells: usize) -> BasisValues1d {
        (self.evaluate)(x, width, cells)
    }

    /// Index of the nodes on the face between cells `face - 1` and `face` of `cells` cells.
    pub fn face_node(&self, face: usize, cells: usize) -> usize {
        if face == cells { self.nodes(cells) - 1 - self.ghosts } else { face + self.ghosts }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CubicSpline, LinearBasis};

    #[test]
    fn a_runtime_basis_equals_its_compile_time_basis() {
        let axis = Basis1d::from_basis::<4, CubicSpline>();
        let (first, w, g) = CubicSpline::evaluate(3.3, 0.1, 9);
        let on = axis.evaluate(3.3, 0.1, 9);
        assert_eq!((on.first, on.weights(), on.gradients()), (first, &w[..], &g[..]));
        assert_eq!((on.weight_of(first + 3), on.weight_of(first + 4), on.weight_of(0)), (w[3], 0.0, 0.0));
        assert_eq!(
            (axis.nodes(9), axis.coordinate(5, 9)),
            (CubicSpline::nodes(9), CubicSpline::coordinate(5, 9))
        );
        assert_eq!(Basis1d::from_basis::<2, LinearBasis>().evaluate(0.25, 1.0, 2).weights(), [0.75, 0.25]);
    }
}
