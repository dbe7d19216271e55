//! Reactions of obstacles on the nodes: impulses, and the work of friction.

use colluvium_case::{Case, CaseError, Reaction};
use colluvium_grid::{NodalState, NodeWalls};
use serde::{Deserialize, Serialize};

use crate::background_grid::BackgroundGrid;
use crate::momentum::{MomentumSolve, NodeObstacleEnergies};

/// Maximum number of obstacles with recorded reactions: nodes store their index in eight bits.
const MAX_OBSTACLES: usize = 255;

/// Reactions of the obstacles that act on nodes of one velocity field.
#[derive(Clone, Debug, Default)]
pub struct ReactionRecorder {
    /// Names of the obstacles whose reaction the case measures.
    names: Vec<String>,
    /// Workspace for the impulses of a node (N s).
    node_impulses: Vec<[f64; 3]>,
    /// Reactions recorded since the start.
    pub state: Reactions,
}

/// Forces, impulses and energies of the recorded obstacles.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reactions {
    /// Impulse of the last step on each obstacle whose reaction is measured (N s), and the step (s).
    step: (Vec<[f64; 3]>, f64),
    /// Moment of the impulse of the last step about the zero of the coordinates (N m s).
    moments: Vec<[f64; 3]>,
    /// Impulses since the start (N s).
    impulses: Vec<[f64; 3]>,
    /// Energies of all obstacles since the start.
    pub energies: NodeObstacleEnergies,
}

impl ReactionRecorder {
    /// Recorder for the obstacles that the measures of a case name.
    ///
    /// # Errors
    /// Where there are too many.
    pub fn new(case: &Case) -> Result<Self, CaseError> {
        let mut names: Vec<String> = Vec::new();
        for (name, measure) in &case.measures {
            let of = measure
                .reaction_target()
                .filter(|of| case.obstacles.iter().any(|obstacle| obstacle.name == *of))
                .filter(|of| names.iter().all(|name| name != of));
            let Some(of) = of else { continue };
            if names.len() == MAX_OBSTACLES {
                let problem = format!("mpm records the reactions of {MAX_OBSTACLES} obstacles at most");
                return Err(CaseError::new(format!("measures.{name}.target"), problem));
            }
            names.push(of.to_owned());
        }
        let none = vec![[0.0; 3]; names.len()];
        let state = Reactions {
            step: (none.clone(), 0.0),
            moments: none.clone(),
            impulses: none.clone(),
            energies: NodeObstacleEnergies::default(),
        };
        Ok(Self { names, node_impulses: none, state })
    }

    /// Index of an obstacle for its faces; `None` where its reaction is not measured.
    pub fn number(&self, name: &str) -> Option<u8> {
        self.names.iter().position(|known| known == name).and_then(|number| u8::try_from(number).ok())
    }

    /// Reaction of an obstacle; `None` if it is not measured.
    pub fn reaction(&self, name: &str) -> Option<Reaction> {
        let number = usize::from(self.number(name)?);
        let (step, dt) = &self.state.step;
        let rate = |of: [f64; 3]| of.map(|impulse| if *dt > 0.0 { impulse / dt } else { 0.0 });
        let moment = Some(rate(self.state.moments[number]));
        Some(Reaction { force: rate(step[number]), impulse: self.state.impulses[number], moment })
    }

    /// Records the reactions of the active nodes before their solve, in the order of rows, so that sums do not depend on the threads.
    pub fn record<const D: usize>(
        &mut self,
        solve: &MomentumSolve<'_, D>,
        background: &BackgroundGrid<D>,
        nodes: &[NodalState],
    ) {
        self.record_nodes(solve.dt, background, solve.walls, |index, number, impulses, energies| {
            solve.record_reactions(index, &nodes[number], impulses, energies);
        });
    }

    /// Records the reactions of nodes. `bear` adds the impulses (N s) and energies (J) of a node.
    pub fn record_nodes<const D: usize>(
        &mut self,
        dt: f64,
        background: &BackgroundGrid<D>,
        walls: &NodeWalls,
        bear: impl Fn(&[usize; 3], usize, &mut [[f64; 3]], &mut NodeObstacleEnergies),
    ) {
        let Reactions { step, moments, impulses, energies } = &mut self.state;
        let BackgroundGrid { grid, layout, basis_1d: axis, .. } = background;
        step.0.fill([0.0; 3]);
        moments.fill([0.0; 3]);
        step.1 = dt;
        for row in (0..layout.nodes()[0]).filter(|row| !walls.is_row_free(0, *row)) {
            let first = row * layout.strides()[0];
            for number in layout.active_nodes(row) {
                let index = layout.axis_indices(row, number);
                if layout.is_periodic_image(&index) {
                    continue;
                }
                self.node_impulses.fill([0.0; 3]);
                bear(&index, first + number, &mut self.node_impulses, energies);
                let mut place = [0.0; 3];
                for a in 0..D {
                    place[a] = grid.origin[a] + grid.cell * axis.coordinate(index[a], grid.cells[a]);
                }
                for (own, (sum, moment)) in
                    self.node_impulses.iter().zip(step.0.iter_mut().zip(&mut *moments))
                {
                    for c in 0..3 {
                        let (a, b) = ((c + 1) % 3, (c + 2) % 3);
                        sum[c] += own[c];
                        moment[c] += place[a] * own[b] - place[b] * own[a];
                    }
                }
            }
        }
        for (sum, impulse) in impulses.iter_mut().zip(&step.0) {
            (0..3).for_each(|c| sum[c] += impulse[c]);
        }
    }
}
