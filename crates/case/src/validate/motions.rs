//! Rules of prescribed motions in a stage.

use std::collections::HashSet;

use crate::description::{PrescribedMotion, Space, Stage, Velocity};

use crate::CaseErrorKind;
use crate::error_collector::ErrorCollector;

impl ErrorCollector<'_> {
    /// Checks the prescribed motions of a stage.
    pub(super) fn motions(&mut self, path: &str, stage: &Stage) {
        let case = self.case;
        let driven = case.movable_names();
        let mut known_targets = HashSet::new();
        for (number, motion) in stage.motions.iter().enumerate() {
            let path = format!("{path}.motions[{number}]");
            let of = format!("{path}.target");
            match case.obstacles.iter().position(|obstacle| obstacle.name == motion.target) {
                Some(number) if !driven.contains(&motion.target.as_str()) => {
                    let free = motion.velocity.contains(&None);
                    let problem = if free || !(motion.force.is_empty() && motion.moment.is_empty()) {
                        format!(
                            "{:?} is an obstacle, whose motion is obstacles[{number}].motion and does not \
                             depend on a force. Use a rigid body, or, for a platen that follows a stress, a \
                             wall in boundaries with a method that supports it",
                            motion.target
                        )
                    } else {
                        let cure = format!("give its motion in obstacles[{number}].motion");
                        format!(
                            "{:?} is an obstacle, whose motion is not part of a stage: {cure}",
                            motion.target
                        )
                    };
                    self.report(of, problem);
                }
                _ => self.name(&of, &motion.target, &driven, "the name of a rigid body or of a patch"),
            }
            let problem = format!("{:?} has two motions in the stage", motion.target);
            self.require(
                known_targets.insert(&motion.target),
                format!("{path}.target"),
                CaseErrorKind::coded("duplicate-name", problem),
            );
            let dimension = case.dimension();
            let count = motion.velocity.len();
            let problem = format!("has {count} entries, the space has {dimension} dimensions");
            self.require(
                count == dimension,
                format!("{path}.velocity"),
                CaseErrorKind::coded("wrong-dimension", problem),
            );
            for (axis, velocity) in motion.velocity.iter().enumerate() {
                velocity.iter().for_each(|v| self.finite(format!("{path}.velocity[{axis}]"), *v));
            }
            self.not_negative(format!("{path}.ramp"), motion.ramp, " (s)");
            self.forces(&path, motion);
        }
    }

    /// Checks forces, moments and rotation, which only rigid bodies have; a force needs a free velocity component.
    fn forces(&mut self, path: &str, motion: &PrescribedMotion) {
        let case = self.case;
        let patch = case.patches.iter().any(|patch| patch.name == motion.target);
        for (key, given) in [
            ("force", !motion.force.is_empty()),
            ("moment", !motion.moment.is_empty()),
            ("turns", motion.rotates),
        ] {
            let problem = "applies to a rigid body only: a patch consists of nodes of a deformable body and \
                           has no mass";
            self.require(
                !(patch && given),
                format!("{path}.{key}"),
                CaseErrorKind::coded("rigid-motion", problem),
            );
        }
        if !motion.force.is_empty() {
            self.vector(&format!("{path}.force"), &motion.force);
        }
        for (axis, force) in motion.force.iter().enumerate() {
            let idle = *force != 0.0 && motion.velocity.get(axis).is_some_and(Option::is_some);
            let problem = "acts along a component whose velocity is prescribed: set that velocity to null";
            self.require(
                !idle,
                format!("{path}.force[{axis}]"),
                CaseErrorKind::coded("rigid-motion", problem),
            );
        }
        for (axis, moment) in motion.moment.iter().enumerate() {
            self.finite(format!("{path}.moment[{axis}]"), *moment);
        }
        let axes = if case.space == Space::ThreeD { 3 } else { 1 };
        let count = motion.moment.len();
        let problem = format!("has {count} entries, but needs one in the plane and three in space");
        self.require(
            count == 0 || count == axes,
            format!("{path}.moment"),
            CaseErrorKind::coded("wrong-dimension", problem),
        );
        let problem =
            CaseErrorKind::coded("rigid-motion", "acts on a body that keeps its orientation: set `turns`");
        self.require(count == 0 || motion.rotates, format!("{path}.moment"), problem);
        let whirls = matches!(case.space, Space::PlaneStrain | Space::ThreeD);
        let problem = "needs a space in which a body can turn: plane-strain or 3d";
        self.require(
            whirls || !motion.rotates,
            format!("{path}.turns"),
            CaseErrorKind::coded("needs-other-key", problem),
        );
        let rigid = case.bodies.iter().any(|body| body.rigid && body.name == motion.target);
        let radial = case.space == Space::Axisymmetric && motion.velocity.first() == Some(&None);
        let problem = "is null, but in axisymmetry a rigid body moves along the axis only: set it to 0";
        self.require(
            !(rigid && radial),
            format!("{path}.velocity[0]"),
            CaseErrorKind::coded("rigid-motion", problem),
        );
    }

    /// Checks that a rigid body with an initial velocity has a free motion in the first stage.
    pub(super) fn start_of_rigid(&mut self, path: &str, number: usize) {
        let body = &self.case.bodies[number];
        if !body.rigid || body.velocity == Velocity::Rest {
            return;
        }
        let first = self.case.stages.first().and_then(|stage| stage.motion_of(&body.name));
        let problem = "a rigid body starts from rest and follows the motions of the stages, unless the \
                       motion of the first stage leaves it free";
        self.require(
            first.is_some_and(PrescribedMotion::is_free),
            path,
            CaseErrorKind::coded("rigid-motion", problem),
        );
        match &body.velocity {
            Velocity::Uniform { .. } | Velocity::Rest => {}
            Velocity::Linear { gradient, .. } => {
                let at =
                    |i: usize, j: usize| gradient.get(i).and_then(|row| row.get(j)).copied().unwrap_or(0.0);
                let turn = (0..3).all(|i| (0..3).all(|j| at(i, j) == -at(j, i)));
                let problem =
                    "of a rigid body must be a rotation: the entries (i, j) and (j, i) are opposite";
                self.require(turn, format!("{path}.gradient"), CaseErrorKind::coded("rigid-motion", problem));
                let turns = first.is_some_and(|motion| motion.rotates);
                let still = gradient.iter().flatten().all(|g| *g == 0.0);
                let problem = "rotates the body, but the motion of the first stage does not allow rotation: \
                               set its `turns`";
                self.require(
                    still || turns,
                    format!("{path}.gradient"),
                    CaseErrorKind::coded("rigid-motion", problem),
                );
            }
            _ => self.report(
                path,
                CaseErrorKind::coded(
                    "rigid-motion",
                    "a rigid body needs a velocity of kind uniform or linear",
                ),
            ),
        }
    }

    /// Rejects motions of bodies that have been removed (`gone`).
    pub(super) fn motions_of_removed(&mut self, stage: usize, gone: &HashSet<&str>) {
        let case = self.case;
        for (number, motion) in case.stages[stage].motions.iter().enumerate() {
            if gone.contains(motion.target.as_str()) {
                let problem = format!("the body {:?} is removed by then", motion.target);
                self.report(format!("stages[{stage}].motions[{number}].target"), problem);
            }
        }
    }
}
