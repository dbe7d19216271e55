//! Runs of a flow without a case.

use colluvium_depth_sph::flow::Flow;
use colluvium_testkit::single_threaded;

/// Takes the largest stable steps until the time is `end` (s).
pub fn advance_flow_to<const D: usize>(flow: &mut Flow<D>, end: f64) {
    single_threaded();
    while flow.clock.time < end {
        let dt = flow.limit().dt.min(end - flow.clock.time);
        flow.advance(dt).unwrap();
    }
}
