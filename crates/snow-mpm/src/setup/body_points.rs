//! Points from the bodies of a case (sheet: snow-mpm §3.3).

use colluvium_case::bodies::law_points::InitialLawState;
use colluvium_case::{Case, CaseError, PointList, spatial};
use colluvium_grid::SquareMatrix;
use colluvium_points::Sample;

use crate::background_grid::BackgroundGrid;
use crate::config::{SnowOptions, SnowTransfer};
use crate::points::bodies::{BodyPoints, PointColumns, point_slice};
use crate::setup::option_error;
use colluvium_case::CaseErrorKind;

/// Largest number of points, by the range of the ids.
const MAX_POINTS: usize = u32::MAX as usize;

/// Returns the points of body number `number`, with ids from `first_id` on; `listed` are those of a list.
pub(super) fn body_points<const D: usize>(
    case: &Case,
    options: &SnowOptions,
    background: &BackgroundGrid<D>,
    (number, listed): (usize, Option<&PointList>),
    first_id: usize,
) -> Result<BodyPoints<D>, CaseError> {
    let of_case = &case.bodies[number];
    let samples = sample_body(case, options, background, number, listed)?;
    let count = samples.len();
    if first_id + count > MAX_POINTS {
        return Err(option_error(
            "cell_size",
            CaseErrorKind::coded("too-many-points", format!("gives more than {MAX_POINTS} points")),
        ));
    }
    let position: Vec<[f64; D]> = samples.iter().map(|sample| sample.position).collect();
    let volume: Vec<f64> = samples.iter().map(|sample| sample.volume).collect();
    let mass = volume.iter().enumerate().map(|(i, v)| Ok(v * case.density_at(number, listed, i)?));
    let mass = mass.collect::<Result<Vec<f64>, CaseError>>()?;
    let InitialLawState { material, stress, states } = case.initialise_law(number, listed, &position)?;
    let velocity_of = |(point, x): (usize, &[f64; D])| {
        let given = listed.and_then(|list| Some(list.velocities.as_ref()?[point]));
        let velocity = given.unwrap_or_else(|| of_case.velocity.velocity_at(spatial(x)));
        std::array::from_fn(|c| velocity[c])
    };
    let velocity = position.iter().enumerate().map(velocity_of).collect();
    let affine_velocity = match options.transfer {
        SnowTransfer::Apic => affine_moments(case, background, number, &position),
        SnowTransfer::Flip => vec![[[0.0; D]; D]; count],
    };
    let points = PointColumns {
        id: (first_id as u32..(first_id + count) as u32).collect(),
        origin: position.clone(),
        velocity,
        affine_velocity,
        mass,
        stress,
        work: Vec::new(),
        position,
        volume,
        body_force: Vec::new(),
    };
    let mean = points.volume.iter().sum::<f64>() / count as f64;
    let mut body = BodyPoints {
        number: number as u32,
        material,
        states,
        width: mean.powf(1.0 / D as f64),
        remove_outside: of_case.remove_outside,
        points,
        slabs: Vec::new(),
        reports: Vec::new(),
    };
    body.points.work = body.stored_energies();
    Ok(body)
}

/// Moments of the initial velocity field: its gradient times the second moment of the shape functions. The gradient is a finite
/// difference over a cell.
fn affine_moments<const D: usize>(
    case: &Case,
    background: &BackgroundGrid<D>,
    number: usize,
    position: &[[f64; D]],
) -> Vec<SquareMatrix<D>> {
    let (field, half) = (&case.bodies[number].velocity, 0.5 * background.grid.cell);
    let mut squares = [[0.0; D]];
    let moment = |x: &[f64; D]| {
        background.transfers.second_moments(
            &background.grid_view(),
            &point_slice(&[*x], &[half; D]),
            &mut squares,
        );
        let [squares] = squares;
        let column = |j: usize| {
            let at = |sign: f64| {
                let mut place = spatial(x);
                place[j] += sign * half;
                field.velocity_at(place)
            };
            let (above, below) = (at(1.0), at(-1.0));
            std::array::from_fn::<f64, D, _>(|i| squares[j] * (above[i] - below[i]) / (2.0 * half))
        };
        let columns: [[f64; D]; D] = std::array::from_fn(column);
        std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i]))
    };
    position.iter().map(moment).collect()
}

/// Points of a body from its shape or a list, checked against the cell size.
fn sample_body<const D: usize>(
    case: &Case,
    options: &SnowOptions,
    background: &BackgroundGrid<D>,
    number: usize,
    listed: Option<&PointList>,
) -> Result<Vec<Sample<D>>, CaseError> {
    let cell = options.cell_size;
    let wrong = |key: &str, problem: String| CaseError::new(format!("bodies[{number}].{key}"), problem);
    let samples = match listed {
        Some(list) => list.samples(),
        None => case.samples(number, background.low, cell / options.points_per_cell as f64)?,
    };
    if let Some(list) = listed
        && list.spacing(D) > (1.0 + 1e-9) * cell
    {
        let problem = format!(
            "the mean width of the points is {:.4e} m, more than the cell size of {cell} m",
            list.spacing(D)
        );
        return Err(wrong("points", problem));
    }
    if samples.is_empty() {
        return Err(wrong("shape", format!("holds no point: it is smaller than the cells of {cell} m")));
    }
    if let Some(sample) = samples.iter().find(|sample| !background.contains(&sample.position)) {
        let place = case.map_position(&sample.position);
        return Err(wrong("shape", format!("the point at {place:?} m lies outside the domain")));
    }
    Ok(samples)
}
