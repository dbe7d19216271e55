//! Checks for stresses that a packing of grains cannot carry (sheet: dem §7).

use colluvium_case::{Case, CaseError};

use crate::config::{CellEntry, DemOptions, GrainStage, NormalLaw};
use colluvium_case::CaseErrorKind;

/// Mean overlap over the radius above which contact stiffness is not physical.
const MAX_MEAN_OVERLAP: f64 = 0.3;

/// Rejects tensile stresses on grains without attraction, and pressures that cause overlaps of more than
/// [`MAX_MEAN_OVERLAP`].
pub(super) fn check_stresses(case: &Case, options: &DemOptions) -> Result<(), CaseError> {
    let attracts = options.pairs.iter().any(|pair| pair.adhesion.is_some() || pair.bond.is_some());
    for (name, stage) in &options.stages {
        let path = format!("methods.dem.stages.{name}");
        let limit = largest_pressure(case.dimension(), options, stage);
        for (key, smallest, largest) in requested_stresses(stage) {
            let path = format!("{path}.{key}");
            if !attracts && largest >= 0.0 {
                let problem = format!(
                    "{largest} must be negative (Pa): grains without adhesion or bonds cannot carry tension"
                );
                return Err(CaseError::new(path, problem));
            }
            if let Some(limit) = limit.filter(|limit| -smallest > *limit) {
                let problem = format!(
                    "{:.4e} Pa causes overlaps of more than {MAX_MEAN_OVERLAP} of the radius (at most \
                     {limit:.4e} Pa for this stiffness): make contacts stiffer",
                    -smallest
                );
                return Err(CaseError::new(path, CaseErrorKind::coded("overlap", problem)));
            }
        }
    }
    Ok(())
}

/// Normal stresses prescribed in a stage, each with its key, the lowest and the highest value (Pa, tension-positive).
fn requested_stresses(stage: &GrainStage) -> Vec<(String, f64, f64)> {
    let entries = stage.cell.iter().flat_map(|cell| [("xx", cell.xx), ("yy", cell.yy), ("zz", cell.zz)]);
    let of_cell = entries.filter_map(|(key, entry)| {
        let (key, (smallest, largest)) = match entry? {
            CellEntry::Stress(value) => (format!("cell.{key}.stress"), (value, value)),
            CellEntry::CyclicStress(own) => {
                let size = own.amplitude.abs();
                (format!("cell.{key}.cyclic-stress"), (own.mean - size, own.mean + size))
            }
            CellEntry::Rate(_) | CellEntry::CyclicStrain(_) => return None,
        };
        Some((key, smallest, largest))
    });
    let of_walls =
        stage.walls.iter().map(|(name, press)| (format!("walls.{name}.stress"), press.stress, press.stress));
    of_cell.chain(of_walls).collect()
}

/// Pressure that causes the overlap [`MAX_MEAN_OVERLAP`] in the stiffest pair of the smallest grains (Pa; N/m in the plane). A contact
/// force is about the pressure times the diameter, in space its square. `None` if the stiffness is not given as a number.
fn largest_pressure(dimension: usize, options: &DemOptions, stage: &GrainStage) -> Option<f64> {
    let laws = options.pairs.iter().map(|pair| &pair.normal);
    let stiffness =
        laws.chain(stage.pairs.iter().filter_map(|pair| pair.normal.as_ref())).map(|law| match law {
            NormalLaw::Linear { stiffness, .. } => *stiffness,
            NormalLaw::Hertz { .. } => None,
        });
    let stiffest = stiffness.collect::<Option<Vec<f64>>>()?.into_iter().fold(0.0, f64::max);
    if dimension == 2 {
        return Some(0.5 * MAX_MEAN_OVERLAP * stiffest);
    }
    let smallest = options.grains.values().map(|kind| kind.diameter.as_ref().map(|sizes| sizes.range().0));
    let smallest = smallest.collect::<Option<Vec<f64>>>()?.into_iter().fold(f64::INFINITY, f64::min);
    Some(0.5 * MAX_MEAN_OVERLAP * stiffest / smallest)
}
