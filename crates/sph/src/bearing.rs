//! The forces of loads on particles, and how loads follow the surface ([`loads`](crate::loads)).

use colluvium_case::loads::{cofactor, nanson};

use crate::algebra::{apart, dot};
use crate::clock::Clock;
use crate::kernel::Smoothing;
use crate::lists::Lists;
use crate::loads::Loads;
use crate::pairs::Sums;
use crate::particles::{Bodies, Group, Matrix, Particles};
use crate::rates::{Felt, Rates, Told};
use crate::setting::Setting;
use crate::walls::{Borne, Walls};

/// Adds the loads at the end of a step of `dt` (s) to the accelerations.
pub fn bear<const D: usize>(
    setting: &Setting<D>,
    clock: &Clock,
    bodies: &Bodies<D>,
    rates: &mut Rates<D>,
    dt: f64,
) {
    let Loads { all, starts } = &bodies.loads;
    if all.is_empty() {
        return;
    }
    let p = &bodies.particles;
    if setting.options.confining.is_none() {
        rates.pushes.clear();
        rates.pushes.resize(p.len(), [0.0; D]);
    }
    for on in all {
        let load = &setting.case.loads[on.number];
        let factor = load.factor(clock.time + dt - starts[on.number]);
        let group = bodies.groups.iter().find(|group| group.body == on.body);
        let Some(group) = group.filter(|_| factor != 0.0) else { continue };
        for i in group.range() {
            let carried = &on.carried[(p.id[i] - on.first) as usize];
            if *carried == [0.0; D] {
                continue;
            }
            let force = load.force(carried);
            for c in 0..D {
                let push = factor * force[c] / p.mass[i];
                rates.pushes[i][c] += push;
                rates.of.acceleration[i][c] += push;
            }
        }
    }
}

/// What obstacles whose reaction is measured bear of the particles at the sums of a step, the opposite of what they do to these, and
/// the power of those that move. Row after row, so that it does not depend on threads.
pub fn tell_obstacles<const D: usize>(
    sums: &Sums<'_, D>,
    setting: &Setting<D>,
    walls: &Walls<D>,
    rates: &mut Rates<D>,
) {
    let obstacles = &walls.obstacles;
    if obstacles.watched().next().is_none() {
        return;
    }
    let first = setting.case.bodies.len();
    let Rates { by_obstacles, felt, power, told, .. } = rates;
    told.clear();
    if obstacles.told().next().is_some() {
        felt.resize(first + setting.case.obstacles.len(), Felt::default());
        felt[first..].iter_mut().for_each(Felt::begin);
    }
    power.clear();
    power.resize(by_obstacles.len(), 0.0);
    let p = sums.particles;
    for (i, whole) in by_obstacles.iter().enumerate() {
        let Some(nearest) = obstacles.faces(i).first() else { continue };
        let alone = obstacles.faces(i).iter().all(|face| face.obstacle == nearest.obstacle);
        for (number, is_told) in obstacles.watched() {
            let own = match (alone, nearest.obstacle as usize == number) {
                (true, true) => *whole,
                (true, false) => continue,
                (false, _) => sums.push_off_obstacle(i, number as u32),
            };
            power[i] += dot(&own, &obstacles.course(number, &p.position[i]));
            if is_told {
                let (bearer, force) = ((first + number) as u32, own.map(|a| -p.mass[i] * a));
                told.push(Told { particle: i as u32, bearer, place: p.position[i], force, impulse: None });
            }
        }
    }
    told.iter().for_each(|one| felt[one.bearer as usize].hear(one));
}

