//! Errors of runs of manufactured solutions.

use colluvium::case::{Snapshot, Solver};

/// Largest value of each of `errors` over the steps of a run until `end` (s). Where the body leaves the domain or inverts after a numerical
/// fracture, the errors are infinite.
///
/// # Errors
/// Where the first stage cannot begin.
pub fn max_errors_over_steps<const N: usize>(
    solver: &mut dyn Solver,
    end: f64,
    errors: impl Fn(&Snapshot) -> [f64; N],
) -> Result<[f64; N], String> {
    solver.begin_stage(0, 0.0).map_err(|error| error.to_string())?;
    let mut largest = [0f64; N];
    while solver.time() < end * (1.0 - 1e-9) {
        let dt = solver.limit().dt.min(end - solver.time());
        if solver.step(dt).is_err() {
            return Ok([f64::INFINITY; N]);
        }
        let now = errors(&solver.snapshot());
        (0..N).for_each(|i| largest[i] = largest[i].max(now[i]));
    }
    Ok(largest)
}

/// Root mean square distance (m) of points from their exact positions at the time of a snapshot.
pub fn rms_position_error(snapshot: &Snapshot, exact: impl Fn([f64; 3], f64) -> [f64; 3]) -> f64 {
    let displacement = snapshot.vectors("displacement").unwrap_or(&[]);
    let squares = snapshot.positions.iter().zip(displacement).map(|(x, u)| {
        let place = exact(std::array::from_fn(|c| x[c] - u[c]), snapshot.time);
        (0..3).map(|c| (x[c] - place[c]).powi(2)).sum::<f64>()
    });
    (squares.sum::<f64>() / displacement.len() as f64).sqrt()
}
