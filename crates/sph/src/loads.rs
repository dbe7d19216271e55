//! Loads on the surface of bodies, carried by the particles next to it (sheet: mpm §2.11; `colluvium_case::loads`).
//!
//! The force of a load is that of the case on the area next to a particle, whatever the sums over its neighbours make of the
//! surface there: resultants are exact, and the load is smeared over the kernel of the outermost particles.

use colluvium_case::loads::nanson;
use colluvium_case::{Case, CaseError};

use crate::algebra::apart;
use crate::clock::Clock;
use crate::kernel::Smoothing;
use crate::lists::Lists;
use crate::particles::{Bodies, Group, Matrix, Particles};
use crate::rates::Rates;
use crate::setting::Setting;
use crate::total::cofactor;

/// One load, on the body it is on.
struct OnBody<const D: usize> {
    /// Index into `Case::loads`.
    number: usize,
    /// Index into `Case::bodies`.
    body: u32,
    /// Id of the first particle of the body, whose ids follow each other.
    first: u32,
    /// What the particle of each id carries of it.
    carried: Vec<[f64; D]>,
}

/// The loads of a case.
#[derive(Default)]
pub struct Loads<const D: usize> {
    all: Vec<OnBody<D>>,
    /// When each begins (s).
    starts: Vec<f64>,
}

impl<const D: usize> Loads<D> {
    /// The loads of `case` on bodies whose particles stand `spacing` (m) apart, as they are at the start.
    ///
    /// # Errors
    /// When a load lies on a body that is held, or on nothing.
    pub fn new(
        case: &Case,
        groups: &[Group],
        particles: &Particles<D>,
        spacing: f64,
    ) -> Result<Self, CaseError> {
        let mut all = Vec::new();
        for (number, load) in case.loads.iter().enumerate() {
            let on = |group: &&Group| case.bodies[group.body as usize].name == load.body();
            let Some(group) = groups.iter().find(on) else { continue };
            if group.held.is_some() {
                let problem = format!("the body {:?} is held, whatever acts on it", load.body());
                return Err(CaseError::new(format!("loads[{number}].body"), problem));
            }
            let carried = case.carried(number, &particles.position[group.range()], &[spacing; D]);
            if load.side().is_none() && carried.iter().all(|vector| *vector == [0.0; D]) {
                let problem = "no part of the surface of the body lies in it";
                return Err(CaseError::new(format!("loads[{number}].within"), problem));
            }
            all.push(OnBody { number, body: group.body, first: particles.id[group.start], carried });
        }
        Ok(Self { all, starts: case.load_starts() })
    }

    /// Begins the loads that begin with a stage, at `start` (s).
    pub fn begin(&mut self, case: &Case, stage: usize, start: f64) {
        case.begin_loads(&mut self.starts, stage, start);
    }

    /// What a checkpoint keeps: when loads begin, and what particles carry of those that follow their surfaces.
    pub fn saved(&self) -> (Vec<f64>, Vec<Vec<f64>>) {
        (self.starts.clone(), self.all.iter().map(|on| on.carried.as_flattened().to_vec()).collect())
    }

    /// Takes what a checkpoint kept; `None` where it does not fit.
    pub fn take_saved(&mut self, (starts, carried): &(Vec<f64>, Vec<Vec<f64>>)) -> Option<()> {
        let fits = |(on, saved): (&OnBody<D>, &Vec<f64>)| on.carried.len() * D == saved.len();
        if starts.len() != self.starts.len()
            || carried.len() != self.all.len()
            || !self.all.iter().zip(carried).all(fits)
        {
            return None;
        }
        self.starts.clone_from(starts);
        for (on, saved) in self.all.iter_mut().zip(carried) {
            on.carried.as_flattened_mut().copy_from_slice(saved);
        }
        Some(())
    }

    /// Turns and stretches what follows its surface with the motion of the particles over a step of `dt` (s); `gradient` are
    /// their velocity gradients (1/s), none where these cannot be told.
    fn follow(
        &mut self,
        case: &Case,
        groups: &[Group],
        ids: &[u32],
        dt: f64,
        gradient: impl Fn(&Group, usize) -> Option<Matrix<D>>,
    ) {
        for on in self.all.iter_mut().filter(|on| case.loads[on.number].follows()) {
            let Some(group) = groups.iter().find(|group| group.body == on.body) else { continue };
            for i in group.range() {
                let vector = &mut on.carried[(ids[i] - on.first) as usize];
                if *vector != [0.0; D]
                    && let Some(gradient) = gradient(group, i)
                {
                    *vector = nanson(&gradient.map(|row| row.map(|l| dt * l)), vector);
                }
            }
        }
    }
}

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
    let Bodies { particles, groups, loads, .. } = bodies;
    loads.follow(&setting.case, groups, &particles.id, dt, |group, i| {
        if total {
            Some(rates.of.gradient[i])
        } else {
            linear(&setting.smoothing, particles, group, i, lists.neighbours.of(i))
        }
    });
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
        let weight = -smoothing.weight(square.sqrt()) * p.mass[j] / p.density[j];
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
