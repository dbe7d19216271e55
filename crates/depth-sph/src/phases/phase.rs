//! Set of nodes of one phase with its neighbours, bed and accelerations.

use colluvium_points::{CellList, NeighbourList, ScratchBuffers, SearchError};
use rayon::prelude::*;

use crate::bed::BedPoint;
use crate::config::choices::{Phases, SearchOrientation};
use crate::config::settings::FlowSettings;
use crate::neighbours::cell_sorted::CellSorted;
use crate::neighbours::max_smoothing_length::MaxSmoothingLength;
use crate::neighbours::simd_neighbour_list::PackedNeighbours;
use crate::points::MIN_NODES_PER_TASK;
use crate::points::image_nodes::{ImageNode, PlanBoundaries, copy_with_images, image_nodes};
use crate::points::phase_nodes::{NeighbourData, PhaseNodes, PlanVector};

/// Relative margin of the neighbour lists beyond the kernel supports. The lists are valid until a node has moved by a quarter of it or its
/// smoothing length has grown by half of it.
const SKIN: f64 = 0.4;

/// Nodes of one phase or layer with the data of a step.
#[derive(Debug, Default)]
pub struct PhaseSet<const D: usize> {
    /// Nodes.
    pub nodes: PhaseNodes<D>,
    /// Data of the nodes and their images that neighbour sums read.
    pub neighbour_data: NeighbourData<D>,
    /// Images at walls and periods.
    pub images: Vec<ImageNode<D>>,
    /// Data of the nodes and images sorted by cell, for sums over neighbours.
    pub cell_sorted: CellSorted<D>,
    /// Neighbour list of the same phase, if a term needs it.
    pub same_phase_neighbours: NeighbourList<D>,
    /// Neighbours of the other phase.
    pub other_phase_neighbours: NeighbourList<D>,
    /// `Ω` of each node, where forces are variational.
    pub omega: Vec<f64>,
    /// Bed below each node.
    pub bed: Vec<BedPoint<D>>,
    /// Effective gravity of the reaction of the bed (m/s²).
    pub reaction: Vec<f64>,
    /// Normal acceleration of the velocities that follow the bed (m/s²), with transport of velocities.
    pub curvature_acceleration: Vec<f64>,
    /// Accelerations (m/s²).
    pub acceleration: Vec<PlanVector<D>>,
    /// Acceleration by artificial viscosity (m/s²).
    pub viscous: Vec<PlanVector<D>>,
    /// Rates of height (m/s), where heights are integrated.
    pub rate: Vec<f64>,
    /// Rates of divergence of the velocity (1/s), if the stress depends on them.
    pub divergence: Vec<f64>,
    /// Velocity at the beginning of the step (m/s).
    pub start_velocity: Vec<PlanVector<D>>,
    /// Velocity before the kick, or before resistance (m/s), for the energy balance.
    pub stored_velocity: Vec<PlanVector<D>>,
    /// Work of friction, viscosity and pressure per step at each node (J).
    pub works_per_step: Vec<[f64; 3]>,
    /// Vectors of each node, as temporary storage within a sub-step.
    pub scratch_vectors: Vec<PlanVector<D>>,
    /// Scalars of each node, as temporary storage within a sub-step.
    pub scratch_scalars: Vec<f64>,
    /// Packed neighbours, where heights are sums.
    pub packed_neighbours: PackedNeighbours,
    /// Largest smoothing length of nodes with a position in their support, at the last forces or the last lists.
    pub max_smoothing_length: MaxSmoothingLength<D>,
    listed_nodes: Vec<(PlanVector<D>, f64)>,
}

impl<const D: usize> PhaseSet<D> {
    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Index of the node of entry `j` of the neighbour data.
    #[inline]
    pub fn number(&self, j: usize) -> usize {
        match j.checked_sub(self.nodes.len()) {
            Some(image) => self.images[image].source as usize,
            None => j,
        }
    }

    /// Whether there is no node.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Whether the images and lists are those of the present nodes. A set whose nodes have all left may have images of them.
    pub fn has_lists(&self) -> bool {
        let are_images_of_nodes = !self.is_empty() || self.images.is_empty();
        are_images_of_nodes && self.listed_nodes.len() == self.len()
    }

