//! Rules of loads, and of sides without a wall.

use crate::CaseErrorKind;
use crate::description::{Boundary, Load, LoadProfile, Side, Wall};
use crate::error_collector::ErrorCollector;
use crate::files::piecewise_linear;

impl ErrorCollector<'_> {
    /// Checks the dashpots and springs of an absorbing boundary.
    pub(super) fn absorbing(&mut self, path: &str, boundary: &Boundary) {
        let Wall::Absorbing { normal, tangential, spring_length } = boundary.wall else { return };
        self.not_negative(format!("{path}.wall.normal"), normal, "");
        self.not_negative(format!("{path}.wall.tangential"), tangential, "");
        if let Some(length) = spring_length {
            self.positive(format!("{path}.wall.spring_length"), length, "m");
        }
        let still = boundary.velocity.is_none();
        self.require(
            still,
            format!("{path}.velocity"),
            "an absorbing boundary is not a wall and cannot move",
        );
        let problem = "an absorbing boundary is not a wall: material separates from it without this key";
        self.require(!boundary.separation, format!("{path}.separation"), problem);
        let problem =
            "an absorbing boundary has a dashpot for the pore fluid and is neither drained nor closed";
        self.require(!boundary.drained, format!("{path}.drained"), problem);
    }

    /// Checks the loads.
    pub(super) fn loads(&mut self) {
        let case = self.case;
        let bodies: Vec<&str> = case.bodies.iter().map(|b| b.name.as_str()).collect();
        let stages: Vec<&str> = case.stages.iter().map(|s| s.name.as_str()).collect();
        for (number, load) in case.loads.iter().enumerate() {
            let path = format!("loads[{number}]");
            self.name(&format!("{path}.body"), load.body(), &bodies, "the name of a body");
            let rigid = case.bodies.iter().any(|body| body.rigid && body.name == load.body());
            let problem = format!(
                "the body {:?} is rigid: give the force in `motions` of a stage, with the velocity null",
                load.body()
            );
            self.require(!rigid, format!("{path}.body"), CaseErrorKind::coded("rigid-motion", problem));
            if let Some(side) = load.loaded_side() {
                self.check_side(&format!("{path}.side"), side);
            }
            if let Some(stage) = load.stage() {
                self.name(&format!("{path}.stage"), stage, &stages, "the name of a stage");
            }
            if load.first_stage(&case.stages).is_some_and(|stage| case.is_removed(load.body(), stage)) {
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
                Load::Surface { .. } => self.surface_load(&path, load),
            }
            self.not_negative(format!("{path}.ramp"), load.ramp().0, " (s)");
            if let (Some(profile), Some(side)) = (load.profile(), load.loaded_side()) {
                self.profile(&format!("{path}.profile"), profile, side);
            }
        }
    }

    /// Checks a pressure and a shear traction on a part of a surface.
    fn surface_load(&mut self, path: &str, load: &Load) {
        let Load::Surface { body, within, pressure, shear, axis, .. } = load else { return };
        let (case, dimension) = (self.case, self.case.dimension());
        self.finite(format!("{path}.pressure"), *pressure);
        self.finite(format!("{path}.shear"), *shear);
        let problem = CaseErrorKind::coded("needs-other-key", "has neither a pressure nor a shear");
        self.require(*pressure != 0.0 || *shear != 0.0, path.to_owned(), problem);
        self.require(*shear == 0.0 || dimension > 1, format!("{path}.shear"), "a load in 1d has no shear");
        match axis {
            Some(axis) if dimension == 3 => {
                let turns = axis.iter().all(|c| c.is_finite()) && axis.iter().any(|c| *c != 0.0);
                self.require(
                    turns,
                    format!("{path}.axis"),
                    CaseErrorKind::coded("not-finite", "must be finite and not zero"),
                );
            }
            Some(_) => self.report(
                format!("{path}.axis"),
                CaseErrorKind::coded(
                    "needs-other-key",
                    "applies to 3d only: in two dimensions it is the axis normal to the plane",
                ),
            ),
            None => {
                let problem = "is missing: in space the shear acts along axis × normal";
                self.require(
                    *shear == 0.0 || dimension < 3,
                    format!("{path}.axis"),
                    CaseErrorKind::coded("needs-other-key", problem),
                );
            }
        }
        let Some(region) = within else { return };
        if let Err(error) = region.validate(dimension) {
            self.report(format!("{path}.within.{}", error.path), error.problem);
            return;
        }
        let known = case.bodies.iter().find(|own| own.name == *body);
        let Some(shape) = known.map(|own| &own.shape).filter(|shape| shape.validate(dimension).is_ok())
        else {
            return;
        };
        let ((low, high), (smallest, largest)) = (region.bounds(dimension), shape.bounds(dimension));
        let apart = (0..dimension).any(|c| low[c] > largest[c] || high[c] < smallest[c]);
        self.require(
            !apart,
            format!("{path}.within"),
            CaseErrorKind::coded("overlap", format!("does not overlap the body {body:?}")),
        );
    }

    /// Checks the variation of a load along its side.
    fn profile(&mut self, path: &str, profile: &LoadProfile, side: Side) {
        let (axis, dimension) = (profile.axis.number(), self.case.dimension());
        let problem = format!("a space of {dimension} dimensions does not have this axis");
        self.require(
            axis < dimension,
            format!("{path}.axis"),
            CaseErrorKind::coded("wrong-dimension", problem),
        );
        let problem = format!("is normal to the side {side}: a load varies along its side");
        self.require(axis != side.axis(), format!("{path}.axis"), problem);
        let problem = "needs two entries or more. For a uniform load leave the profile out";
        self.require(
            profile.shares.len() > 1,
            format!("{path}.shares"),
            CaseErrorKind::coded("conflicting-keys", problem),
        );
        for (number, [at, share]) in profile.shares.iter().enumerate() {
            self.finite(format!("{path}.shares[{number}][0]"), *at);
            self.finite(format!("{path}.shares[{number}][1]"), *share);
        }
        for (number, at, before) in
            piecewise_linear::non_ascending(profile.shares.iter().map(|[at, _]| *at), true)
        {
            let problem = format!("{at} m lies before the entry above it, at {before} m");
            self.report(format!("{path}.shares[{number}][0]"), problem);
        }
    }

    /// Checks a pore pressure, which needs a pore fluid and no wall that prescribes the motion of the fluid.
    fn pore_load(&mut self, path: &str, load: &Load) {
        let (case, Some(side)) = (self.case, load.loaded_side()) else { return };
        let Some(body) = case.bodies.iter().find(|body| body.name == load.body()) else { return };
        let problem =
            CaseErrorKind::coded("needs-other-key", format!("the body {:?} has no pore_fluid", body.name));
        self.require(body.pore_fluid.is_some(), format!("{path}.body"), problem);
        let dimension = case.dimension();
        if body.shape.validate(dimension).is_err() || side.axis() >= dimension {
            return;
        }
        let (low, high) = body.shape.bounds(dimension);
        let face = if side.is_max() { high } else { low }[side.axis()];
        let Some((min, max)) = self.extent(side.axis()) else { return };
        let shut = case.boundaries.iter().find(|boundary| {
            let at_face = (boundary.wall_coordinate(&case.domain) - face).abs() < 1e-9 * (max - min);
            boundary.side == side && at_face && !boundary.drained
        });
        if let Some(wall) = shut {
            let problem = format!("the wall {:?} is on that side and is not drained", wall.name());
            self.report(format!("{path}.side"), problem);
        }
    }
}
