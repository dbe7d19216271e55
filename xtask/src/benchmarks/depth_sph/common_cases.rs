//! Shared helpers of the benchmarks of depth-integrated flow: cases, flows without a case, profiles.

use colluvium::case::{Case, Snapshot, Solver};
use colluvium::constitutive::basal::{BasalRheology, BasalSpec};
use colluvium::depth_sph::bed::Bed;
use colluvium::depth_sph::config::settings::{FlowSettings, Mixture};
use colluvium::depth_sph::flow::{Flow, PhaseSet, PlanBoundaries};
use colluvium::depth_sph::kernel::Kernel;
use colluvium::depth_sph::laws::interphase_drag::MixtureDensities;
use colluvium::depth_sph::points::phase_nodes::NewNode;
use colluvium::plots::{LineChart, Series, Style};
use serde_json::Value;

use crate::benchmarks::{scalars, vectors};

/// Number of points of a fixed grid on which a profile is compared (sheet: depth-sph §5).
const GRID_POINTS: usize = 500;

/// Reads the case `validation/depth-sph/<folder>/case.json`.
pub fn load(folder: &str) -> Result<Case, String> {
    crate::benchmarks::load_case(&format!("depth-sph/{folder}"))
}

/// Solver of a case at the start of its first stage.
pub fn start(case: &Case) -> Result<Box<dyn Solver>, String> {
    let method = colluvium::method("depth-sph").ok_or("no method depth-sph")?;
    let mut solver = method.build(case).map_err(|error| error.to_string())?;
    solver.begin_stage(0, 0.0).map_err(|error| error.to_string())?;
    Ok(solver)
}

/// Makes steps until `end` (s).
pub fn step_until(solver: &mut dyn Solver, end: f64) -> Result<(), String> {
    while solver.time() < end * (1.0 - 1e-12) {
        solver.step(end - solver.time()).map_err(|error| error.to_string())?;
    }
    Ok(())
}

/// Makes steps of a flow without a case until `end` (s).
pub fn step_flow_until<const D: usize>(flow: &mut Flow<D>, end: f64) -> Result<(), String> {
    while flow.clock.time < end * (1.0 - 1e-12) {
        let dt = flow.limit().dt.min(end - flow.clock.time);
        flow.advance(dt).map_err(|failure| failure.to_string())?;
    }
    Ok(())
}

/// Node on a line, with a velocity (m/s) and a volume (m²).
pub fn line_node(x: f64, velocity: f64, volume: f64, spacing: f64) -> NewNode<1> {
    NewNode { body: 0, position: [x], velocity: [velocity], volume, length: 1.5 * spacing, scale: 1.5 }
}

/// Nodes of a layer of `depth` (m), every `spacing` (m) from `from` to `to`.
pub fn layer(from: f64, to: f64, spacing: f64, depth: f64) -> Vec<NewNode<1>> {
    let count = ((to - from) / spacing).round() as usize;
    (0..count).map(|k| line_node(from + spacing * (k as f64 + 0.5), 0.0, depth * spacing, spacing)).collect()
}

/// Nodes of a line, from which profiles are computed by SPH sums.
pub struct NodeProfile {
    /// Position (m), velocity (m/s), volume (m²), smoothing length (m).
    nodes: Vec<[f64; 4]>,
    /// Longest smoothing length (m).
    max_smoothing_length: f64,
}

impl NodeProfile {
    /// Profile of the nodes and of their mirror images behind the walls.
    fn new(nodes: impl Iterator<Item = [f64; 4]>, walls: &[f64]) -> Self {
        let mut nodes: Vec<[f64; 4]> = nodes.collect();
        let mirrored: Vec<[f64; 4]> = walls
            .iter()
            .flat_map(|wall| nodes.iter().map(move |[x, v, m, l]| [2.0 * wall - x, -v, *m, *l]))
            .collect();
        nodes.extend(mirrored);
        nodes.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let longest = nodes.iter().map(|node| node[3]).fold(0.0, f64::max);
        Self { nodes, max_smoothing_length: longest }
    }

