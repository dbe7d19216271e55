//! Reactions of obstacles on the nodes to skeleton and pore fluid.

use colluvium_grid::NodalState;

use crate::background_grid::BackgroundGrid;
use crate::obstacles::reaction::ReactionRecorder;
use crate::phases::momentum::{PhaseEquilibriumTerms, PhaseMasses, PhaseSolve};
use crate::points::pore_fluid::SOLID;

/// Records the reactions of the active nodes in a step, before their solve.
pub(super) fn record_phase_reactions<const D: usize>(
    recorder: &mut ReactionRecorder,
    solve: &PhaseSolve<'_, D>,
    background: &BackgroundGrid<D>,
    nodes: &[[NodalState; 2]],
) {
    recorder.record_nodes(solve.dt, background, solve.walls[SOLID], |index, number, impulses, energies| {
        solve.record_reactions(index, &nodes[number], impulses, &mut energies.friction);
    });
}

impl<const D: usize> PhaseSolve<'_, D> {
    /// Adds the impulses of a node (N s) to the reactions that are recorded, and the energy (J) that friction at obstacles dissipates from
    /// its skeleton. The skeleton transmits the reaction of the liquid.
    fn record_reactions(
        &self,
        index: &[usize; 3],
        node: &[NodalState; 2],
        impulses: &mut [[f64; 3]],
        friction: &mut f64,
    ) {
        let masses = PhaseMasses::of_node(node);
        let faces = self.walls[SOLID].faces().faces_at(index);
        if faces.is_empty() || masses.solid <= self.mass_cutoff[SOLID] {
            return;
        }
        let inertia = self.inertia * masses.solid;
        let mut record = |reaction_index: Option<u8>, change: [f64; 3]| {
            if let Some(number) = reaction_index {
                (0..3).for_each(|c| impulses[usize::from(number)][c] -= inertia * change[c]);
            }
        };
        let motion = node[SOLID].momentum_and_mass.to_array();
        let start: [f64; 3] = std::array::from_fn(|c| if c < D { motion[c] / masses.solid } else { 0.0 });
        let (mut solved, mut tangential_change) = (*node, [0.0; 3]);
        let mut sums = PhaseEquilibriumTerms::default();
        self.solve_node(index, &mut solved, &masses, [0; 2], &mut sums, |face, change, kept| {
            // Points get the change from start to end, which includes the part removed from the start.
            record(face.reaction_index, std::array::from_fn(|c| change[c] - kept[c]));
            let along: f64 = (0..3).map(|c| change[c] * face.normal[c]).sum();
            (0..3).for_each(|c| tangential_change[c] += change[c] - along * face.normal[c]);
        });
        let end = solved[SOLID].momentum_and_mass.to_array();
        *friction -= (0..3).map(|c| 0.5 * inertia * tangential_change[c] * (start[c] + end[c])).sum::<f64>();
    }
}
