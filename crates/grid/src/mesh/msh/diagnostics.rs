//! Errors of a mesh, with the node and element tags of the file.

use crate::mesh::msh::reader::MshReader;
use crate::mesh::msh::{MshContent, MshError};
use crate::mesh::{Nonconformity, NonconformityKind};
use crate::{Mesh, MeshError};

/// Advice for a mesh that does not conform.
const MERGE_ADVICE: &str = "join the parts before they are meshed, so that they share the nodes where they meet (in Gmsh with “BooleanFragments” or \
                    “Coherence”)";

/// Error of two nodes at the same position.
fn coincident_nodes_error(first: usize, second: usize, place: &[f64]) -> String {
    format!(
        "the nodes {first} and {second} lie at one place, {place:?} m, and are not merged: merge them (in Gmsh with “Coherence Mesh”), or {MERGE_ADVICE}"
    )
}

impl MshContent {
    /// Error of a node outside the plane.
    pub(super) fn out_of_plane_error(&self, node: usize, source: &MshReader<'_>) -> MshError {
        let ((tag, at), place) = (self.tags[node], self.positions[node]);
        let cure = if self.positions.iter().all(|x| x[1] == self.positions[0][1]) {
            ": the mesh lies in the plane of x and z; write z as its y"
        } else {
            ": write z = 0"
        };
        source.error_at(at, format!("node {tag} lies at {place:?} m, off the plane z = 0{cure}"))
    }

    /// Error with the tags of the file in place of node and element numbers.
    pub(super) fn with_tags(&self, error: MeshError) -> MshError {
        let node = |number: usize| self.tags.get(number).map_or(number, |(tag, _)| *tag as usize);
        MshError::Mesh(match error {
            MeshError::Duplicate { first, second, position } => {
                return MshError::Conformity(coincident_nodes_error(node(first), node(second), &position));
            }
            MeshError::NotFinite { node: number, position } => {
                MeshError::NotFinite { node: node(number), position }
            }
            MeshError::Volume { element, centre, volume } => {
                let element = self.element_tags.get(element).map_or(element, |tag| *tag as usize);
                MeshError::Volume { element, centre, volume }
            }
            other => other,
        })
    }

    /// Description of a position where the mesh does not conform.
    pub(super) fn describe_nonconformity<const D: usize>(
        &self,
        mesh: &Mesh<D>,
        clash: &Nonconformity<D>,
    ) -> String {
        let node = |node: u32| self.tags[self.number_of(mesh, node)].0;
        let element = |element: u32| {
            let mut corners: Vec<usize> = mesh.elements()[element as usize].nodes[..=D]
                .iter()
                .map(|n| self.number_of(mesh, *n))
                .collect();
            corners.sort_unstable();
            let found = self.elements.iter().position(|own| crate::mesh::msh::sorted_nodes(own) == corners);
            found.map_or(0, |number| self.element_tags[number])
        };
        let (place, within) = (&clash.position, element(clash.element));
        let on = if clash.is_inside { "inside of" } else { "on a side of" };
        match clash.kind {
            NonconformityKind::Node(number) => format!(
                "node {} lies at {place:?} m {on} element {within}, but is not a corner of this element: \
                 {MERGE_ADVICE}",
                node(number)
            ),
            NonconformityKind::CoincidentNode(number, other) => {
                coincident_nodes_error(node(other) as usize, node(number) as usize, place)
            }
            NonconformityKind::Centre(number) => format!(
                "element {} around {place:?} m lies over element {within}: leave one of them out, or {MERGE_ADVICE}",
                element(number)
            ),
            NonconformityKind::FacetCentre(number) => format!(
                "a side of element {} around {place:?} m lies on element {within}, and their nodes there are not the same: {MERGE_ADVICE}",
                element(number)
            ),
        }
    }

    /// Number in the file of a node of the mesh, by its position, which is unique.
    fn number_of<const D: usize>(&self, mesh: &Mesh<D>, node: u32) -> usize {
        let place = mesh.nodes()[node as usize];
        let used = |number: usize| self.elements.iter().any(|corners| corners.contains(&number));
        let mut alike = (0..self.positions.len()).filter(|number| self.positions[*number][..D] == place);
        alike.find(|number| used(*number)).unwrap_or(0)
    }
}
