//! Validation of a case beyond its schema.

mod bodies;
mod body_extents;
pub(crate) mod case_warnings;
pub(crate) mod closed_liquid_check;
mod equilibrium;
mod loads;
mod measures;
mod motions;
mod obstacles;
mod removal_shapes;
mod strength_reduction;
pub(crate) mod time_scales;
pub(crate) mod unit_checks;

use std::collections::HashSet;

use crate::CaseErrorKind;
use crate::description::{Boundary, Side, Space, Stage, Wall};
use crate::error_collector::ErrorCollector;
use crate::{Case, CaseError, CaseErrors};

/// Largest distance of a domain from zero, over its size: beyond it positions lose more than three of their sixteen digits.
pub const MAX_DISTANCE_RATIO: f64 = 1e3;

/// Largest number of nodes of an output grid: larger files are impractical to open.
const MAX_NODES: f64 = 1e8;
/// Largest number of frames of a run: more are impractical to keep.
const MAX_FRAMES: f64 = 1e5;

/// Checks all rules that the schema does not contain.
///
/// # Errors
/// Every violation found, with its JSON path.
pub fn validate(case: &Case) -> Result<(), CaseErrors> {
    let mut findings = ErrorCollector { case, errors: Vec::new(), origin: [0.0; 3] };
    findings.check_domain();
    findings.materials();
    findings.bodies();
    findings.boundaries();
    findings.obstacles();
    findings.loads();
    findings.patches();
    findings.removal_shapes();
    findings.stages();
    findings.output();
    findings.measures();
    findings.methods();
    if findings.errors.is_empty() { Ok(()) } else { Err(CaseErrors(findings.errors)) }
}

/// Checks the positions of bodies with these numbers after their layers are placed.
///
/// # Errors
/// Every violation found, with its JSON path.
pub(crate) fn validate_layers(case: &Case, layered: &[usize]) -> Result<(), CaseErrors> {
    let mut findings = ErrorCollector { case, errors: Vec::new(), origin: case.origin() };
    findings.layers(layered);
    if findings.errors.is_empty() { Ok(()) } else { Err(CaseErrors(findings.errors)) }
}

