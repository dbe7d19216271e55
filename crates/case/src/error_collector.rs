//! Collector of the errors of a case, and the checks that its parts share.

use crate::{Case, CaseError, CaseErrorKind, Side};

/// Collector of the errors of a case, with their paths.
pub(crate) struct ErrorCollector<'a> {
    pub(crate) case: &'a Case,
    pub(crate) errors: Vec<CaseError>,
    /// Map coordinates of the origin of the case (m).
    pub(crate) origin: [f64; 3],
}

impl ErrorCollector<'_> {
    /// Adds an error at a JSON path.
    pub(crate) fn report(&mut self, path: impl Into<String>, kind: impl Into<CaseErrorKind>) {
        self.errors.push(CaseError::new(path, kind));
    }

    /// Adds an error where a condition does not hold.
    pub(crate) fn require(&mut self, holds: bool, path: impl Into<String>, kind: impl Into<CaseErrorKind>) {
        if !holds {
            self.report(path, kind);
        }
    }

    /// Adds an error about a number where a rule does not hold.
    pub(crate) fn rule(&mut self, holds: bool, path: impl Into<String>, value: f64, rule: impl Into<String>) {
        self.require(holds, path, CaseErrorKind::out_of_range(value, rule));
    }

    /// Checks that a number is finite.
    pub(crate) fn finite(&mut self, path: impl Into<String>, value: f64) {
        self.rule(value.is_finite(), path, value, "must be finite");
    }

    /// Checks that a number is finite and positive.
    pub(crate) fn positive(&mut self, path: impl Into<String>, value: f64, unit: &str) {
        let holds = value.is_finite() && value > 0.0;
        self.rule(holds, path, value, format!("must be positive ({unit})"));
    }

    /// Checks that a number is finite and not negative.
    pub(crate) fn not_negative(&mut self, path: impl Into<String>, value: f64, unit: &str) {
        let holds = value.is_finite() && value >= 0.0;
        self.rule(holds, path, value, format!("must not be negative{unit}"));
    }

    /// Checks that a vector has one finite component for each dimension.
    pub(crate) fn vector(&mut self, path: &str, vector: &[f64]) {
        let dimension = self.case.dimension();
        let rule = format!("the space has {dimension} dimensions");
        self.require(
            vector.len() == dimension,
            path,
            CaseErrorKind::WrongLength { length: vector.len(), rule },
        );
        for (number, value) in vector.iter().enumerate() {
            self.finite(format!("{path}[{number}]"), *value);
        }
    }

    /// Ends of the domain along an axis (m); `None` where they are missing or invalid, which [`ErrorCollector::check_domain`] reports.
    pub(crate) fn extent(&self, axis: usize) -> Option<(f64, f64)> {
        let domain = &self.case.domain;
        let (min, max) = (*domain.min.get(axis)?, *domain.max.get(axis)?);
        (min.is_finite() && max.is_finite() && min < max).then_some((min, max))
    }

    /// Checks that a coordinate along an axis is in the domain.
    pub(crate) fn require_inside(&mut self, path: String, axis: usize, value: f64) {
        if let Some((min, max)) = self.extent(axis) {
            let rule = format!("is outside the domain, {min} to {max} m");
            self.rule((min..=max).contains(&value), path, value, rule);
        }
    }

    /// Checks that the space has the axis to which a side is normal.
    pub(crate) fn check_side(&mut self, path: &str, side: Side) {
        let dimension = self.case.dimension();
        let problem =
            format!("{side} is normal to an axis that a space of {dimension} dimensions does not have");
        self.require(side.axis() < dimension, path, problem);
    }

    /// Checks that a name is one of the known ones; `what` describes those in the message.
    pub(crate) fn name(&mut self, path: &str, name: &str, known: &[&str], what: &str) {
        if !known.contains(&name) {
            self.report(path, CaseErrorKind::unknown_name(name, known, what));
        }
    }

    /// Checks that a quantile of mass is in 0..=1, 0 excluded.
    pub(crate) fn quantile(&mut self, path: &str, quantile: f64) {
        let holds = quantile > 0.0 && quantile <= 1.0;
        self.rule(holds, format!("{path}.quantile"), quantile, "is not in 0..=1 (0 excluded)");
    }

    /// Checks that a position is in the domain.
    pub(crate) fn places_inside(&mut self, path: &str, place: &[f64]) {
        for (axis, x) in place.iter().enumerate().take(self.case.dimension()) {
            if x.is_finite() {
                self.require_inside(format!("{path}[{axis}]"), axis, *x);
            } else {
                self.finite(format!("{path}[{axis}]"), *x);
            }
        }
    }

    /// Checks the names of the bodies that a measure counts.
    pub(crate) fn counted_bodies(&mut self, path: &str, names: Option<&[String]>) {
        let Some(names) = names else { return };
        self.require(!names.is_empty(), format!("{path}.bodies"), "name at least one body, or leave it out");
        let bodies: Vec<&str> = self.case.bodies.iter().map(|body| body.name.as_str()).collect();
        for (number, name) in names.iter().enumerate() {
            self.name(&format!("{path}.bodies[{number}]"), name, &bodies, "the name of a body");
        }
    }
}
