//! Distance of a node from the surface of a body. It distinguishes bodies that touch from bodies that only share a node (sheet: mpm P-18:
//! contact detected one cell early).
//!
//! At a node the integrals `∫ N` over the volume and over the surface of a body are known. For a flat surface at the distance `s` from the
//! node they are the running integral of the shape function and the shape function itself, so that their ratio gives `s`; an edge that cuts
//! both by the same share does not change the ratio. Two bodies touch where their outward distances sum to zero.

use colluvium_grid::Basis1d;

/// Number of intervals of the table, a multiple of three, so that the kink of linear shape functions coincides with the end of an interval.
const INTERVALS: usize = 1536;
/// Distances over which the shape function is summed, in cells: the half-width of the widest.
const SUM_RANGE: f64 = 2.0;
/// Number of steps of the sum.
const STEPS: usize = 4000;
/// Number of cells of the line along which shape functions are integrated.
const CELLS: usize = 16;
/// Width of the domain of a point for shape functions that depend on it (cells).
pub const ZERO_WIDTH: f64 = 1e-4;
/// Gap (cells) up to which bodies are in contact, as tolerance for errors of the table.
pub const CONTACT_TOLERANCE: f64 = 1e-3;

/// Distance from a node to a flat surface, from volume and surface of the body at the node.
#[derive(Clone, Debug, Default)]
pub struct SurfaceDistance {
    /// Distance (cells) as a function of volume over volume plus surface, at equal intervals from 0 to 1.
    table: Vec<f64>,
}

impl SurfaceDistance {
    /// Returns the table of a family of shape functions.
    pub fn new(basis: &Basis1d) -> Self {
        let node = basis.nodes(CELLS) / 2;
        let place = basis.coordinate(node, CELLS);
        let weight = |distance: f64| basis.evaluate(place + distance, ZERO_WIDTH, CELLS).weight_of(node);
        let step = 2.0 * SUM_RANGE / STEPS as f64;
        let mut below = 0.0;
        let mut last = 0.0;
        let samples: Vec<(f64, f64)> = (0..=STEPS)
            .map(|k| {
                let distance = k as f64 * step - SUM_RANGE;
                // Round-off at the end of the function would count as the whole volume of the body.
                let here = Some(weight(distance)).filter(|w| *w > 1e-9).unwrap_or(0.0);
                below += 0.5 * step * (last + here);
                last = here;
                (if below > 0.0 { below / (below + here) } else { 0.0 }, distance)
            })
            .collect();
        let lowest = samples.iter().rposition(|s| s.0 <= 0.0).unwrap_or(0);
        let highest = samples.iter().position(|s| s.0 >= 1.0).unwrap_or(STEPS);
        let samples = &samples[lowest..=highest];
        let mut table = Vec::with_capacity(INTERVALS + 1);
        let mut at = 0;
        for k in 0..=INTERVALS {
            let share = k as f64 / INTERVALS as f64;
            while at + 2 < samples.len() && samples[at + 1].0 < share {
                at += 1;
            }
            let [(low, near), (high, far)] = [samples[at], samples[(at + 1).min(samples.len() - 1)]];
            let part = if high > low { ((share - low) / (high - low)).clamp(0.0, 1.0) } else { 0.0 };
            table.push(near + part * (far - near));
        }
        Self { table }
    }

    /// Distance from the node to the surface (cells), negative for a node outside the body. `volume` is `∫ N` over the body divided by the
    /// cell size, `surface` the integral over its surface along the outward normal (m²). A body without a surface near the node has the
    /// same distance to all sides.
    pub fn distance(&self, volume: f64, surface: f64) -> f64 {
        let share = volume / (volume + surface.max(0.0));
        let place = share.clamp(0.0, 1.0) * INTERVALS as f64;
        let at = (place as usize).min(INTERVALS - 1);
        self.table[at] + (place - at as f64) * (self.table[at + 1] - self.table[at])
    }

    /// Overlap of two bodies (cells), negative for a gap, from the volumes and surfaces of [`SurfaceDistance::distance`].
    pub fn overlap(&self, volumes: [f64; 2], surfaces: [f64; 2]) -> f64 {
        self.distance(volumes[0], surfaces[0]) + self.distance(volumes[1], surfaces[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use colluvium_grid::{Basis, ContiguousGimpBasis, CubicSpline, GimpBasis, LinearBasis, QuadraticSpline};

    /// Covered volume and surface of hat functions for a surface at `s` cells, by hand.
    fn hat_function_sums(s: f64) -> (f64, f64) {
        let covered = if s < 0.0 { 0.5 * (1.0 + s) * (1.0 + s) } else { 1.0 - 0.5 * (1.0 - s) * (1.0 - s) };
        (covered, 1.0 - s.abs())
    }

    #[test]
    fn the_distance_of_a_flat_surface_is_recovered() {
        for distance in [
            SurfaceDistance::new(&Basis1d::from_basis::<2, LinearBasis>()),
            SurfaceDistance::new(&Basis1d::from_basis::<3, GimpBasis>()),
        ] {
            for k in -9..=9 {
                let s = 0.1 * f64::from(k);
                let (volume, surface) = hat_function_sums(s);
                // An edge halves both.
                for share in [1.0, 0.5, 1e-3] {
                    let found = distance.distance(share * volume, share * surface);
                    assert!((found - s).abs() < 5e-4, "{s}: {found}");
                }
            }
        }
    }

    fn neighbours_in_contact<const S: usize, B: Basis<S>>() {
        let distance = SurfaceDistance::new(&Basis1d::from_basis::<S, B>());
        let node = B::nodes(CELLS) / 2;
        let place = B::coordinate(node, CELLS);
        let weight = |x: f64| {
            let (first, weights, _) = B::evaluate(place + x, ZERO_WIDTH, CELLS);
            if (first..first + S).contains(&node) { weights[node - first] } else { 0.0 }
        };
        let below = |s: f64| (0..3000).map(|k| weight(s - 1e-3 * (f64::from(k) + 0.5))).sum::<f64>() * 1e-3;
        for k in -7..=7 {
            let s = 0.1 * f64::from(k);
            let shift = 0.05;
            let volumes = |gap: f64| [below(s - 0.5 * gap), 1.0 - below(s + 0.5 * gap)];
            let surfaces = |gap: f64| [weight(s - 0.5 * gap), weight(s + 0.5 * gap)];
            assert!(
                distance.overlap(volumes(-shift), surfaces(-shift)) > CONTACT_TOLERANCE,
                "{}: overlap at {s}",
                B::NAME
            );
            assert!(
                distance.overlap(volumes(shift), surfaces(shift)) < -CONTACT_TOLERANCE,
                "{}: gap at {s}",
                B::NAME
            );
        }
    }

    #[test]
    fn a_gap_of_a_twentieth_cell_is_detected_with_every_shape_function() {
        neighbours_in_contact::<2, LinearBasis>();
        neighbours_in_contact::<3, GimpBasis>();
        neighbours_in_contact::<4, ContiguousGimpBasis>();
        neighbours_in_contact::<3, QuadraticSpline>();
        neighbours_in_contact::<4, CubicSpline>();
    }

    #[test]
    fn a_body_without_a_surface_in_reach_counts_as_far() {
        let distance = SurfaceDistance::new(&Basis1d::from_basis::<2, LinearBasis>());
        assert!(
            (distance.distance(1.0, 0.0) - 1.0).abs() < 1e-3
                && (distance.distance(1.0, -0.3) - 1.0).abs() < 1e-3
        );
        assert!((distance.distance(1e-12, 1.0) + 1.0).abs() < 1e-3);
    }
}