    /// Whether the neighbour lists still contain all pairs within the supports.
    pub fn is_listed(&self, support: f64) -> bool {
        if !self.has_lists() {
            return false;
        }
        // Without images all nodes may move together.
        let mean: PlanVector<D> = if self.images.is_empty() && !self.listed_nodes.is_empty() {
            let count = self.len() as f64;
            std::array::from_fn(|c| {
                let moved =
                    self.nodes.position.iter().zip(&self.listed_nodes).map(|(x, (old, _))| x[c] - old[c]);
                moved.sum::<f64>() / count
            })
        } else {
            [0.0; D]
        };
        let nodes = self.nodes.position.par_iter().zip(&self.nodes.length).zip(&self.listed_nodes);
        let stays = |((x, length), (old, listed)): ((&PlanVector<D>, &f64), &(PlanVector<D>, f64))| {
            let square: f64 = (0..D).map(|c| (x[c] - old[c] - mean[c]).powi(2)).sum();
            square.sqrt() <= 0.25 * SKIN * support * listed && *length <= (1.0 + 0.5 * SKIN) * listed
        };
        nodes.with_min_len(8 * MIN_NODES_PER_TASK).all(stays)
    }

    /// Creates image nodes behind walls and periodic boundaries.
    pub fn make_images(&mut self, ends: &PlanBoundaries<D>, support: f64) {
        if !ends.are_open() {
            let nodes = &mut self.nodes;
            for (position, origin) in nodes.position.iter_mut().zip(&mut nodes.origin) {
                ends.wrap_into_period(position, origin);
            }
        }
        self.make_images_in_place(ends, support);
    }

    /// Creates image nodes as [`PhaseSet::make_images`], of nodes that are within the periods.
    pub fn make_images_in_place(&mut self, ends: &PlanBoundaries<D>, support: f64) {
        self.clear_lists();
        if ends.are_open() {
            self.images.clear();
        } else {
            let nodes = &self.nodes;
            let longest = nodes.length.iter().copied().fold(0.0, f64::max);
            image_nodes(ends, &nodes.position, (1.0 + SKIN) * support * longest, &mut self.images);
        }
        self.place_images();
    }

    /// Sorts the neighbour data into cells.
    pub fn pack(&mut self, support: f64, search: SearchOrientation) -> Result<(), SearchError> {
        self.packed_neighbours.clear();
        self.cell_sorted.sort_into_cells(
            &self.neighbour_data,
            0.5 * median_radius(support, &self.nodes.length),
            search,
        )
    }

    /// Copies the data of the forces in the order of the cells.
    pub fn gather_force_data(&mut self, support: f64, with_fields: bool) {
        self.cell_sorted.gather_force_data(&self.neighbour_data, with_fields);
        if self.packed_neighbours.are_complete() {
            return;
        }
        self.max_smoothing_length.update(&self.neighbour_data.position, &self.neighbour_data.length, support);
    }

    /// Lists the neighbours of each node in the same phase.
    pub fn list_same_phase(&mut self, support: f64) -> Result<(), SearchError> {
        let nodes = &self.nodes;
        self.listed_nodes.extend(nodes.position.iter().copied().zip(nodes.length.iter().copied()));
        self.max_smoothing_length.update(
            &self.neighbour_data.position,
            &self.neighbour_data.length,
            (1.0 + SKIN) * support,
        );
        let (data, own) = (&self.neighbour_data, &self.nodes);
        let search = NeighbourCriterion { support, max_smoothing_length: &self.max_smoothing_length };
        self.same_phase_neighbours.build_between(
            &own.position,
            |i| search.radius(&own.position[i], own.length[i]),
            &data.position,
            0.5 * (1.0 + SKIN) * median_radius(support, &own.length),
            |i, j| i != j && search.is_near(own, i, data, j),
        )
    }

    /// Lists the neighbours of each node in the other phase, with its images.
    pub fn list_other_phase(&mut self, other: &NeighbourData<D>, support: f64) -> Result<(), SearchError> {
        self.max_smoothing_length.update(&other.position, &other.length, (1.0 + SKIN) * support);
        let own = &self.nodes;
        let search = NeighbourCriterion { support, max_smoothing_length: &self.max_smoothing_length };
        self.other_phase_neighbours.build_between(
            &own.position,
            |i| search.radius(&own.position[i], own.length[i]),
            &other.position,
            0.5 * (1.0 + SKIN) * median_radius(support, &own.length),
            |i, j| search.is_near(own, i, other, j),
        )
    }

    /// Positions (m) and smoothing lengths (m) of the nodes at which the lists and images were made; none without lists.
    pub fn listed_nodes(&self) -> &[(PlanVector<D>, f64)] {
        &self.listed_nodes
    }

    /// Exchanges positions and smoothing lengths of the nodes with those of `others`.
    pub fn exchange_places(&mut self, others: &mut [(PlanVector<D>, f64)]) {
        let places = self.nodes.position.iter_mut().zip(&mut self.nodes.length);
        for ((x, length), (other, other_length)) in places.zip(others) {
            std::mem::swap(x, other);
            std::mem::swap(length, other_length);
        }
    }

