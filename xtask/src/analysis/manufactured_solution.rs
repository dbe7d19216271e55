//! How far runs of manufactured solutions are from them.

use colluvium::case::{Snapshot, Solver};

/// The largest of each of `errors` over the steps of a run until `end` (s). A body that the grid has torn may leave the domain, or
/// turn inside out: that is as wrong as can be.
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

/// Root mean square distance (m) of points from where a solution has them at the time of a snapshot.
pub fn rms_position_error(snapshot: &Snapshot, exact: impl Fn([f64; 3], f64) -> [f64; 3]) -> f64 {
    let displacement = snapshot.vectors("displacement").unwrap_or(&[]);
    let squares = snapshot.positions.iter().zip(displacement).map(|(x, u)| {
        let place = exact(std::array::from_fn(|c| x[c] - u[c]), snapshot.time);
        (0..3).map(|c| (x[c] - place[c]).powi(2)).sum::<f64>()
    });
    (squares.sum::<f64>() / displacement.len() as f64).sqrt()
}