    /// Profile of height and velocity from the nodes of a phase in a snapshot. The nodes are mirrored in the walls at the positions `walls`
    /// (m). Where there is one phase only, all nodes belong to it.
    pub fn from_snapshot(snapshot: &Snapshot, phase: usize, walls: &[f64]) -> Self {
        let velocity = vectors(snapshot, "velocity");
        let (volume, length) = (scalars(snapshot, "volume"), scalars(snapshot, "smoothing_length"));
        let phases = scalars(snapshot, "phase");
        let of_phase = |i: &usize| phases.get(*i).is_none_or(|own| *own == phase as f64);
        let each = (0..snapshot.positions.len()).filter(of_phase);
        Self::new(each.map(|i| [snapshot.positions[i][0], velocity[i][0], volume[i], length[i]]), walls)
    }

    /// Profile of height and velocity from the SPH nodes of one phase. The nodes are mirrored in the walls at the positions `walls` (m).
    pub fn of_set(set: &PhaseSet<1>, walls: &[f64]) -> Self {
        let nodes = &set.nodes;
        let each = (0..nodes.volume.len())
            .map(|i| [nodes.position[i][0], nodes.velocity[i][0], nodes.volume[i], nodes.length[i]]);
        Self::new(each, walls)
    }

    /// Profile mirrored at the origin: `x` becomes `-x`.
    pub fn mirrored(&self) -> Self {
        let nodes = self.nodes.iter().rev().map(|[x, v, m, l]| [-x, -v, *m, *l]).collect();
        Self { nodes, max_smoothing_length: self.max_smoothing_length }
    }

    /// Height (m) and velocity (m/s) at `x` (m), by SPH sums over the nodes. The velocity is zero where there is no height.
    pub fn height_and_velocity_at(&self, x: f64) -> (f64, f64) {
        let kernel = Kernel::CubicSpline;
        let reach = kernel.support() * self.max_smoothing_length;
        let first = self.nodes.partition_point(|node| node[0] < x - reach);
        let (mut height, mut flux) = (0.0, 0.0);
        for [at, velocity, volume, length] in self.nodes[first..].iter().take_while(|n| n[0] <= x + reach) {
            let own = volume * kernel.value::<1>((x - at).abs(), *length);
            height += own;
            flux += own * velocity;
        }
        (height, if height > 1e-9 { flux / height } else { 0.0 })
    }

    /// Mean differences of height and velocity from `exact` over a fixed grid from `low` to `high` (m).
    pub fn errors(&self, low: f64, high: f64, exact: impl Fn(f64) -> (f64, f64)) -> (f64, f64) {
        let mut sum = (0.0, 0.0);
        for x in cell_centres(low, high) {
            let (found, wanted) = (self.height_and_velocity_at(x), exact(x));
            sum.0 += (found.0 - wanted.0).abs() / GRID_POINTS as f64;
            sum.1 += (found.1 - wanted.1).abs() / GRID_POINTS as f64;
        }
        sum
    }

    /// Mean height (m) and velocity (m/s) between two positions (m).
    pub fn mean(&self, low: f64, high: f64) -> (f64, f64) {
        let mut sum = (0.0, 0.0);
        for x in cell_centres(low, high) {
            let (height, velocity) = self.height_and_velocity_at(x);
            sum.0 += height / GRID_POINTS as f64;
            sum.1 += velocity / GRID_POINTS as f64;
        }
        sum
    }

    /// First position between `low` and `high` (m) at which the height falls below `level` (m).
    pub fn downcrossing(&self, level: f64, low: f64, high: f64) -> f64 {
        let mut before: Option<(f64, f64)> = None;
        for x in (0..20 * GRID_POINTS).map(|k| low + (high - low) * k as f64 / (20 * GRID_POINTS) as f64) {
            let height = self.height_and_velocity_at(x).0;
            if let Some((was, h)) = before
                && h >= level
                && height < level
            {
                return was + (x - was) * (h - level) / (h - height);
            }
            before = Some((x, height));
        }
        f64::NAN
    }

