//! Critical time step (sheet: snow-mpm §3.4), computed in every step.

use colluvium_case::{StepLimit, TimeStep, spatial};
use colluvium_constitutive::{BLOCK_SIZE, Material, StateBlock, SymTensor};

use crate::config::SnowOptions;
use crate::points::bodies::Bodies;
use crate::points::step_bound::StepBound;
use crate::points::vectors::square;

/// Step limit by the displacement of the fastest point.
const POINT_SPEED: StepLimit = StepLimit::new("speed of a point");

/// Coefficients of the step limits.
#[derive(Clone, Copy, Debug)]
pub struct StepCoefficients {
    /// Courant number of elastic waves: step times (wave speed + speed) over the cell size.
    elastic: f64,
    /// Courant number of the motion: step times speed over the cell size.
    velocity: f64,
    /// Edge length of a cell (m).
    cell: f64,
    /// Number of axes.
    dimension: f64,
}

impl StepCoefficients {
    /// Step coefficients of the options in `dimension` axes. A fixed step of the case only has to be below the critical one.
    pub fn of_options(options: &SnowOptions, dimension: usize) -> Self {
        let [elastic, velocity] = match options.time_step {
            Some(_) => [1.0, 1.0],
            None => [options.courant_elastic, options.courant_velocity],
        };
        Self { elastic, velocity, cell: options.cell_size, dimension: dimension as f64 }
    }

    /// Step bound of a group of points, the first of which has the number `first`.
    pub fn step_bound<const D: usize>(
        &self,
        first: usize,
        material: &dyn Material,
        (velocity, mass, volume): (&[[f64; D]], &[f64], &[f64]),
        (stress, states): (&[SymTensor], &StateBlock),
    ) -> StepBound {
        let (mut moduli, mut viscosities) = ([0.0; BLOCK_SIZE], [0.0; BLOCK_SIZE]);
        let count = velocity.len();
        material.wave_moduli(stress, states, &mut moduli[..count]);
        material.viscosities(stress, states, &mut viscosities[..count]);
        let (mut speeds, mut specific) = ([0.0; BLOCK_SIZE], [1.0; BLOCK_SIZE]);
        let points = velocity.iter().zip(mass.iter().zip(volume));
        for ((speed, specific), (velocity, (mass, volume))) in
            speeds.iter_mut().zip(&mut specific).zip(points)
        {
            (*speed, *specific) = (square(velocity), volume / mass);
        }
        let [by_wave, by_motion] = [self.elastic, self.velocity].map(|courant| 1.0 / (courant * self.cell));
        let by_viscosity = 4.0 * self.dimension / (self.cell * self.cell);
        // Inverse of the longest step, for each of the three limits.
        let mut rates = [[0.0; BLOCK_SIZE]; 3];
        for p in 0..BLOCK_SIZE {
            let (speed, specific) = (speeds[p].sqrt(), specific[p]);
            rates[0][p] = ((moduli[p] * specific).sqrt() + speed) * by_wave;
            rates[1][p] = speed * by_motion;
            rates[2][p] = viscosities[p] * specific * by_viscosity;
        }
        let mut pace = StepBound::UNBOUNDED;
        let highest = rates
            .as_flattened()
            .as_chunks::<8>()
            .0
            .iter()
            .fold([0f64; 8], |largest, rates| std::array::from_fn(|i| largest[i].max(rates[i])));
        let highest = highest.iter().fold(0f64, |largest, rate| largest.max(*rate));
        // First point of those with the highest rate.
        if let Some(p) = (0..count).find(|&p| rates.iter().any(|of| of[p] == highest)) {
            pace.restrict(rates[0][p], StepLimit::ELASTIC_WAVE, first + p);
            pace.restrict(rates[1][p], POINT_SPEED, first + p);
            pace.restrict(rates[2][p], StepLimit::VISCOSITY, first + p);
        }
        pace
    }
}

/// Time step from the reports of the bodies.
pub fn time_step<const D: usize>(bodies: &Bodies<D>) -> TimeStep {
    let (mut pace, mut place) = (StepBound::UNBOUNDED, None);
    for body in &bodies.bodies {
        for report in body.reports.iter().flatten().filter(|report| report.point_index < body.points.len()) {
            let before = pace.rate;
            pace.restrict(report.rate, report.limit, report.point_index);
            if pace.rate > before {
                place = Some((body.points.id[report.point_index], body.points.position[report.point_index]));
            }
        }
    }
    TimeStep {
        dt: 1.0 / pace.rate,
        limit: pace.limit,
        point: place.map(|(id, _)| u64::from(id)),
        position: place.map_or([0.0; 3], |(_, position)| spatial(&position)),
    }
}
