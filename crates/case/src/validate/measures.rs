//! Rules of measures.

use super::ErrorCollector;
use super::motions::movable_names;
use crate::description::{CrackTip, Measure, Obstacle, ObstacleShape, Space};
use crate::output::{PLAIN_NAME_RULE, is_plain};

impl ErrorCollector<'_> {
    /// Checks the measures.
    pub(super) fn measures(&mut self) {
        let case = self.case;
        let dimension = case.dimension();
        for (name, measure) in &case.measures {
            let path = format!("measures.{name}");
            self.require(is_plain(name), path.clone(), PLAIN_NAME_RULE);
            match measure {
                Measure::Front { side, quantile, cell, bodies }
                | Measure::RunOut { side, quantile, cell, bodies, .. } => {
                    self.counted_bodies(&path, bodies.as_deref());
                    self.check_side(&format!("{path}.side"), *side);
                    self.quantile(&path, *quantile);
                    if let Some(cell) = cell {
                        self.positive(format!("{path}.cell"), *cell, "m");
                        let problem = "a quantile below 1 does not use cells";
                        self.require(*quantile == 1.0, format!("{path}.cell"), problem);
                    }
                    if let Measure::RunOut { origin, initial_length, .. } = measure {
                        self.finite(format!("{path}.origin"), *origin);
                        self.positive(format!("{path}.initial_length"), *initial_length, "m");
                    }
                }
                Measure::Gauge { .. } | Measure::Discharge { .. } => self.flow_measure(&path, measure),
                Measure::FactorOfSafety(search) => self.factor_of_safety(&path, search),
                Measure::Dissipation {} => {}
                Measure::Profile { axis, height, bin, bodies } => {
                    self.counted_bodies(&path, bodies.as_deref());
                    let fits = *axis < dimension && *height < dimension && axis != height;
                    let problem =
                        format!("{axis} and height {height} must be two different axes of the space");
                    self.require(fits, format!("{path}.axis"), problem);
                    self.positive(format!("{path}.bin"), *bin, "m");
                }
                Measure::ArcFront { .. } => self.arc_front(&path, measure),
                Measure::CrackTip(tip) => self.crack_tip(&path, tip),
                Measure::Fragments { .. } => self.fragments(&path, measure),
                Measure::Reaction { target: of, about } => self.reaction(&path, of, about),
                Measure::ImpactPressure { target: of, direction, area } => {
                    self.reaction_target(&path, of);
                    self.vector(&format!("{path}.direction"), direction);
                    let still = direction.iter().all(|c| *c == 0.0);
                    self.require(!still, format!("{path}.direction"), "must not be zero");
                    self.positive(format!("{path}.area"), *area, "m²; m in plane strain");
                }
                Measure::Probe { position, radius, fields } => {
                    let problem =
                        format!("has {} entries, the space has {dimension} dimensions", position.len());
                    self.require(position.len() == dimension, format!("{path}.position"), problem);
                    self.places_inside(&format!("{path}.position"), position);
                    self.positive(format!("{path}.radius"), *radius, "m");
                    self.require(!fields.is_empty(), format!("{path}.fields"), "name at least one field");
                    for (number, field) in fields.iter().enumerate() {
                        let problem =
                            format!("{field:?}: names of fields are made of letters, digits, _ and -");
                        self.require(is_plain(field), format!("{path}.fields[{number}]"), problem);
                    }
                }
            }
        }
    }

    /// Checks the target of a reaction, and the position about which its moment is taken.
    fn reaction(&mut self, path: &str, of: &str, about: &[f64]) {
        self.reaction_target(path, of);
        if about.is_empty() {
            return;
        }
        let path = &format!("{path}.about");
        let problem = "a moment about a place is available in plane-strain and 3d only";
        let space = self.case.space;
        self.require(matches!(space, Space::PlaneStrain | Space::ThreeD), path, problem);
        self.vector(path, about);
        let is_obstacle = self.case.obstacles.iter().any(|obstacle| obstacle.name == of);
        let problem = format!(
            "moments are available on obstacles only, and {of:?} is not an obstacle: leave the place out"
        );
        self.require(is_obstacle, path, problem);
    }

    /// Checks that the target of a reaction is a rigid body, a patch or an obstacle.
    fn reaction_target(&mut self, path: &str, of: &str) {
        let mut known = movable_names(self.case);
        known.extend(self.case.obstacles.iter().map(|obstacle| obstacle.name.as_str()));
        let what = "the name of a rigid body, a patch or an obstacle";
        self.name(&format!("{path}.target"), of, &known, what);
    }

    /// Checks a front measured along the ground line of an obstacle.
    fn arc_front(&mut self, path: &str, measure: &Measure) {
        let Measure::ArcFront { obstacle: of, quantile, zero, bodies } = measure else { return };
        self.counted_bodies(path, bodies.as_deref());
        let is_line = |obstacle: &&Obstacle| {
            matches!(obstacle.shape, ObstacleShape::Profile { .. } | ObstacleShape::GroundLine { .. })
        };
        let lines = self.case.obstacles.iter().filter(is_line);
        let lines: Vec<&str> = lines.map(|obstacle| obstacle.name.as_str()).collect();
        self.name(
            &format!("{path}.obstacle"),
            of,
            &lines,
            "the name of an obstacle that is a profile or a ground-line",
        );
        self.quantile(path, *quantile);
        self.finite(format!("{path}.zero"), *zero);
    }

    /// Checks that a quantile of mass is in 0..=1, 0 excluded.
    fn quantile(&mut self, path: &str, quantile: f64) {
        let problem = format!("{quantile} is not in 0..=1 (0 excluded)");
        self.require(quantile > 0.0 && quantile <= 1.0, format!("{path}.quantile"), problem);
    }

    /// Checks a count of fragments.
    fn fragments(&mut self, path: &str, measure: &Measure) {
        let Measure::Fragments { link, bodies, broken, .. } = measure else { return };
        self.counted_bodies(path, bodies.as_deref());
        self.positive(format!("{path}.link"), *link, "m");
        if let Some(broken) = broken {
            self.finite(format!("{path}.broken.max"), broken.max);
            let problem = format!("{:?}: names of fields are made of letters, digits, _ and -", broken.field);
            self.require(is_plain(&broken.field), format!("{path}.broken.field"), problem);
        }
    }

    /// Checks the measure of the distance that a crack has propagated.
    fn crack_tip(&mut self, path: &str, tip: &CrackTip) {
        let bodies: Vec<&str> = self.case.bodies.iter().map(|body| body.name.as_str()).collect();
        self.name(&format!("{path}.body"), &tip.body, &bodies, "the name of a body");
        self.vector(&format!("{path}.direction"), &tip.direction);
        let still = tip.direction.iter().all(|c| *c == 0.0);
        self.require(!still, format!("{path}.direction"), "must not be zero");
        self.vector(&format!("{path}.from"), &tip.from);
        self.finite(format!("{path}.threshold"), tip.threshold);
        self.positive(format!("{path}.bin"), tip.bin, "m");
    }

    /// Checks gauges and lines in plan.
    fn flow_measure(&mut self, path: &str, measure: &Measure) {
        let dimension = self.case.dimension();
        match measure {
            Measure::Gauge { position } => {
                let problem = format!("has {} coordinates, the plan has {}", position.len(), dimension - 1);
                self.require(position.len() + 1 == dimension, format!("{path}.position"), problem);
                self.places_inside(&format!("{path}.position"), position);
            }
            Measure::Discharge { from, to } => {
                self.require(dimension == 3, path, "a line across a flow needs a space of 3d");
                self.require(from != to, format!("{path}.to"), "must differ from the start of the line");
                self.places_inside(&format!("{path}.from"), from);
                self.places_inside(&format!("{path}.to"), to);
            }
            _ => {}
        }
    }

    /// Checks that a position is in the domain.
    fn places_inside(&mut self, path: &str, place: &[f64]) {
        for (axis, x) in place.iter().enumerate().take(self.case.dimension()) {
            if x.is_finite() {
                self.require_inside(format!("{path}[{axis}]"), axis, *x);
            } else {
                self.finite(format!("{path}[{axis}]"), *x);
            }
        }
    }

    /// Checks the names of the bodies that a measure counts.
    pub(super) fn counted_bodies(&mut self, path: &str, names: Option<&[String]>) {
        let Some(names) = names else { return };
        self.require(!names.is_empty(), format!("{path}.bodies"), "name at least one body, or leave it out");
        let bodies: Vec<&str> = self.case.bodies.iter().map(|body| body.name.as_str()).collect();
        for (number, name) in names.iter().enumerate() {
            self.name(&format!("{path}.bodies[{number}]"), name, &bodies, "the name of a body");
        }
    }
}