    /// Clears the lists, as nodes have been added or removed.
    pub fn clear_lists(&mut self) {
        self.listed_nodes.clear();
    }

    /// Updates position, velocity, volume and smoothing length of the neighbour data, with images.
    pub fn place_images(&mut self) {
        let (nodes, data) = (&self.nodes, &mut self.neighbour_data);
        data.position.clear();
        data.position.extend_from_slice(&nodes.position);
        data.position.extend(
            self.images.iter().map(|image| image.image_position(&nodes.position[image.source as usize])),
        );
        copy_with_images(&self.images, &nodes.volume, &mut data.volume);
        copy_with_images(&self.images, &nodes.length, &mut data.length);
        self.update_image_velocities();
    }

    /// Updates the velocity of the neighbour data, with images.
    pub fn update_image_velocities(&mut self) {
        let (nodes, data) = (&self.nodes, &mut self.neighbour_data);
        data.velocity.clear();
        data.velocity.extend_from_slice(&nodes.velocity);
        data.velocity.extend(
            self.images.iter().map(|image| image.transform_vector(&nodes.velocity[image.source as usize])),
        );
    }

    /// Updates heights and smoothing lengths of the neighbour data, with images.
    pub fn update_image_thickness(&mut self) {
        copy_with_images(&self.images, &self.nodes.partial_thickness, &mut self.neighbour_data.height);
        copy_with_images(&self.images, &self.nodes.length, &mut self.neighbour_data.length);
    }

    /// Sorts the nodes by cells of width `edge` (m), so that neighbours are close in memory. Returns the order, by which other data are
    /// sorted.
    ///
    /// # Errors
    /// When a position is not finite.
    pub fn sort(
        &mut self,
        edge: f64,
        cells: &mut CellList<D>,
        spare: &mut ScratchBuffers,
    ) -> Result<(), SearchError> {
        cells.build(&self.nodes.position, edge)?;
        self.nodes.reorder(cells.order(), spare);
        self.clear_lists();
        Ok(())
    }
}

impl<const D: usize> PhaseSet<D> {
    /// Porosity of the flow at node `i`; `set` is the number of this node set.
    fn porosity(&self, settings: &FlowSettings<D>, set: usize, i: usize) -> f64 {
        let share = self.nodes.partial_thickness[i] / self.nodes.depth[i];
        match (settings.phases, set) {
            (Phases::Two, 0) => 1.0 - share,
            (Phases::Two, _) => share,
            _ => settings.material.porosity,
        }
    }

    /// Submerged density of the flow at node `i` (kg/m³); `set` is the number of this node set.
    pub fn submerged_density(&self, settings: &FlowSettings<D>, set: usize, i: usize) -> f64 {
        settings.material.densities.submerged_density(self.porosity(settings, set, i))
    }

    /// Density of the flow at node `i` (kg/m³); for grains and fluid that of the mixture.
    pub fn flow_density(&self, settings: &FlowSettings<D>, (sets, set): (usize, usize), i: usize) -> f64 {
        match settings.phases {
            Phases::Two => settings.material.densities.mixture(self.porosity(settings, set, i)),
            Phases::One | Phases::Layers => settings.set_density(sets, set),
        }
    }
}

/// Mean radius of a search, without its skin.
fn median_radius(support: f64, lengths: &[f64]) -> f64 {
    let radius = support * lengths.iter().sum::<f64>() / lengths.len().max(1) as f64;
    if radius > 0.0 { radius } else { 1.0 }
}

/// Criterion of listed neighbours: all within the support of the node, or of the mean of both lengths, and the skin.
struct NeighbourCriterion<'a, const D: usize> {
    support: f64,
    max_smoothing_length: &'a MaxSmoothingLength<D>,
}

impl<const D: usize> NeighbourCriterion<'_, D> {
    /// Search radius for neighbours at a position (m), list margin included.
    fn radius(&self, x: &PlanVector<D>, length: f64) -> f64 {
        (1.0 + SKIN) * 0.5 * self.support * (length + self.max_smoothing_length.length_at(x).max(length))
    }

    /// Whether node `j` of the other set is within the pair's support of node `i`, list margin included.
    fn is_near(&self, own: &PhaseNodes<D>, i: u32, other: &NeighbourData<D>, j: u32) -> bool {
        let (i, j) = (i as usize, j as usize);
        let length = own.length[i];
        let reach = (1.0 + SKIN) * 0.5 * self.support * (length + other.length[j].max(length));
        let square: f64 = (0..D).map(|c| (own.position[i][c] - other.position[j][c]).powi(2)).sum();
        square <= reach * reach
    }
}
