//! Ranges of the options (sheet: snow-mpm §7).

use colluvium_case::CaseErrorKind;

use super::{SnowOptions, SnowTransfer, SplineShape};
use colluvium_case::Warning;

/// Name of an option, with its problem.
type OptionProblem = (&'static str, CaseErrorKind);

impl SnowOptions {
    /// Checks the ranges; the error names the option and the rule.
    ///
    /// # Errors
    /// The first option out of range, as (name, problem).
    pub fn validate(&self) -> Result<(), OptionProblem> {
        let rule = |name, value: f64, holds: bool, rule: &str| {
            if holds { Ok(()) } else { Err((name, CaseErrorKind::out_of_range(value, rule))) }
        };
        let positive = |name, value: f64, unit: &str| {
            let text = format!("must be finite and positive{unit}");
            rule(name, value, value.is_finite() && value > 0.0, &text)
        };
        positive("cell_size", self.cell_size, " (m)")?;
        let per_cell = self.points_per_cell;
        rule("points_per_cell", per_cell as f64, (1..=20).contains(&per_cell), "is not in 1..=20")?;
        for (name, value) in
            [("courant_elastic", self.courant_elastic), ("courant_velocity", self.courant_velocity)]
        {
            rule(name, value, value > 0.0 && value <= 1.0, "is not in 0..=1 (0 excluded)")?;
        }
        if let Some(step) = self.time_step {
            positive("time_step", step, " (s)")?;
        }
        if let Some(share) = self.flip_ratio {
            rule("flip_ratio", share, (0.0..=1.0).contains(&share), "is not in 0..=1")?;
        }
        if let Some(time) = self.blend_time {
            positive("blend_time", time, " (s)")?;
            if self.flip_ratio.is_some() {
                return Err(("blend_time", "replaces flip_ratio: give one of them".into()));
            }
        }
        let cutoff = self.node_mass_cutoff;
        rule("node_mass_cutoff", cutoff, (0.0..0.1).contains(&cutoff), "is not in 0..0.1")?;
        if self.shape == SplineShape::Linear && self.transfer == SnowTransfer::Apic {
            let problem = "apic needs cubic or quadratic functions, whose second moment is constant: with \
                           linear functions use flip";
            return Err(("transfer", problem.into()));
        }
        Ok(())
    }

    /// Warnings about permitted but doubtful values of options.
    pub(crate) fn warnings(&self) -> Vec<Warning> {
        let mut found = Vec::new();
        let path = format!("methods.{}", super::NAME);
        if self.points_per_cell < 2 {
            let text = format!(
                "points_per_cell: {}; fewer than 2 points per cell and direction under-sample the grid",
                self.points_per_cell
            );
            found.push(Warning::new("under-sampled", text).at(&path));
        }
        if self.shape == SplineShape::Linear {
            let text = "shape: points that cross cells of linear functions make noise, and refining the grid \
                        makes it worse. Use quadratic or cubic";
            found.push(Warning::new("mesh-crossing", text).at(&path));
        }
        for (name, value) in
            [("courant_elastic", self.courant_elastic), ("courant_velocity", self.courant_velocity)]
        {
            if value > 0.5 {
                let text = format!(
                    "{name}: {value} is above 0.5, beyond which few points per cell and free surfaces become \
                     unstable. Give 0.5 or less"
                );
                found.push(Warning::new("large-courant", text).at(&path));
            }
        }
        let blended = self.flip_ratio.is_some() || self.blend_time.is_some();
        if self.transfer == SnowTransfer::Apic && blended {
            let text = "transfer: apic has no FLIP fraction: flip_ratio and blend_time have no effect. Leave \
                        them out, or use flip";
            found.push(Warning::new("option-without-effect", text).at(&path));
        }
        if let (SnowTransfer::Flip, Some(share)) = (self.transfer, self.flip_ratio)
            && share < 0.95
        {
            let text = format!(
                "flip_ratio: {share} damps motions of the size of a cell within few steps, whatever the \
                 duration of a step: 0.95 to 1 is usual, and apic damps less"
            );
            found.push(Warning::new("strong-numerical-damping", text).at(&path));
        }
        found
    }
}
