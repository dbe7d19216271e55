//! Faults of a mesh, by the numbers that nodes and elements have in the file.

use super::source::Source;
use super::{Content, MshError};
use crate::mesh::{Clash, Clashing};
use crate::{Mesh, MeshError};

/// Cure of a mesh that does not conform.
const CURE: &str = "join the parts before they are meshed, so that they share the nodes where they meet (in Gmsh with “BooleanFragments” or \
                    “Coherence”)";

/// Two nodes at one place.
fn unmerged(first: usize, second: usize, place: &[f64]) -> String {
    format!(
        "the nodes {first} and {second} lie at one place, {place:?} m, and are not merged: merge them (in Gmsh with “Coherence Mesh”), or {CURE}"
    )
}

impl Content {
    /// The fault of a node that lies off the plane.
    pub(super) fn off_the_plane(&self, node: usize, source: &Source<'_>) -> MshError {
        let ((tag, at), place) = (self.tags[node], self.places[node]);
        let cure = if self.places.iter().all(|x| x[1] == self.places[0][1]) {
            ": the mesh lies in the plane of x and z; write z as its y"
        } else {
            ": write z = 0"
        };
        source.fault_at(at, format!("node {tag} lies at {place:?} m, off the plane z = 0{cure}"))
    }

    /// An error with the tags of the file in place of numbers.
    pub(super) fn with_tags(&self, error: MeshError) -> MshError {
        let node = |number: usize| self.tags.get(number).map_or(number, |(tag, _)| *tag as usize);
        MshError::Mesh(match error {
            MeshError::Duplicate { first, second, position } => {
                return MshError::Conformity(unmerged(node(first), node(second), &position));
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

    /// A place where the mesh does not conform, in words.
    pub(super) fn described<const D: usize>(&self, mesh: &Mesh<D>, clash: &Clash<D>) -> String {
        let node = |node: u32| self.tags[self.number_of(mesh, node)].0;
        let element = |element: u32| {
            let mut corners: Vec<usize> = mesh.elements()[element as usize].nodes[..=D]
                .iter()
                .map(|n| self.number_of(mesh, *n))
                .collect();
            corners.sort_unstable();
            let found = self.elements.iter().position(|own| super::sorted(own) == corners);
            found.map_or(0, |number| self.element_tags[number])
        };
        let (place, within) = (&clash.place, element(clash.within));
        let on = if clash.is_inside { "inside of" } else { "on a side of" };
        match clash.what {
            Clashing::Node(number) => format!(
                "node {} lies at {place:?} m {on} element {within}, of which it is no corner: {CURE}",
                node(number)
            ),
            Clashing::Twin(number, other) => unmerged(node(other) as usize, node(number) as usize, place),
            Clashing::Centre(number) => format!(
                "element {} around {place:?} m lies over element {within}: leave one of them out, or {CURE}",
                element(number)
            ),
            Clashing::Facet(number) => format!(
                "a side of element {} around {place:?} m lies on element {within}, and their nodes there are not the same: {CURE}",
                element(number)
            ),
        }
    }

    /// Number in the file of a node of the mesh, by its place, which is that of one node only.
    fn number_of<const D: usize>(&self, mesh: &Mesh<D>, node: u32) -> usize {
        let place = mesh.nodes()[node as usize];
        let used = |number: usize| self.elements.iter().any(|corners| corners.contains(&number));
        let mut alike = (0..self.places.len()).filter(|number| self.places[*number][..D] == place);
        alike.find(|number| used(*number)).unwrap_or(0)
    }
}
