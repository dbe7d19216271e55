//! What is compiled here once, for profiles and for plans, and not again in each crate that makes a flow.

use std::any::Any;

use super::{Failure, Flow, Opening};

/// The parts of a flow on which nearly all the rest hangs.
pub struct Compiled<const D: usize> {
    /// First heights and smoothing lengths.
    pub settle: fn(&mut Flow<D>) -> Result<(), Failure>,
    /// Opens sides before the first step.
    pub open: fn(&mut Flow<D>, &[Opening]) -> Result<(), Failure>,
    /// A step of so much time (s).
    pub step: fn(&mut Flow<D>, f64) -> Result<(), Failure>,
}

static PROFILE: Compiled<1> = Compiled { settle: Flow::settle, open: Flow::add_openings, step: Flow::step };
static PLAN: Compiled<2> = Compiled { settle: Flow::settle, open: Flow::add_openings, step: Flow::step };

#[inline(never)]
fn all() -> [&'static dyn Any; 2] {
    [&PROFILE, &PLAN]
}

/// Those of flows in as many dimensions in plan.
///
/// # Errors
/// When that is neither one nor two.
pub fn compiled<const D: usize>() -> Result<&'static Compiled<D>, Failure> {
    all().into_iter().find_map(|one| one.downcast_ref()).ok_or_else(|| Failure {
        node: 0,
        position: Vec::new(),
        reason: "a flow has one or two dimensions in plan".to_owned(),
    })
}
