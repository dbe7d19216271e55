//! Size of a problem, and its memory.

use colluvium_case::{Case, CaseError, ProblemSize};
use colluvium_constitutive::SymTensor;
use colluvium_grid::{Basis1d, Mesh, NodalState, Vector4};

use crate::background_grid::dimension_dispatch;
use crate::background_grid::dimension_dispatch::SelectedTransfers;
use crate::background_grid::unstructured_mesh::{grid_mesh_and_layout, points_per_element};
use crate::config::{MeshSource, StressScheme};
use crate::contact::contact_law::RowContact;
use crate::points::penalty_state::PenaltyState;
use crate::points::point_set::PointSet;
use crate::points::pore_contact_state::PoreContactState;
use crate::setup::options;
use crate::solver::MpmSolver;
use crate::{MpmOptions, ObstacleCoupling};

/// Memory to sort points by cell (bytes a point): the order, its keys, and the largest of the arrays a second time.
fn sort_memory(state_size: usize) -> usize {
    16 + state_size.max(size_of::<SymTensor>())
}

/// Returns the size of `case`.
pub fn problem_size(case: &Case) -> Result<ProblemSize, CaseError> {
    let options = options(case)?;
    dimension_dispatch::dispatch(case, &options, EstimateSize { case, options: &options })
}

/// Estimate of the problem size, in any dimension.
struct EstimateSize<'a> {
    case: &'a Case,
    options: &'a MpmOptions,
}

/// Number of nodes and elements of a mesh, and of points of the bodies in it.
struct MeshCounts {
    nodes: f64,
    elements: f64,
    points: Vec<f64>,
}

impl EstimateSize<'_> {
    /// Expected numbers of nodes, mesh elements and points.
    fn counts<const D: usize>(&self, axis: &Basis1d) -> Result<MeshCounts, CaseError> {
        let (case, options) = (self.case, self.options);
        let cells = |axis: usize| (case.domain.max[axis] - case.domain.min[axis]) / options.cell_size;
        let nodes = (0..D).map(|axis| cells(axis) + 1.0).product();
        let apart = options.cell_size / options.points_per_cell as f64;
        let in_elements = |elements: f64, volume: f64| {
            // As if every point had cells of this volume of its own.
            let each = volume / (elements * points_per_element::<D>(options) as f64);
            case.point_counts(each.powf(1.0 / D as f64))
        };
        Ok(match &options.mesh {
            None => MeshCounts { nodes, elements: 0.0, points: case.point_counts(apart) },
            Some(MeshSource::Box) => {
                // Each cell is cut along the orders of its axes.
                let cells: f64 = (0..D).map(cells).product();
                let elements = cells * (1..=D).product::<usize>() as f64;
                let points = in_elements(elements, cells * options.cell_size.powi(D as i32));
                MeshCounts { nodes, elements, points }
            }
            Some(MeshSource::File { .. }) => {
                let (_, mesh, _) = grid_mesh_and_layout::<D>(case, options, axis)?;
                let elements = mesh.elements().len() as f64;
                let volume = mesh.elements().iter().map(|element| element.volume).sum();
                MeshCounts {
                    nodes: mesh.nodes().len() as f64,
                    elements,
                    points: in_elements(elements, volume),
                }
            }
        })
    }

    /// Number of velocity fields, see [`crate::contact::contact_law::field_contacts`].
    fn fields(&self) -> usize {
        let named = |name: &String| self.options.contacts.iter().any(|contact| contact.bodies.contains(name));
        let own = self.case.bodies.iter().filter(|body| body.rigid || named(&body.name)).count();
        own + usize::from(own < self.case.bodies.len())
    }
}

impl dimension_dispatch::DimensionVisitor for EstimateSize<'_> {
    type Output = Result<ProblemSize, CaseError>;

    fn visit<const D: usize>(self, chosen: SelectedTransfers<D>) -> Self::Output {
        let (case, options) = (self.case, self.options);
        let MeshCounts { nodes, elements, points } = self.counts::<D>(&chosen.transfers.basis_1d())?;
        let wet = case.bodies.iter().any(|body| body.pore_fluid.is_some());
        let number = size_of::<f64>();
        // Position, velocity, origin, velocity of the grid, workspace for a filter; mass, volume, initial volume; id; with a pore fluid its
        // velocity and pressure.
        let affine = options.transfer.is_affine() || !options.liquid_bodies.is_empty();
        let filters = options.filters_velocities();
        // Beside liquids with tpic some bodies may have a velocity of the grid.
        let vectors = 3 + usize::from(!options.transfer.is_affine()) + usize::from(filters);
        let arrays = (vectors * D + 3) * number
            + size_of::<u32>()
            + size_of::<SymTensor>()
            + chosen.transfers.domains(0).size();
        let matrix = if affine { D * D } else { 0 };
        let arrays = arrays + (matrix + if wet { D + 1 } else { 0 }) * number;
        let presses = options.obstacles == ObstacleCoupling::Points;
        let pore_contact = if wet { size_of::<PoreContactState<D>>() } else { 0 };
        let arrays = arrays + if presses { size_of::<PenaltyState<D>>() + pore_contact } else { 0 };
        let mut memory = 0.0;
        for (body, points) in case.bodies.iter().zip(&points) {
            let path = || format!("materials.{}", body.material);
            let law = case.materials[&body.material].build();
            let state = law.map_err(|error| CaseError::new(path(), error))?.state_size();
            memory += points * (arrays + state + sort_memory(state)) as f64;
        }
        let fields = self.fields();
        let remapped =
            usize::from(options.stress_update != StressScheme::Usl || filters) * size_of::<Vector4>();
        let slopes = usize::from(options.rescales_small_mass_forces()) * size_of::<Vector4>();
        let surface = if fields > 1 { size_of::<Vector4>() } else { 0 };
        let per_node =
            fields * (size_of::<NodalState>() + remapped + slopes + surface) * if wet { 2 } else { 1 };
        memory += nodes * per_node as f64;
        if elements > 0.0 {
            memory += Mesh::<D>::bytes(nodes, elements);
        }
        Ok(ProblemSize {
            points: points.iter().sum(),
            nodes,
            memory,
            case_key: "methods.mpm.cell_size",
            ..ProblemSize::default()
        })
    }
}

impl<const D: usize> MpmSolver<D> {
    /// Memory of points, nodes and mesh (bytes), that for sorting included.
    pub(crate) fn memory(&self) -> usize {
        let points = |set: &PointSet<D>| set.bytes() + set.len() * sort_memory(set.material.state_size());
        let mesh = Mesh::<D>::bytes(
            self.background.mesh.nodes().len() as f64,
            self.background.mesh.elements().len() as f64,
        );
        self.bodies.sets.iter().map(points).sum::<usize>()
            + size_of_val(&self.nodes.nodal_states[..])
            + size_of_val(&self.nodes.remapped_velocities[..])
            + size_of_val(&self.nodes.mass_gradients[..])
            + size_of_val(&self.nodes.row_sums[..])
            + self.boundary.contacts.bytes()
            + self.boundary.row_contacts.iter().map(RowContact::bytes).sum::<usize>()
            + self.boundary.penalty_obstacles.as_ref().map_or(0, |obstacles| obstacles.bytes())
            + self.averages.strains.bytes()
            + self.averages.stresses.bytes()
            + self.averages.dual_domain.bytes()
            + self.consistent.bytes()
            + self.two_phase.as_ref().map_or(0, |phases| phases.bytes())
            + self.averages.free_surface.as_ref().map_or(0, |surface| surface.bytes())
            + mesh as usize
    }
}
