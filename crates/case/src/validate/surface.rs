//! Loads, and sides without a wall.

use super::Findings;
use crate::description::{Boundary, Load, LoadProfile, Side, Wall};
use crate::lines;

impl Findings<'_> {
    pub(super) fn absorbing(&mut self, path: &str, boundary: &Boundary) {
        let Wall::Absorbing { normal, tangential, spring_length } = boundary.wall else { return };
        self.not_negative(format!("{path}.wall.normal"), normal, "");
        self.not_negative(format!("{path}.wall.tangential"), tangential, "");
        if let Some(length) = spring_length {
            self.positive(format!("{path}.wall.spring_length"), length, "m");
        }
        let still = boundary.velocity.is_none();
        self.require(still, format!("{path}.velocity"), "an absorbing boundary is no wall and does not move");
        let problem = "an absorbing boundary is no wall: material leaves it by itself";
        self.require(!boundary.separation, format!("{path}.separation"), problem);
        let problem =
            "an absorbing boundary has a dashpot for the pore fluid, and is neither drained nor shut";
        self.require(!boundary.drained, format!("{path}.drained"), problem);
    }

    pub(super) fn loads(&mut self) {
        let case = self.case;
        let bodies: Vec<&str> = case.bodies.iter().map(|b| b.name.as_str()).collect();
        let stages: Vec<&str> = case.stages.iter().map(|s| s.name.as_str()).collect();
        for (number, load) in case.loads.iter().enumerate() {
            let path = format!("loads[{number}]");
            self.name(&format!("{path}.body"), load.body(), &bodies, "the name of a body");
            let rigid = case.bodies.iter().any(|body| body.rigid && body.name == load.body());
            let problem = format!(
                "the body {:?} is rigid and moves as the stages say, whatever acts on it",
                load.body()
            );
            self.require(!rigid, format!("{path}.body"), problem);
            self.side(&format!("{path}.side"), load.side());
            if let Some(stage) = load.stage() {
                self.name(&format!("{path}.stage"), stage, &stages, "the name of a stage");
            }
            if load.begins(&case.stages).is_some_and(|stage| case.is_removed(load.body(), stage)) {
                let key = if load.stage().is_some() { "stage" } else { "body" };
                let problem = format!("the body {:?} is removed by then", load.body());
                self.report(format!("{path}.{key}"), problem);
            }
            match load {
                Load::Traction { value, .. } => self.vector(&format!("{path}.value"), value),
                Load::Pressure { value, .. } => self.finite(format!("{path}.value"), *value),
                Load::PorePressure { value, .. } => {
                    self.finite(format!("{path}.value"), *value);
                    self.pore_load(&path, load);
                }
            }
            self.not_negative(format!("{path}.ramp"), load.ramp().0, " (s)");
            if let Some(profile) = load.profile() {
                self.profile(&format!("{path}.profile"), profile, load.side());
            }
        }
    }

    fn profile(&mut self, path: &str, profile: &LoadProfile, side: Side) {
        let (axis, dimension) = (profile.axis.number(), self.case.dimension());
        let problem = format!("a space of {dimension} dimensions does not have this axis");
        self.require(axis < dimension, format!("{path}.axis"), problem);
        let problem = format!("is normal to the side {side}: a load varies along its side");
        self.require(axis != side.axis(), format!("{path}.axis"), problem);
        let problem = "needs two entries or more; leave out the profile of what is the same everywhere";
        self.require(profile.shares.len() > 1, format!("{path}.shares"), problem);
        for (number, [at, share]) in profile.shares.iter().enumerate() {
            self.finite(format!("{path}.shares[{number}][0]"), *at);
            self.finite(format!("{path}.shares[{number}][1]"), *share);
        }
        for (number, at, before) in lines::descents(profile.shares.iter().map(|[at, _]| *at), true) {
            let problem = format!("{at} m lies before the entry above it, at {before} m");
            self.report(format!("{path}.shares[{number}][0]"), problem);
        }
    }

    /// A pore pressure needs pores, and no wall that prescribes the motion of their fluid.
    fn pore_load(&mut self, path: &str, load: &Load) {
        let (case, side) = (self.case, load.side());
        let Some(body) = case.bodies.iter().find(|body| body.name == load.body()) else { return };
        let problem = format!("the body {:?} has no pore_fluid", body.name);
        self.require(body.pore_fluid.is_some(), format!("{path}.body"), problem);
        let dimension = case.dimension();
        if body.shape.validate(dimension).is_err() || side.axis() >= dimension {
            return;
        }
        let (low, high) = body.shape.bounds(dimension);
        let face = if side.is_max() { high } else { low }[side.axis()];
        let Some((min, max)) = self.extent(side.axis()) else { return };
        let shut = case.boundaries.iter().find(|boundary| {
            let at_face = (boundary.position(&case.domain) - face).abs() < 1e-9 * (max - min);
            boundary.side == side && at_face && !boundary.drained
        });
        if let Some(wall) = shut {
            let problem = format!("the wall {:?} stands there and lets no fluid through", wall.name());
            self.report(format!("{path}.side"), problem);
        }
    }
}
