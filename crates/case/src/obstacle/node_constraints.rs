//! Constraints of grid nodes by obstacles.

use colluvium_points::Surface;
use colluvium_points::surface::{NearestPoint, RigidTransform};

use crate::description::Obstacle;
use crate::obstacle::{MovingObstacle, OVERLAP_TOLERANCE, ObstacleLaw, PlacedObstacle};
use crate::spatial;

/// Largest depth of constrained grid nodes below the surface of an obstacle, over the cell size. Points do not get deeper.
const MAX_NODE_DEPTH: f64 = 6.0;

/// Obstacles at rest that contain a grid node. Each has its boundary law and its outward normal there.
pub fn constraining_obstacles<'s, 'a, const D: usize>(
    standing: &'s [PlacedObstacle<'a, D>],
    place: &'s [f64; D],
    cell: f64,
) -> impl Iterator<Item = (&'a Obstacle, ObstacleLaw, [f64; 3])> + use<'s, 'a, D> {
    let resting = standing.iter().filter(|own| own.obstacle.motion.is_none());
    resting.filter_map(move |PlacedObstacle { obstacle, surface, laws, .. }| {
        let gap = gap_inside(&**surface, place, cell)?;
        Some((*obstacle, *laws.law_at(&gap.position), spatial(&gap.normal)))
    })
}

/// Outward normal of a surface at a grid node in or on the solid; `None` outside and deep inside.
pub fn normal_inside<const D: usize>(
    surface: &dyn Surface<D>,
    place: &[f64; D],
    cell: f64,
) -> Option<[f64; 3]> {
    gap_inside(surface, place, cell).map(|gap| spatial(&gap.normal))
}

/// Nearest point of a surface, where a position lies inside the obstacle and at most [`MAX_NODE_DEPTH`] cells deep.
fn gap_inside<const D: usize>(
    surface: &dyn Surface<D>,
    place: &[f64; D],
    cell: f64,
) -> Option<NearestPoint<D>> {
    surface.gap(place, MAX_NODE_DEPTH * cell).filter(|gap| gap.distance <= OVERLAP_TOLERANCE * cell)
}

/// Moving obstacles of a case. `F` is the action of an obstacle in a method.
#[derive(Clone, Debug)]
pub struct MovingObstacles<F, const D: usize> {
    obstacles: Vec<(F, MovingObstacle<D>, RigidTransform<D>)>,
    step: f64,
}

impl<F: Copy, const D: usize> MovingObstacles<F, D> {
    /// Moving obstacles of a case in a domain with the corners `domain` (m). `acts` maps a boundary law to the action in the method.
    pub fn new(
        standing: &[PlacedObstacle<'_, D>],
        domain: ([f64; D], [f64; D]),
        acts: impl Fn(&Obstacle, &ObstacleLaw) -> F,
    ) -> Self {
        let moving = |PlacedObstacle { obstacle, surface, laws, .. }: &PlacedObstacle<'_, D>| {
            let motion = obstacle.motion.as_ref()?;
            let own = MovingObstacle::new(motion, surface, domain);
            Some((acts(obstacle, laws.law_at(&[0.0; D])), own, motion.transform(0.0)))
        };
        Self { obstacles: standing.iter().filter_map(moving).collect(), step: 0.0 }
    }

    /// Whether there are no moving obstacles.
    pub fn is_empty(&self) -> bool {
        self.obstacles.is_empty()
    }

    /// Iterates over the moving obstacles.
    pub fn iter(&self) -> impl Iterator<Item = &MovingObstacle<D>> {
        self.obstacles.iter().map(|(_, own, _)| own)
    }

    /// Iterates over the moving obstacles, to be changed.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut MovingObstacle<D>> {
        self.obstacles.iter_mut().map(|(_, own, _)| own)
    }

    /// Moves them to the start of a step of `dt` (s) from `time` (s), with the mean velocity of the step.
    pub fn update_positions(&mut self, (time, dt): (f64, f64)) {
        self.step = dt;
        for (_, own, next) in &mut self.obstacles {
            own.move_to(time);
            *next = own.transform(time + dt);
        }
    }

    /// Moving obstacles that contain a grid node. Each has its action, normal and velocity (m/s) there.
    pub fn constraining(&self, place: &[f64; D], cell: f64) -> impl Iterator<Item = (F, [f64; 3], [f64; 3])> {
        self.obstacles.iter().filter_map(move |(acts, own, next)| {
            let (normal, velocity) = own.nodal_constraint(place, cell, (next, self.step))?;
            Some((*acts, normal, velocity))
        })
    }
}
