//! Nodes of one phase: columns of material that move over the bed (sheet: depth-sph §3.1).

use colluvium_points::struct_of_arrays;

/// Vector in plan.
pub type PlanVector<const D: usize> = [f64; D];

/// Scalar product `Σ a_c b_c`.
#[inline]
pub fn dot<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    (0..D).map(|c| a[c] * b[c]).sum()
}

/// Length of a vector.
#[inline]
pub fn norm<const D: usize>(a: &[f64; D]) -> f64 {
    dot(a, a).sqrt()
}

struct_of_arrays! {
    /// Nodes of one phase.
    pub struct PhaseNodes<const D: usize> {
        /// Number of the node, constant during the run.
        pub id: u64,
        /// Body of the node at the start.
        pub body: u32,
        /// Initial position (m).
        pub origin: [f64; D],
        /// Position in plan (m).
        pub position: [f64; D],
        /// Velocity in plan, depth-averaged (m/s).
        pub velocity: [f64; D],
        /// Volume (m³; m² per metre of width in one dimension).
        pub volume: f64,
        /// Height of the phase (m): `(1 - n) h` for grains, `n h` for fluid, `h` for a single phase.
        pub partial_thickness: f64,
        /// Total depth of all phases (m).
        pub depth: f64,
        /// Smoothing length (m).
        pub length: f64,
        /// Initial smoothing length (m), which bounds later ones.
        pub first_length: f64,
        /// Constant `ℓ^d h / m` of the smoothing length: `η^d` for smoothing lengths of η spacings.
        pub scale: f64,
        /// Slope of the bed whose tangent plane contains the velocity; not-a-number until the bed has been sampled.
        pub slope: [f64; D],
        /// Effective gravity `g_*` on pressure at the last sample of the step (m/s²).
        pub effective_gravity: f64,
        /// Effective gravity on the load of the bed, with the acceleration of the curved path: for friction and pore pressure (m/s²).
        pub bed_gravity: f64,
        /// Largest speed of a neighbour relative to the node at the last forces (m/s); not-a-number before the first forces.
        pub relative_speed: f64,
        /// Turn of the bed's normal along the path of the node at the last forces, per distance in plan (rad/m).
        pub path_curvature: f64,
        /// Path travelled over the bed (m).
        pub path: f64,
        /// Volume eroded from the bed (m³; m² in one dimension).
        pub eroded_volume: f64,
        /// Acceleration in plan by a body force of a program in the step (m/s²); empty without one.
        pub body_acceleration: [f64; D],
    }
}

/// Node that is to be added to a phase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewNode<const D: usize> {
    /// Number of the body in the case.
    pub body: u32,
    /// Position (m).
    pub position: PlanVector<D>,
    /// Velocity (m/s).
    pub velocity: PlanVector<D>,
    /// Volume of the phase (m³; m² in one dimension).
    pub volume: f64,
    /// Smoothing length (m).
    pub length: f64,
    /// Constant `ℓ^d h / m` of the smoothing length.
    pub scale: f64,
}

impl<const D: usize> PhaseNodes<D> {
    /// Adds a node with a number; its height follows from the next summation.
    pub fn push(&mut self, id: u64, node: &NewNode<D>) {
        self.id.push(id);
        self.body.push(node.body);
        self.origin.push(node.position);
        self.position.push(node.position);
        self.velocity.push(node.velocity);
        self.volume.push(node.volume);
        self.length.push(node.length);
        self.first_length.push(node.length);
        self.scale.push(node.scale);
        self.slope.push([f64::NAN; D]);
        self.relative_speed.push(f64::NAN);
        self.path_curvature.push(0.0);
        if !self.body_acceleration.is_empty() {
            self.body_acceleration.push([0.0; D]);
        }
        let Self {
            partial_thickness: height,
            depth,
            effective_gravity,
            bed_gravity,
            path,
            eroded_volume,
            ..
        } = self;
        for column in [height, depth, effective_gravity, bed_gravity, path, eroded_volume] {
            column.push(0.0);
        }
    }

    /// Volume of all nodes (m³; m² in one dimension), summed in their order.
    pub fn total_volume(&self) -> f64 {
        self.volume.iter().sum()
    }
}

struct_of_arrays! {
    /// Data of nodes and images for neighbour sums; the images at walls and periodic boundaries follow the nodes.
    pub struct NeighbourData<const D: usize> {
        /// Position (m).
        pub position: [f64; D],
        /// Velocity (m/s).
        pub velocity: [f64; D],
        /// Volume (m³).
        pub volume: f64,
        /// Height of the phase (m).
        pub height: f64,
        /// Smoothing length (m).
        pub length: f64,
        /// Total depth (m).
        pub depth: f64,
        /// Height of the other phase (m); empty for a single phase.
        pub partner_height: f64,
        /// Pressure term `P / (g_* h²)` of the phase, with half of `P` for isotropic stress without another phase.
        pub pressure: f64,
        /// Porosity; empty for a single phase.
        pub porosity: f64,
        /// Depth times mean excess pore pressure over `g_*`, `h ρ' ψ̄` (kg/m); empty for a single phase.
        pub excess: f64,
        /// Bed level (m); empty unless the pressure force uses the gradient of the free surface.
        pub level: f64,
    }
}
