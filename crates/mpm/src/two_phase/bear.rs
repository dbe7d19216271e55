//! What obstacles on the nodes bear of skeleton and pore fluid.

use colluvium_grid::Node;

use super::momentum::{Masses, PhaseSolve, PhaseSums};
use crate::background::Background;
use crate::obstacles::borne::Bearing;
use crate::pore::SOLID;

/// Takes what the surfaces do in a step to the active nodes, before that is solved.
pub(super) fn bear_phases<const D: usize>(
    bearing: &mut Bearing,
    solve: &PhaseSolve<'_, D>,
    background: &Background<D>,
    nodes: &[[Node; 2]],
) {
    bearing.take_nodes(solve.dt, background, solve.walls[SOLID], |index, number, impulses, energies| {
        solve.bear(index, &nodes[number], impulses, &mut energies.friction);
    });
}

impl<const D: usize> PhaseSolve<'_, D> {
    /// Adds the impulses of a node that is not solved yet on the obstacles that are told apart (N s), and the energy that friction
    /// takes from its skeleton at any of them (J). The skeleton hands on what the obstacle does to the liquid.
    fn bear(&self, index: &[usize; 3], node: &[Node; 2], impulses: &mut [[f64; 3]], friction: &mut f64) {
        let masses = Masses::of(node);
        let faces = self.walls[SOLID].faces().at(index);
        if faces.is_empty() || masses.solid <= self.light[SOLID] {
            return;
        }
        let inertia = self.inertia * masses.solid;
        let mut tell = |bearer: Option<u8>, change: [f64; 3]| {
            if let Some(number) = bearer {
                (0..3).for_each(|c| impulses[usize::from(number)][c] -= inertia * change[c]);
            }
        };
        let motion = node[SOLID].motion.to_array();
        let begun: [f64; 3] = std::array::from_fn(|c| if c < D { motion[c] / masses.solid } else { 0.0 });
        let (mut solved, mut rubbed) = (*node, [0.0; 3]);
        let mut sums = PhaseSums::default();
        self.node(index, &mut solved, &masses, [0; 2], &mut sums, |face, change, kept| {
            // Points get the change from start to end: what is taken off the start comes back to them.
            tell(face.bearer, std::array::from_fn(|c| change[c] - kept[c]));
            let along: f64 = (0..3).map(|c| change[c] * face.normal[c]).sum();
            (0..3).for_each(|c| rubbed[c] += change[c] - along * face.normal[c]);
        });
        let end = solved[SOLID].motion.to_array();
        *friction -= (0..3).map(|c| 0.5 * inertia * rubbed[c] * (begun[c] + end[c])).sum::<f64>();
    }
}