    /// Heights over a grid.
    pub fn heights(&self, low: f64, high: f64) -> Vec<(f64, f64)> {
        cell_centres(low, high).map(|x| (x, self.height_and_velocity_at(x).0)).collect()
    }

    /// Velocities over a grid, where there is any height.
    pub fn velocities(&self, low: f64, high: f64) -> Vec<(f64, f64)> {
        let shown = cell_centres(low, high).map(|x| (x, self.height_and_velocity_at(x)));
        shown.filter(|(_, (height, _))| *height > 1e-3).map(|(x, (_, velocity))| (x, velocity)).collect()
    }
}

/// Centres of the cells of the grid.
pub fn cell_centres(low: f64, high: f64) -> impl Iterator<Item = f64> {
    (0..GRID_POINTS).map(move |k| low + (high - low) * (k as f64 + 0.5) / GRID_POINTS as f64)
}

/// Chart of a quantity over the position.
pub fn chart(title: &str, y_label: &str) -> LineChart {
    LineChart::new(title, "x (m)", y_label)
}

/// Closed form on a grid, as a broken line of a chart.
pub fn closed_form_series(
    label: impl Into<String>,
    low: f64,
    high: f64,
    value: impl Fn(f64) -> f64,
) -> Series {
    Series::new(label, cell_centres(low, high).map(|x| (x, value(x))).collect(), Style::Dashed)
}

/// Basal law from its form in a case file.
pub fn basal_law(spec: Value) -> Result<Option<BasalRheology>, String> {
    let spec: BasalSpec = serde_json::from_value(spec).map_err(|error| error.to_string())?;
    spec.build().map(Some).map_err(|error| error.to_string())
}

/// Mixture of grains of 2500 kg/m³ in water.
pub fn grains_in_water(porosity: f64) -> Mixture {
    let densities = MixtureDensities { grain: 2500.0, fluid: 1000.0, gravity: 9.81 };
    Mixture { densities, porosity, is_saturated: true }
}

/// Ratio of smoothing length to spacing at which sums over a lattice are uniform.
const UNIFORM_SUM_RATIO: f64 = 2.0;

/// Periodic layer of a constant depth (m) of eight nodes a metre apart. `shares` are the shares of the phases.
pub fn endless_layer(mut settings: FlowSettings<1>, depth: f64, shares: &[f64]) -> Result<Flow<1>, String> {
    let count = 8;
    settings.numerics.variable_length = false;
    let even = |k: i32, share: f64| NewNode {
        length: UNIFORM_SUM_RATIO,
        scale: UNIFORM_SUM_RATIO,
        ..line_node(f64::from(k) + 0.5, 0.0, share * depth, 1.0)
    };
    let set = |share: &f64| (0..count).map(|k| even(k, *share)).collect();
    let sets: Vec<Vec<NewNode<1>>> = shares.iter().map(set).collect();
    let ends = PlanBoundaries { periods: [Some((0.0, f64::from(count)))], ..PlanBoundaries::default() };
    Flow::new(settings, Bed::Flat(0.0), ends, &sets).map_err(|failure| failure.to_string())
}

/// Flow of a single node: a block of a depth (m), at `x` (m) with the plan velocity `velocity` (m/s).
pub fn block(
    mut settings: FlowSettings<1>,
    bed: Bed<1>,
    depth: f64,
    x: f64,
    velocity: f64,
) -> Result<Flow<1>, String> {
    settings.numerics.variable_length = false;
    let volume = depth / settings.numerics.kernel.value::<1>(0.0, 1.5);
    let nodes = vec![line_node(x, velocity, volume, 1.0)];
    Flow::new(settings, bed, PlanBoundaries::default(), &[nodes]).map_err(|failure| failure.to_string())
}

/// Makes steps of at most `longest` (s) until `end` (s).
pub fn step_with_limit<const D: usize>(flow: &mut Flow<D>, longest: f64, end: f64) -> Result<(), String> {
    while flow.clock.time < end * (1.0 - 1e-12) {
        let dt = flow.limit().dt.min(longest).min(end - flow.clock.time);
        flow.advance(dt).map_err(|failure| failure.to_string())?;
    }
    Ok(())
}