impl ErrorCollector<'_> {
    /// Check of the domain: corners, gravity, origin and periodic axes.
    fn check_domain(&mut self) {
        let case = self.case;
        self.vector("domain.min", &case.domain.min);
        self.vector("domain.max", &case.domain.max);
        self.vector("gravity", &case.gravity);
        for (axis, (min, max)) in case.domain.min.iter().zip(&case.domain.max).enumerate() {
            self.rule(min < max, format!("domain.max[{axis}]"), *max, format!("must be above min, {min}"));
        }
        self.origin();
        for (number, axis) in case.domain.periodic.iter().enumerate() {
            let path = format!("domain.periodic[{number}]");
            let dimension = case.dimension();
            let problem = format!("a space of {dimension} dimensions does not have this axis");
            self.require(
                axis.number() < dimension,
                path.clone(),
                CaseErrorKind::coded("wrong-dimension", problem),
            );
            let twice = case.domain.periodic[..number].contains(axis);
            self.require(!twice, path.clone(), CaseErrorKind::coded("duplicate-name", "is named twice"));
            let radial = case.space == Space::Axisymmetric && axis.number() == 0;
            self.require(!radial, path, "the distance from the axis of symmetry cannot be periodic");
        }
        if case.space == Space::Axisymmetric {
            let smallest = case.domain.min.first().copied().unwrap_or(0.0);
            let rule = "must not be negative: in axisymmetry x is the distance from the axis";
            self.rule(smallest >= 0.0, "domain.min[0]", smallest, rule);
            let radial = case.gravity.first().copied().unwrap_or(0.0);
            self.require(radial == 0.0, "gravity[0]", "must be 0: radial gravity is not axisymmetric");
        }
    }

    /// Checks that a domain far from zero has an origin near it.
    fn origin(&mut self) {
        let domain = &self.case.domain;
        if !domain.origin.is_empty() {
            self.vector("domain.origin", &domain.origin);
            let radial = self.case.space == Space::Axisymmetric && domain.origin[0] != 0.0;
            self.require(!radial, "domain.origin[0]", "must be 0: x is the distance from the axis");
            return;
        }
        let extent = domain.max_extent();
        let far = |x: &f64| x.abs() > MAX_DISTANCE_RATIO * extent;
        if extent > 0.0 && domain.min.iter().chain(&domain.max).any(far) {
            let round = 10f64.powf(extent.log10().ceil());
            let near: Vec<f64> = domain.min.iter().map(|x| (x / round).round() * round).collect();
            let problem = format!(
                "is farther from zero than {MAX_DISTANCE_RATIO} times the size of the domain, {extent} m, so \
                 positions lose digits. Give domain.origin a place near the domain, for example {near:?}"
            );
            self.report("domain.min", CaseErrorKind::coded("far-from-origin", problem));
        }
    }

    /// Checks the parameters of the materials.
    fn materials(&mut self) {
        let case = self.case;
        for (name, spec) in &case.materials {
            let path = format!("materials.{name}");
            match spec.build() {
                Ok(law) => {
                    let flat = matches!(case.space, Space::OneD | Space::PlaneStrain);
                    let problem =
                        "its law has no strain normal to the plane: use it in 1d and plane-strain only";
                    self.require(flat || !law.requires_plane_strain(), &path, problem);
                }
                Err(error) => self.errors.push(CaseError::of_material(&path, error)),
            }
            if spec.assumes_plane_strain() && case.space != Space::PlaneStrain {
                let problem =
                    "plane-strain matchings hold in plane strain only; use compression or extension";
                self.report(format!("{path}.matching"), problem);
            }
        }
    }

    /// Checks the boundaries on the sides of the domain.
    fn boundaries(&mut self) {
        let case = self.case;
        let mut names = HashSet::new();
        let mut known_walls: Vec<(Side, f64)> = Vec::new();
        for (number, boundary) in case.boundaries.iter().enumerate() {
            let path = format!("boundaries[{number}]");
            self.check_side(&format!("{path}.side"), boundary.side);
            if !names.insert(boundary.name()) {
                self.report(
                    format!("{path}.name"),
                    CaseErrorKind::coded(
                        "duplicate-name",
                        format!("{:?} is the name of two boundaries", boundary.name()),
                    ),
                );
            }
            let open = !case.domain.is_periodic(boundary.side.axis());
            self.require(open, format!("{path}.side"), "the domain is periodic along the axis of this side");
            if let (Some(group), Some(_)) = (&boundary.group, boundary.position) {
                let problem = format!(
                    "the wall applies to the nodes of the group {group:?}, wherever they are: leave the \
                     position out"
                );
                self.report(format!("{path}.position"), CaseErrorKind::coded("conflicting-keys", problem));
            }
            if boundary.group.is_none() && self.extent(boundary.side.axis()).is_some() {
                let position = boundary.wall_coordinate(&case.domain);
                self.require_inside(format!("{path}.position"), boundary.side.axis(), position);
                if case.space == Space::Axisymmetric
                    && (boundary.side, position) == (Side::XMin, 0.0)
                    && boundary.wall != Wall::Smooth
                {
                    let problem = "x = 0 is the axis of symmetry, which is smooth: make the wall smooth or \
                                   leave it out";
                    self.report(
                        format!("{path}.wall.kind"),
                        CaseErrorKind::coded("conflicting-keys", problem),
                    );
                }
                if known_walls.contains(&(boundary.side, position)) {
                    self.report(
                        format!("{path}.side"),
                        CaseErrorKind::coded("duplicate-name", "another wall has the same side and position"),
                    );
                }
                known_walls.push((boundary.side, position));
            }
            if let Wall::Frictional { friction_coefficient: value, bilateral } = boundary.wall {
                self.not_negative(format!("{path}.wall.friction_coefficient"), value, "");
                let problem = "the wall is bilateral: material cannot separate from it";
                self.require(!(bilateral && boundary.separation), format!("{path}.separation"), problem);
            }
            if let Some(velocity) = &boundary.velocity {
                self.vector(&format!("{path}.velocity"), velocity);
            }
            self.absorbing(&path, boundary);
            self.check_drainage(&path, boundary.drained);
        }
    }

    /// Checks the patches: regions whose points have a prescribed motion or drainage.
    fn patches(&mut self) {
        let case = self.case;
        let mut names: HashSet<&String> = case.bodies.iter().map(|body| &body.name).collect();
        for (number, patch) in case.patches.iter().enumerate() {
            let path = format!("patches[{number}]");
            if !names.insert(&patch.name) {
                let problem = format!("{:?} is also the name of a body or another patch", patch.name);
                self.report(format!("{path}.name"), CaseErrorKind::coded("duplicate-name", problem));
            }
            if let Err(error) = patch.region.validate(case.dimension()) {
                self.report(format!("{path}.region.{}", error.path), error.problem);
            }
            self.check_drainage(&path, patch.drained);
        }
    }

    /// Checks that a drained boundary or patch has a pore fluid to drain.
    fn check_drainage(&mut self, path: &str, drained: bool) {
        let saturated = self.case.bodies.iter().any(|body| body.pore_fluid.is_some());
        let problem = "no body has a pore_fluid that could drain";
        self.require(saturated || !drained, format!("{path}.drained"), problem);
    }

    /// Checks the stages.
    fn stages(&mut self) {
        let case = self.case;
        self.require(!case.stages.is_empty(), "stages", "at least one stage is needed");
        let (mut names, mut gone) = (HashSet::new(), HashSet::new());
        for (number, stage) in case.stages.iter().enumerate() {
            let path = format!("stages[{number}]");
            if !names.insert(&stage.name) {
                self.report(
                    format!("{path}.name"),
                    CaseErrorKind::coded(
                        "duplicate-name",
                        format!("{:?} is the name of two stages", stage.name),
                    ),
                );
            }
            self.stage(&path, stage);
            gone.extend(stage.remove_bodies.iter().map(String::as_str));
            self.motions_of_removed(number, &gone);
            self.equilibrium(number);
            self.weakening(number);
        }
    }

    /// Checks the duration, damping, ramps and motions of a stage.
    fn stage(&mut self, path: &str, stage: &Stage) {
        let case = self.case;
        let (duration, damping, ramp) = (stage.duration, stage.damping, stage.gravity_ramp);
        self.positive(format!("{path}.duration"), duration, "s");
        let holds = (0.0..1.0).contains(&damping);
        self.rule(holds, format!("{path}.damping"), damping, "is not in 0..1 (1 excluded)");
        let rule = format!("is not between 0 and the stage's duration, {duration} s");
        self.rule((0.0..=duration).contains(&ramp), format!("{path}.gravity_ramp"), ramp, rule);
        self.not_negative(format!("{path}.rayleigh_damping"), stage.rayleigh_damping, " (1/s)");
        self.motions(path, stage);
        for (number, axis) in stage.damping_axes.iter().flatten().enumerate() {
            let problem = format!("{axis} is not an axis of a space of {} dimensions", case.dimension());
            self.require(
                *axis < case.dimension(),
                format!("{path}.damping_axes[{number}]"),
                CaseErrorKind::coded("wrong-dimension", problem),
            );
        }
        let boundaries: Vec<&str> = case.boundaries.iter().map(Boundary::name).collect();
        for (number, name) in stage.remove_boundaries.iter().enumerate() {
            let path = format!("{path}.remove_boundaries[{number}]");
            self.name(&path, name, &boundaries, "the name of a boundary");
        }
        for (number, shape) in stage.excavate.iter().enumerate() {
            if let Err(error) = shape.validate(case.dimension()) {
                self.report(format!("{path}.excavate[{number}].{}", error.path), error.problem);
            }
        }
        let bodies: Vec<&str> = case.bodies.iter().map(|b| b.name.as_str()).collect();
        for (number, name) in stage.remove_bodies.iter().enumerate() {
            self.name(&format!("{path}.remove_bodies[{number}]"), name, &bodies, "the name of a body");
        }
    }

    /// Checks the intervals and fields of the output.
    fn output(&mut self) {
        let output = &self.case.output;
        let end = self.case.end_time();
        for (key, interval) in [("frames", output.frames), ("measures", output.measures)] {
            let Some(interval) = interval else { continue };
            let path = format!("output.{key}");
            let count = end / interval;
            let fits = !(count.is_finite() && count > MAX_FRAMES);
            self.positive(path.clone(), interval, "s");
            self.require(
                fits,
                path,
                CaseErrorKind::coded(
                    "too-many-points",
                    format!("{interval} s would give {count:.1e} outputs"),
                ),
            );
        }
        self.positive("output.checkpoint", output.checkpoint, "s");
        let some = output.fields.as_ref().is_none_or(|fields| !fields.is_empty());
        self.require(
            some,
            "output.fields",
            CaseErrorKind::coded(
                "conflicting-keys",
                "name at least one field, or leave it out for all of them",
            ),
        );
        if let Some(cell) = output.grid {
            self.grid(cell);
        }
        if let Some(rasters) = &output.rasters {
            self.positive("output.rasters.threshold", rasters.threshold, "m");
            rasters.cell.iter().for_each(|cell| self.positive("output.rasters.cell", *cell, "m"));
        }
    }

    /// Checks the grid on which frames are averaged.
    fn grid(&mut self, cell: f64) {
        let path = || "output.grid".to_owned();
        self.positive(path(), cell, "m");
        let case = self.case;
        let fits = case.domain.min.len() == case.dimension() && case.domain.max.len() == case.dimension();
        if !(cell > 0.0 && fits) {
            return;
        }
        let nodes = case.grid_nodes(cell);
        self.require(
            nodes <= MAX_NODES,
            path(),
            CaseErrorKind::coded(
                "too-many-points",
                format!("cells of {cell} m would give {nodes:.1e} nodes"),
            ),
        );
        for axis in
            case.domain.periodic.iter().map(|axis| axis.number()).filter(|axis| *axis < case.dimension())
        {
            let cells = (case.domain.max[axis] - case.domain.min[axis]) / cell;
            let whole = (cells - cells.round()).abs() < 1e-6;
            self.require(
                whole,
                path(),
                format!("{cell} m does not divide the period along an axis into whole cells"),
            );
        }
    }

    /// Checks that the options of each method are an object.
    fn methods(&mut self) {
        for (name, options) in &self.case.methods {
            let problem = "the options of a method must be an object";
            self.require(options.is_object(), format!("methods.{name}"), problem);
        }
    }
}
