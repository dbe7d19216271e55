//! How large a problem is, and what memory it takes.

use colluvium_case::{Case, CaseError, Size};
use colluvium_constitutive::SymTensor;
use colluvium_grid::{Axis, Lanes, Mesh, Node};

use crate::config::{MeshSource, StressScheme};
use crate::contact::RowTouch;
use crate::dispatch::Chosen;
use crate::mesh::{points_per_element, terrain};
use crate::points::PointSet;
use crate::pressed::Pressed;
use crate::setup::options;
use crate::soaked::Soaked;
use crate::solver::MpmSolver;
use crate::{MpmOptions, ObstacleContact, dispatch};

/// Memory to sort points by cell (bytes a point): the order, its keys, and the largest of the arrays a second time.
fn sorting(state_size: usize) -> usize {
    16 + state_size.max(size_of::<SymTensor>())
}

/// The size of `case`.
pub fn size(case: &Case) -> Result<Size, CaseError> {
    let options = options(case)?;
    dispatch::dispatch(case, &options, Estimate { case, options: &options })
}

struct Estimate<'a> {
    case: &'a Case,
    options: &'a MpmOptions,
}

/// Nodes and elements of a mesh, and the points that fill the bodies of a case in it.
struct Counts {
    nodes: f64,
    elements: f64,
    points: Vec<f64>,
}

impl Estimate<'_> {
    fn counts<const D: usize>(&self, axis: &Axis) -> Result<Counts, CaseError> {
        let (case, options) = (self.case, self.options);
        let cells = |axis: usize| (case.domain.max[axis] - case.domain.min[axis]) / options.cell_size;
        let nodes = (0..D).map(|axis| cells(axis) + 1.0).product();
        let apart = options.cell_size / options.points_per_cell as f64;
        let in_elements = |elements: f64, volume: f64| {
            // As if points stood alone in cells of so much volume.
            let each = volume / (elements * points_per_element::<D>(options) as f64);
            case.points_at(each.powf(1.0 / D as f64))
        };
        Ok(match &options.mesh {
            None => Counts { nodes, elements: 0.0, points: case.points_at(apart) },
            Some(MeshSource::Box) => {
                // Each cell is cut along the orders of its axes.
                let cells: f64 = (0..D).map(cells).product();
                let elements = cells * (1..=D).product::<usize>() as f64;
                let points = in_elements(elements, cells * options.cell_size.powi(D as i32));
                Counts { nodes, elements, points }
            }
            Some(MeshSource::File { .. }) => {
                let (_, mesh, _) = terrain::<D>(case, options, axis)?;
                let elements = mesh.elements().len() as f64;
                let volume = mesh.elements().iter().map(|element| element.volume).sum();
                Counts { nodes: mesh.nodes().len() as f64, elements, points: in_elements(elements, volume) }
            }
        })
    }

    /// Number of velocity fields, see [`crate::contact::contacts`].
    fn fields(&self) -> usize {
        let named = |name: &String| self.options.contacts.iter().any(|contact| contact.bodies.contains(name));
        let own = self.case.bodies.iter().filter(|body| body.rigid || named(&body.name)).count();
        own + usize::from(own < self.case.bodies.len())
    }
}

impl dispatch::Visitor for Estimate<'_> {
    type Output = Result<Size, CaseError>;

    fn visit<const D: usize>(self, chosen: Chosen<D>) -> Self::Output {
        let (case, options) = (self.case, self.options);
        let Counts { nodes, elements, points } = self.counts::<D>(&chosen.sweeps.axis())?;
        let wet = case.bodies.iter().any(|body| body.pore_fluid.is_some());
        let number = size_of::<f64>();
        // Position, velocity, origin, velocity of the grid, room for a filter; mass, volume, initial volume; id; with a pore fluid its
        // velocity and pressure.
        let affine = options.transfer.is_affine() || !options.liquids.is_empty();
        let filters = options.filters_velocities();
        // Beside liquids with tpic some bodies may have a velocity of the grid.
        let vectors = 3 + usize::from(!options.transfer.is_affine()) + usize::from(filters);
        let arrays = (vectors * D + 3) * number
            + size_of::<u32>()
            + size_of::<SymTensor>()
            + chosen.sweeps.domains(0).size();
        let matrix = if affine { D * D } else { 0 };
        let arrays = arrays + (matrix + if wet { D + 1 } else { 0 }) * number;
        let presses = options.obstacles == ObstacleContact::Points;
        let soaked = if wet { size_of::<Soaked<D>>() } else { 0 };
        let arrays = arrays + if presses { size_of::<Pressed<D>>() + soaked } else { 0 };
        let mut memory = 0.0;
        for (body, points) in case.bodies.iter().zip(&points) {
            let path = || format!("materials.{}", body.material);
            let law = case.materials[&body.material].build();
            let state = law.map_err(|error| CaseError::new(path(), error.to_string()))?.state_size();
            memory += points * (arrays + state + sorting(state)) as f64;
        }
        let fields = self.fields();
        let remapped =
            usize::from(options.stress_update != StressScheme::Usl || filters) * size_of::<Lanes>();
        let slopes = usize::from(options.weakens_light_nodes()) * size_of::<Lanes>();
        let surface = if fields > 1 { size_of::<Lanes>() } else { 0 };
        let per_node = fields * (size_of::<Node>() + remapped + slopes + surface) * if wet { 2 } else { 1 };
        memory += nodes * per_node as f64;
        if elements > 0.0 {
            memory += Mesh::<D>::bytes(nodes, elements);
        }
        Ok(Size {
            points: points.iter().sum(),
            nodes,
            memory,
            key: "methods.mpm.cell_size",
            ..Size::default()
        })
    }
}

impl<const D: usize> MpmSolver<D> {
    /// Memory of points, nodes and mesh (bytes), and of what sorting takes.
    pub(crate) fn memory(&self) -> usize {
        let points = |set: &PointSet<D>| set.bytes() + set.len() * sorting(set.material.state_size());
        let mesh = Mesh::<D>::bytes(
            self.background.mesh.nodes().len() as f64,
            self.background.mesh.elements().len() as f64,
        );
        self.bodies.sets.iter().map(points).sum::<usize>()
            + size_of_val(&self.nodes.solved[..])
            + size_of_val(&self.nodes.remapped[..])
            + size_of_val(&self.nodes.slopes[..])
            + size_of_val(&self.nodes.row_sums[..])
            + self.boundary.contacts.bytes()
            + self.boundary.touched.iter().map(RowTouch::bytes).sum::<usize>()
            + self.boundary.rocks.as_ref().map_or(0, |rocks| rocks.bytes())
            + self.averages.strains.bytes()
            + self.averages.stresses.bytes()
            + self.averages.dual.bytes()
            + self.consistent.bytes()
            + self.two_phase.as_ref().map_or(0, |phases| phases.bytes())
            + self.averages.free_surface.as_ref().map_or(0, |surface| surface.bytes())
            + mesh as usize
    }
}
