//! Material point method.

mod aluminium_bars;
mod axisymmetric;
mod bar;
mod cantilever;
mod clay_cut;
mod column_a04;
mod column_collapse;
mod contact;
mod exact_properties;
mod footing;
pub(super) mod inclined_block;
mod kinematics;
mod liquid;
mod manufactured;
mod obstacle_heaps;
mod obstacle_points;
mod rigid_block;
mod rigid_motion;
mod rough_slope;
mod saturated;
mod self_weight;
mod shape_functions;
mod simplices;
mod simplices_soil;
mod slope;
mod step_wave;
mod two_disks;
mod two_phase;

use crate::benchmarks::Benchmark;

/// Benchmarks, in the order of the report.
pub const ALL: &[Benchmark] = &[
    kinematics::BENCHMARK,
    rigid_motion::BENCHMARK,
    bar::BENCHMARK,
    self_weight::BENCHMARK,
    two_disks::BENCHMARK,
    manufactured::AXIS_ALIGNED,
    manufactured::VORTEX,
    cantilever::BENCHMARK,
    simplices::BENCHMARK,
    simplices_soil::BENCHMARK,
    contact::BENCHMARK,
    rigid_block::BENCHMARK,
    inclined_block::BENCHMARK,
    obstacle_points::BENCHMARK,
    obstacle_heaps::HEAPS,
    obstacle_heaps::TERRAIN,
    rough_slope::BENCHMARK,
    two_phase::CONSOLIDATION,
    two_phase::WAVES,
    exact_properties::BENCHMARK,
    step_wave::BENCHMARK,
    footing::BENCHMARK,
    clay_cut::BENCHMARK,
    slope::BENCHMARK,
    axisymmetric::BENCHMARK,
    saturated::PHASES,
    saturated::GRAVITY,
    saturated::ABSORBING,
    liquid::HYDROSTATIC,
    liquid::VISCOUS,
    liquid::DAM_BREAK,
    column_collapse::BENCHMARK,
    column_a04::BENCHMARK,
    aluminium_bars::BENCHMARK,
];
