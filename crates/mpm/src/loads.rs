//! Loads on the surface of bodies, carried by points (sheet: mpm §2.11).
//!
//! Each of the outermost points of a loaded side carries its share of the area as a vector. A traction keeps what it
//! is at the start ("dead load"), which may vary along the side; a pressure follows the surface: its area vector turns and grows with the motion of the
//! point by Nanson's formula, `dA ← det f f⁻ᵀ dA`.

use std::ops::Range;

use colluvium_case::description::{Load, Side, Space};
use colluvium_case::{Case, CaseError};
use colluvium_constitutive::BLOCK;
use colluvium_grid::{Gathered, Mesh, Points};

use crate::background::Background;
use crate::bodies::Bodies;
use crate::clock::Clock;
use crate::mesh;
use crate::nodes::Nodes;
use crate::points::PointSet;
use crate::surface_load::SurfaceLoad;

/// When the loads of a case begin (s): at once, or never as long as their stage has not.
pub fn starts(case: &Case) -> Vec<f64> {
    case.loads.iter().map(|load| if load.stage().is_none() { 0.0 } else { f64::INFINITY }).collect()
}

/// Share of load `number` that acts at `time` (s) with the given [`starts`].
pub fn factor(case: &Case, number: usize, starts: &[f64], time: f64) -> f64 {
    case.loads[number].factor(time - starts[number])
}

/// The set of points that load `number` is on.
pub fn loaded<const D: usize>(case: &Case, number: usize, sets: &[PointSet<D>]) -> Result<usize, CaseError> {
    let body = case.loads[number].body();
    sets.iter()
        .position(|set| case.bodies[set.body as usize].name == body)
        .ok_or_else(|| CaseError::new(format!("loads[{number}].body"), format!("{body:?} is not a body")))
}

/// Full load on an area of one (Pa), as a vector.
pub fn per_area<const D: usize>(load: &Load) -> [f64; D] {
    match load {
        Load::Traction { value, .. } => std::array::from_fn(|c| value[c]),
        Load::Pressure { value, .. } | Load::PorePressure { value, .. } => {
            let outwards = if load.side().is_max() { 1.0 } else { -1.0 };
            std::array::from_fn(|c| if c == load.side().axis() { -outwards * value } else { 0.0 })
        }
    }
}

/// Area (m²; m in the plane, per radian in axisymmetry) of the domain of each point of a regular set on the loaded side, with
/// the share of the load at its place; zero within the body.
pub fn areas<const D: usize>(case: &Case, load: &Load, set: &PointSet<D>) -> Vec<f64> {
    let side = load.side();
    let (axis, sign) = (side.axis(), if side.is_max() { 1.0 } else { -1.0 });
    let outermost = set.points.position.iter().map(|x| sign * x[axis]).fold(f64::NEG_INFINITY, f64::max);
    let across: f64 = (0..D).filter(|c| *c != axis).map(|c| set.extent[c]).product();
    let area = |position: &[f64; D]| {
        if sign * position[axis] <= outermost - 0.5 * set.extent[axis] {
            return 0.0;
        }
        let radius = match (case.space, side) {
            (Space::Axisymmetric, Side::XMin | Side::XMax) => position[0] + sign * 0.5 * set.extent[0],
            (Space::Axisymmetric, _) => position[0],
            _ => 1.0,
        };
        across * radius * load.share_at(position)
    };
    set.points.position.iter().map(area).collect()
}

/// Gives the outermost layer of points of the loaded side its share of load `number` (sheet: mpm §2.11).
pub fn apply<const D: usize>(
    case: &Case,
    number: usize,
    mesh: &Mesh<D>,
    sets: &mut [PointSet<D>],
) -> Result<(), CaseError> {
    let load = &case.loads[number];
    let set = &mut sets[loaded(case, number, sets)?];
    let areas =
        if mesh.is_empty() { areas(case, load, set) } else { mesh::loaded_areas(case, number, mesh, set)? };
    let per_area = per_area::<D>(load);
    let force = areas.into_iter().map(|area| per_area.map(|t| t * area)).collect();
    set.loads.push(SurfaceLoad {
        number,
        liquid: load.is_of_fluid(),
        follows: !matches!(load, Load::Traction { .. }),
        force,
        applied: f64::NAN,
    });
    set.points.traction.resize(set.points.position.len(), [0.0; D]);
    if let Some(pore) = &mut set.pore {
        pore.points.traction.resize(set.points.position.len(), [0.0; D]);
    }
    Ok(())
}

impl<const D: usize> PointSet<D> {
    /// Forces of all loads of the set at `time` (s) on its points; `starts` are when the loads of the case begin (s).
    fn apply_loads(&mut self, case: &Case, starts: &[f64], time: f64) {
        let factor = |load: &SurfaceLoad<D>| factor(case, load.number, starts, time);
        if self.loads.iter().all(|load| !load.follows && load.applied == factor(load)) {
            return;
        }
        self.points.traction.fill([0.0; D]);
        if let Some(pore) = &mut self.pore {
            pore.points.traction.fill([0.0; D]);
        }
        for load in &mut self.loads {
            load.applied = factor(load);
            let forces = match &mut self.pore {
                Some(pore) if load.liquid => &mut pore.points.traction,
                _ => &mut self.points.traction,
            };
            for (sum, force) in forces.iter_mut().zip(&load.force) {
                for c in 0..D {
                    sum[c] += load.applied * force[c];
                }
            }
        }
    }
}

