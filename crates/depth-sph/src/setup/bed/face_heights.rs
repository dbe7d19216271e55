//! Highest faces of obstacles, at the nodes of a raster.

use colluvium_case::{Case, CaseError, PlacedObstacle};
use colluvium_points::Raster;

/// Least advance of the search towards a face, over the node distance; beside a vertical face the distance remains small.
const ADVANCE: f64 = 1e-2;
/// Number of bisections after an advance into a solid.
const HALVINGS: usize = 60;
/// Number of raster rows of a bed that is constant along the second axis.
const ROWS: usize = 4;

/// Levels of the highest obstacle faces at nodes `spacing` apart (m), or at those of `raster`. The obstacle that the raster represents is
/// included by the levels of `raster`.
pub fn highest_faces<const D: usize>(
    case: &Case,
    spacing: f64,
    raster: Option<(usize, Raster)>,
) -> Result<Raster, CaseError> {
    let (own, mut raster) = match raster {
        Some((number, raster)) => (Some(number), raster),
        None => (None, nodes::<D>(case, spacing)),
    };
    let spacing = raster.spacing[0].min(raster.spacing[1]);
    let columns = raster.columns;
    let line = |raster: &Raster, number: usize| raster.node_position(number % columns, number / columns);
    // In a profile all rows are equal.
    let count = if D == 1 { columns } else { raster.values.len() };
    let found: Vec<f64> = if D == 1 {
        let standing = case.placed_obstacles::<2>()?;
        (0..count)
            .map(|k| face(case, &standing, own, &line(&raster, k)[..1], spacing))
            .collect::<Result<_, _>>()?
    } else {
        let standing = case.placed_obstacles::<3>()?;
        (0..count)
            .map(|k| face(case, &standing, own, &line(&raster, k), spacing))
            .collect::<Result<_, _>>()?
    };
    for (number, value) in raster.values.iter_mut().enumerate() {
        // The larger one; of none and a number the number.
        *value = value.max(found[number % count]);
    }
    Ok(raster)
}

/// Nodes over the domain, without a height.
fn nodes<const D: usize>(case: &Case, spacing: f64) -> Raster {
    let count = |c: usize| ((case.domain.max[c] - case.domain.min[c]) / spacing - 1e-9).ceil() as usize + 1;
    let rows = if D == 1 { ROWS } else { count(1).max(ROWS) };
    let low = |c: usize| if c < D { case.domain.min[c] } else { 0.0 };
    Raster::from_function([count(0).max(ROWS), rows], [low(0), low(1)], [spacing; 2], |_, _| f64::NAN)
}

/// Level of the highest face at a position in plan (m), without the obstacle `without`; not-a-number if there is no face.
fn face<const N: usize>(
    case: &Case,
    standing: &[PlacedObstacle<'_, N>],
    without: Option<usize>,
    x: &[f64],
    spacing: f64,
) -> Result<f64, CaseError> {
    let (bottom, top) = (case.domain.min[N - 1], case.domain.max[N - 1]);
    let at = |z: f64| std::array::from_fn(|c| if c + 1 < N { x[c] } else { z });
    let mut highest = f64::NAN;
    for PlacedObstacle { number, surface, .. } in standing.iter().filter(|of| Some(of.number) != without) {
        if surface.contains(&at(top)) {
            let place: Vec<f64> = x.iter().zip(case.origin()).map(|(x, origin)| x + origin).collect();
            let problem = format!(
                "is higher than the domain at {place:?} m: the bed must end below the top of the domain"
            );
            return Err(CaseError::new(format!("obstacles[{number}].shape"), problem));
        }
        let (mut above, mut z) = (top, top);
        while z >= bottom && !surface.contains(&at(z)) {
            let Some(gap) = surface.gap(&at(z), f64::INFINITY) else { break };
            above = z;
            z -= gap.distance.max(ADVANCE * spacing);
        }
        if !surface.contains(&at(z)) {
            continue;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (above + z);
            if surface.contains(&at(middle)) { z = middle } else { above = middle }
        }
        highest = highest.max(z);
    }
    Ok(highest)
}