/// Stops particles before obstacles at the end of a step of `dt` (s), and finds what obstacles have taken in it: friction by the
/// acceleration along the nearest face at the last sums of the step and the slip at its end. Whether any was stopped.
pub fn bear_obstacles<const D: usize>(
    setting: &Setting<D>,
    bodies: &mut Bodies<D>,
    walls: &mut Walls<D>,
    rates: &mut Rates<D>,
    (end, dt): (f64, f64),
) -> bool {
    if walls.obstacles.is_empty() {
        return false;
    }
    let Rates { by_obstacles, borne, felt, power, told, stood, .. } = rates;
    let p = &bodies.particles;
    borne.clear();
    borne.resize(p.len(), Borne::default());
    for (i, (borne, a)) in borne.iter_mut().zip(by_obstacles).enumerate() {
        let faces = walls.obstacles.faces(i);
        let Some(face) = faces.iter().min_by(|one, other| one.distance.total_cmp(&other.distance)) else {
            continue;
        };
        let v: [f64; D] = std::array::from_fn(|c| p.velocity[i][c] - face.course[c]);
        let slip = dot(a, &v) - dot(a, &face.normal) * dot(&v, &face.normal);
        borne.friction = -dt * p.mass[i] * slip;
        borne.work = dt * p.mass[i] * power.get(i).copied().unwrap_or(0.0);
    }
    for (particle, own) in &*stood {
        borne[*particle].friction += own.friction;
        borne[*particle].work += own.work;
    }
    let first = setting.case.bodies.len();
    let mut hits = |particle: usize, obstacle: u32, x: &[f64; D], impulse: [f64; D]| {
        let bearer = first + obstacle as usize;
        if let Some(felt) = felt.get_mut(bearer) {
            let (force, impulse) = (impulse.map(|p| p / dt), Some(impulse));
            let hit = Told { particle: particle as u32, bearer: bearer as u32, place: *x, force, impulse };
            felt.hear(&hit);
            told.push(hit);
        }
    };
    for (particle, own) in &*stood {
        let (x, impulse) = (own.place, own.impulse);
        if walls.obstacles.is_told(own.obstacle as u32) {
            hits(
                *particle,
                own.obstacle as u32,
                &std::array::from_fn(|c| x[c]),
                std::array::from_fn(|c| impulse[c]),
            );
        }
    }
    walls.obstacles.stop(bodies, borne, (end, dt, setting.options.spacing), hits)
}

/// Lets the loads follow the surfaces over a step of `dt` (s) that has just been made. Over a reference configuration (`total`)
/// the gradients of the rates are exact for turns; those of the present one lack the neighbours beyond the surface, and are found anew.
pub fn follow<const D: usize>(
    setting: &Setting<D>,
    bodies: &mut Bodies<D>,
    lists: &Lists<D>,
    rates: &Rates<D>,
    total: bool,
    dt: f64,
) {
    let Bodies { particles: p, groups, loads, guests, .. } = bodies;
    for on in loads.all.iter_mut().filter(|on| on.follows(&setting.case)) {
        let Some(group) = groups.iter().find(|group| group.body == on.body) else { continue };
        // Those of other ranks lack neighbours here, and bring what they carry.
        for i in group.range().filter(|i| !guests.get(*i).is_some_and(|guest| *guest)) {
            let vector = &mut on.carried[(p.id[i] - on.first) as usize];
            if *vector == [0.0; D] {
                continue;
            }
            let gradient = if total {
                Some(rates.of.gradient[i])
            } else {
                linear(&setting.smoothing, p, group, i, lists.neighbours.of(i))
            };
            if let Some(gradient) = gradient {
                *vector = nanson(&gradient.map(|row| row.map(|l| dt * l)), vector);
            }
        }
    }
}

/// Velocity gradient at particle `i` (1/s), exact where velocities are linear, from its neighbours in the same body; `None` where they
/// do not span the space.
fn linear<const D: usize>(
    smoothing: &Smoothing<D>,
    p: &Particles<D>,
    group: &Group,
    i: usize,
    row: &[u32],
) -> Option<Matrix<D>> {
    let (mut moments, mut sums) = ([[0.0; D]; D], [[0.0; D]; D]);
    for j in row.iter().map(|&j| j as usize).filter(|j| group.range().contains(j)) {
        let (away, square) = apart(&p.position[i], &p.position[j]);
        // Any weights do; those of the present densities would not be there in other ranks.
        let weight = -smoothing.weight(square.sqrt()) * p.mass[j] / group.density;
        for a in 0..D {
            for b in 0..D {
                moments[a][b] += weight * away[a] * away[b];
                sums[a][b] += weight * (p.velocity[j][a] - p.velocity[i][a]) * away[b];
            }
        }
    }
    let cofactors = cofactor(&moments);
    let determinant: f64 = (0..D).map(|c| moments[0][c] * cofactors[0][c]).sum();
    // A full support has moments of one, in whatever direction.
    if !(determinant > 1e-4) {
        return None;
    }
    Some(std::array::from_fn(|a| {
        std::array::from_fn(|b| (0..D).map(|c| sums[a][c] * cofactors[c][b]).sum::<f64>() / determinant)
    }))
}