/// Sets the forces of the loads to those at the end of a step of `dt`.
pub fn apply_loads<const D: usize>(clock: &Clock, bodies: &mut Bodies<D>, starts: &[f64]) {
    for set in bodies.sets.iter_mut().filter(|set| !set.loads.is_empty()) {
        set.apply_loads(&clock.case, starts, clock.time + clock.dt);
    }
}

/// Begins the loads that begin with a stage, at `start` (s).
pub fn begin_loads(clock: &Clock, starts: &mut [f64], stage: usize, start: f64) {
    for (load, begins) in clock.case.loads.iter().zip(starts) {
        if load.stage().is_some_and(|name| name == clock.case.stages[stage].name) {
            *begins = start;
        }
    }
}

/// Turns and stretches what follows the surface with the motion that `read` finds on the nodes of a velocity
/// field, before the points move.
pub fn follow_surfaces<const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    bodies: &mut Bodies<D>,
    read: &Read<'_, D>,
) {
    if !bodies.sets.iter().any(|set| set.loads.iter().any(|load| load.follows)) {
        return;
    }
    let dt = clock.dt;
    let mut all = [Gathered::ZERO; BLOCK];
    for set in &mut bodies.sets {
        let points =
            Points { position: &set.points.position, domain: set.domain.as_slice(), extent: &set.extent };
        for load in set.loads.iter_mut().filter(|load| load.follows) {
            for run in runs(&load.force) {
                let (points, reads) = (points.range(run.clone()), &mut all[..run.len()]);
                read(set.field, &points, reads);
                let forces = load.force[run].iter_mut();
                for ((force, motion), position) in forces.zip(&*reads).zip(points.position) {
                    let step: [[f64; D]; D] = std::array::from_fn(|i| {
                        std::array::from_fn(|j| dt * motion.gradient[j].as_array()[i])
                    });
                    // In axisymmetry the circle that the point stands for widens.
                    let hoop = if background.axisymmetric {
                        dt * motion.velocity.as_array()[0] / position[0]
                    } else {
                        0.0
                    };
                    *force = nanson(&step, force).map(|c| c * (1.0 + hoop));
                }
            }
        }
    }
}

/// Lets the loads follow the motion of the nodes of one phase.
pub fn follow_loads<const FROM_SOLVED: bool, const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    bodies: &mut Bodies<D>,
    nodes: &Nodes,
) {
    let Background { layout, sweeps, .. } = background;
    follow_surfaces(clock, background, bodies, &|field, points, reads| {
        let (ground, first) = (background.ground(), field * layout.len());
        if FROM_SOLVED {
            sweeps.gather(&ground, points, &nodes.solved[first..], reads);
        } else {
            sweeps.gather_velocity(&ground, points, &nodes.remapped[first..], reads);
        }
    });
}

/// Finds what points of a velocity field read off the nodes.
type Read<'a, const D: usize> = dyn Fn(usize, &Points<'_, D>, &mut [Gathered<D>]) + 'a;

/// Runs of points with a force, of [`BLOCK`] or fewer.
fn runs<const D: usize>(forces: &[[f64; D]]) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for p in (0..forces.len()).filter(|p| forces[*p] != [0.0; D]) {
        match runs.last_mut() {
            Some(run) if run.end == p && run.len() < BLOCK => run.end += 1,
            _ => runs.push(p..p + 1),
        }
    }
    runs
}

/// `det f f⁻ᵀ a` for `f = 1 + step`: the cofactor of `f` times `a`.
fn nanson<const D: usize>(step: &[[f64; D]; D], a: &[f64; D]) -> [f64; D] {
    let f = |i: usize, j: usize| step[i][j] + if i == j { 1.0 } else { 0.0 };
    std::array::from_fn(|i| {
        (0..D)
            .map(|j| {
                let cofactor = match D {
                    1 => 1.0,
                    2 => {
                        if i == j {
                            f(1 - i, 1 - j)
                        } else {
                            -f(j, i)
                        }
                    }
                    _ => {
                        let ([a, b], [c, d]) = ([(i + 1) % 3, (i + 2) % 3], [(j + 1) % 3, (j + 2) % 3]);
                        f(a, c) * f(b, d) - f(a, d) * f(b, c)
                    }
                };
                cofactor * a[j]
            })
            .sum()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn area_vectors_turn_with_the_surface_and_grow_with_it() {
        // f = 2 along x, 3 along y, 5 along z: the area normal to x grows by 15.
        let step = [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 4.0]];
        assert_eq!(nanson(&step, &[1.0, 1.0, 1.0]), [15.0, 10.0, 6.0]);
        let turned = nanson(&[[-1.0, -1.0], [1.0, -1.0]], &[1.0, 0.0]);
        assert_eq!(turned, [0.0, 1.0], "a quarter turn");
        assert_eq!(nanson(&[[0.5]], &[2.0]), [2.0]);
        // Shear along x leaves the surface normal to y as it is and tilts the one normal to x.
        assert_eq!(nanson(&[[0.0, 0.5], [0.0, 0.0]], &[0.0, 1.0]), [0.0, 1.0]);
        assert_eq!(nanson(&[[0.0, 0.5], [0.0, 0.0]], &[1.0, 0.0]), [1.0, -0.5]);
    }
}
