//! Nodes that a program adds or removes between two steps.

use std::ops::Range;

use colluvium_case::{CaseError, GRAIN_COLUMNS, PointList, removed_points};

use crate::NAME;
use crate::config::choices::Phases;
use crate::points::phase_nodes::NewNode;
use crate::setup::body_nodes::{assign_to_phases, new_node};
use crate::solver::DepthSolver;
use colluvium_case::CaseErrorKind;

impl<const D: usize> DepthSolver<D> {
    /// Adds nodes to a body, by its index in [`colluvium_case::Case::bodies`], between two steps. Positions (m) are those in plan, relative
    /// to the origin of the domain; volumes are those of the flow with all its phases (m³; m² in a profile). Without velocities the nodes
    /// have that of the body. In a single phase masses take the place of volumes. Depths follow in the next step. The energy of the nodes
    /// counts as inflow. Returns the numbers of the nodes, which no other nodes have had.
    ///
    /// # Errors
    /// An invalid value of the list, by its path; a position outside the domain in plan or beyond the bed; stresses or pore pressures, or
    /// masses of several phases; a body that has been removed; depths by rates (`continuity`). The state is then unchanged.
    pub fn add_points(&mut self, body: u32, points: &PointList) -> Result<Range<u64>, CaseError> {
        let number = body as usize;
        self.case.check_added_points(number, points, D)?;
        points.reject_columns(&GRAIN_COLUMNS, NAME)?;
        self.check_growth(number, points)?;
        let mut sets = vec![Vec::new(); self.flow.nodes.sets.len()];
        let nodes = self.nodes_of_list(number, points)?;
        assign_to_phases(&self.options, &mut sets, nodes, &self.case.bodies[number]);
        self.flow.begin_program_change();
        self.limit = None;
        let flow = &mut self.flow;
        let first = flow.nodes.next_id;
        let area = self.options.spacing.powi(D as i32);
        let gravity = flow.settings.total_gravity();
        for (number, added) in sets.iter().enumerate() {
            for node in added {
                flow.nodes.add(number, node, node.volume / area, gravity);
            }
        }
        Ok(first..flow.nodes.next_id)
    }

    /// Removes nodes, by their numbers, between two steps. Their energy counts as negative inflow.
    ///
    /// # Errors
    /// A number that no node has, and a node behind an inflow or an open boundary. The state is then unchanged.
    pub fn remove_points(&mut self, ids: &[u64]) -> Result<(), CaseError> {
        let removed = removed_points(ids, self.nodes().id().iter().copied())?;
        if let Some(index) = ids.iter().position(|id| self.flow.boundary.is_outside(*id)) {
            let problem = "is a node outside the flow, which an inflow or an open boundary moves";
            return Err(CaseError::new(format!("ids[{index}]"), problem));
        }
        self.flow.begin_program_change();
        self.limit = None;
        self.flow.nodes.remove_where(|nodes, i| removed.contains(&nodes.id[i]));
        Ok(())
    }

    /// Checks that nodes with these properties can be added to a body.
    fn check_growth(&self, body: usize, points: &PointList) -> Result<(), CaseError> {
        let refuse = |path: &str, problem: &str| Err(CaseError::new(path, problem));
        let name = &self.case.bodies[body].name;
        if self.case.is_removed(name, self.stage) {
            return refuse("body", &format!("{name:?} has been removed"));
        }
        if self.flow.settings.numerics.continuity.is_rate() {
            let problem = "integrates depths, and nodes cannot be added: use `summation`";
            return refuse(&format!("methods.{NAME}.continuity"), problem);
        }
        if points.stresses.is_some() {
            return refuse("points.stresses", "depth-integrated flow has no stress");
        }
        if points.pore_pressures.is_some() {
            return refuse("points.pore_pressures", "added nodes begin with the pore pressure of an inflow");
        }
        if points.masses.is_some() && self.options.phases != Phases::One {
            return refuse("points.masses", "are those of several phases: give volumes only");
        }
        Ok(())
    }

    /// Nodes at the points of a list; an error for a point beyond the bed.
    fn nodes_of_list(&self, number: usize, points: &PointList) -> Result<Vec<NewNode<D>>, CaseError> {
        let density = self.flow.settings.set_density(1, 0);
        let node = |(i, x): (usize, &[f64; 3])| {
            let position = std::array::from_fn(|c| x[c]);
            if !self.flow.bed.is_defined(&position) {
                let problem = format!("{position:?} m is beyond the end of the bed");
                return Err(CaseError::new(
                    format!("points.positions[{i}]"),
                    CaseErrorKind::coded("outside-domain", problem),
                ));
            }
            let volume = points.masses.as_ref().map_or(points.volumes[i], |masses| masses[i] / density);
            let mut node = new_node(&self.case.bodies[number], number, position, volume, &self.options);
            if let Some(velocities) = &points.velocities {
                node.velocity = std::array::from_fn(|c| velocities[i][c]);
            }
            Ok(node)
        };
        points.positions.iter().enumerate().map(node).collect()
    }
}
