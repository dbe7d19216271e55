//! Dams along lines, which raise the nodes of the terrain.

use colluvium_case::{Case, CaseError};
use colluvium_points::Raster;
use colluvium_points::surface::distance_to_line;

use crate::config::{DamOptions, DepthOptions};
use crate::setup::option_error;
use colluvium_case::CaseErrorKind;
use colluvium_case::Warning;

/// Height of a dam above the ground at a distance from its crest line (m).
fn height(dam: &DamOptions, distance: f64) -> f64 {
    let beside = (distance - 0.5 * dam.width).max(0.0);
    (dam.height - dam.side_slope * beside).max(0.0)
}

/// Raises the levels of the bed by the dams of a case; where two overlap, the higher one applies. Returns warnings.
pub fn raise_terrain(
    case: &Case,
    options: &DepthOptions,
    raster: &mut Raster,
) -> Result<Vec<Warning>, CaseError> {
    if options.dams.is_empty() {
        return Ok(Vec::new());
    }
    if case.dimension() != 3 {
        return Err(option_error(
            "dams",
            "are lines in plan, which a profile does not have: give the dam as an obstacle",
        ));
    }
    let origin = case.origin();
    let mut added = vec![0.0f64; raster.values.len()];
    let mut warnings = Vec::new();
    for (number, dam) in options.dams.iter().enumerate() {
        let line: Vec<[f64; 2]> = dam.line.iter().map(|x| [x[0] - origin[0], x[1] - origin[1]]).collect();
        let mut highest: f64 = 0.0;
        for (node, added) in added.iter_mut().enumerate().filter(|(node, _)| raster.values[*node].is_finite())
        {
            let place = raster.node_position(node % raster.columns, node / raster.columns);
            let own = height(dam, distance_to_line(&line, place));
            highest = highest.max(own);
            *added = added.max(own);
        }
        if highest == 0.0 {
            let problem = "covers no node of the terrain: it lies outside the terrain, or the dam is \
                           narrower than the cells";
            return Err(option_error(
                &format!("dams[{number}].line"),
                CaseErrorKind::coded("outside-domain", problem),
            ));
        }
        // Between nodes on both sides of the line the crest is as high as the nearest of them.
        let farthest = 0.5 * raster.spacing[0].hypot(raster.spacing[1]);
        let raster_height = height(dam, farthest);
        if raster_height < 0.9 * dam.height {
            let [dx, dy] = raster.spacing;
            warnings.push(Warning::new("low-dam-crest", format!(
                "methods.depth-sph.dams[{number}]: cells of {dx} m by {dy} m reduce its crest to {raster_height:.2} \
                 m in places, instead of {} m: make the dam wider, or the terrain finer",
                dam.height
            )));
        }
    }
    raster.values.iter_mut().zip(added).for_each(|(z, added)| *z += added);
    Ok(warnings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dam_has_its_crest_and_its_sides() {
        let line = [[0.0, 0.0], [10.0, 0.0], [10.0, 5.0]];
        let dam = DamOptions { line: line.to_vec(), height: 4.0, width: 2.0, side_slope: 0.5 };
        let at = |x: [f64; 2]| height(&dam, distance_to_line(&line, x));
        assert_eq!(
            [at([5.0, 0.9]), at([5.0, -3.0]), at([13.0, 3.0])],
            [4.0, 3.0, 3.0],
            "crest, side, beside the second piece"
        );
        assert_eq!(at([-9.0, 0.0]), 0.0, "it ends");
        assert!((at([-3.0, -4.0]) - 2.0).abs() < 1e-15, "round the end");
    }
}
