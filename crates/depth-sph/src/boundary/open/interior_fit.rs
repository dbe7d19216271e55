//! State of the flow before an open side, by lines of least squares.

use crate::boundary::open::boundary_state::{
    BoundaryState, InteriorFit, LineFitSums, outward_and_tangential,
};
use crate::boundary::open::open_boundary::{OpenBoundary, SideRegion};
use crate::kernel::Kernel;
use crate::phases::phase::PhaseSet;
use crate::points::phase_nodes::PlanVector;

impl<const D: usize> OpenBoundary<D> {
    /// Linear fits of the flow at the distance `inside` from each boundary segment (m).
    pub(super) fn fit_interior(
        &self,
        kernel: Kernel,
        sets: &[PhaseSet<D>],
        region: &dyn Fn(&PlanVector<D>) -> SideRegion,
        inside: f64,
    ) -> Vec<Option<InteriorFit>> {
        let mut moments = vec![LineFitSums::default(); self.strips.len()];
        for (number, set) in self.own_sets(sets) {
            let nodes = &set.nodes;
            let depths = self.depths(nodes);
            for i in 0..nodes.len() {
                let (x, length) = (&nodes.position[i], nodes.length[i]);
                let beyond = self.distance_beyond(x);
                let far = (beyond + inside).abs() / length;
                if beyond > 0.0 || far >= kernel.support() || region(x) != SideRegion::Interior {
                    continue;
                }
                let effective_gravity = self.wave_gravity(nodes, i);
                let velocity = outward_and_tangential(&nodes.velocity[i], self.axis, self.outward);
                let around =
                    if D == 1 { 0 } else { (kernel.support() * length / self.spacing).ceil() as isize };
                let own = self.strip(x);
                let off = if D == 1 { 0.0 } else { x[1 - self.axis] - self.strip_middle(own) };
                for step in -around..=around {
                    let Some(strip) = self.neighbour(own, step) else { continue };
                    let apart = (off - step as f64 * self.spacing) / length;
                    let distance = if D == 1 { far } else { far.hypot(apart) };
                    let weight = nodes.volume[i] / depths[i] * kernel.profile::<D>(distance);
                    if weight > 0.0 {
                        let place = beyond + inside;
                        moments[strip].add(
                            weight,
                            place,
                            velocity,
                            depths[i],
                            effective_gravity,
                            kernel.support() * length,
                        );
                        if number == 1 {
                            moments[strip].add_fluid(weight);
                        }
                    }
                }
            }
        }
        moments.iter().map(LineFitSums::interior_fit).collect()
    }

    /// Index of the segment `step` places along the boundary; `None` past its ends.
    fn neighbour(&self, own: usize, step: isize) -> Option<usize> {
        let count = self.strips.len() as isize;
        let strip = own as isize + step;
        if self.periodic {
            return Some(strip.rem_euclid(count) as usize);
        }
        let regular = self.corner_strips[0] as isize..count - self.corner_strips[1] as isize;
        regular.contains(&strip).then_some(strip as usize)
    }

    /// Coordinate of the centre of a segment along the boundary (m).
    fn strip_middle(&self, strip: usize) -> f64 {
        self.low + (strip as f64 + 0.5) * self.spacing
    }

    /// Sets the initial state to the kernel sums of the node lattice, which differ slightly from the given depth.
    pub(crate) fn calibrate_lattice_sum(
        &mut self,
        kernel: Kernel,
        sets: &[PhaseSet<D>],
        region: &dyn Fn(&PlanVector<D>) -> SideRegion,
    ) {
        let found = self.fit_interior(kernel, sets, region, 0.0);
        for (strip, within) in self.strips.iter_mut().zip(found) {
            let whole: f64 = strip.template_nodes.iter().flatten().map(|node| node.volume).sum();
            if let (Some(still), Some(within)) = (&mut strip.far_state, within)
                && whole > 0.0
                && within.depth[0] > 0.0
            {
                let InteriorFit { depth, speed, tangential_speed, porosity, .. } = within;
                *still = BoundaryState { depth: depth[0], speed: speed[0], tangential_speed, porosity };
                strip.width = whole / depth[0];
            }
        }
        self.copy_to_corners();
    }
}
