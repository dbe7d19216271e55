//! Support of rigid bodies by walls and obstacles: contacts of the corners of their points.

use colluvium_points::Surface;
use colluvium_points::surface::dot;

use crate::rigid::rigid_contact_newton::{ContactLawAtPoint, ContactSystem, add_impulses, add_stiffness};
use crate::rigid::{RigidStep, Twist, velocity_at};
use crate::{MovingObstacle, ObstacleLaws, spatial};

/// Inertia of the ground in the contact law, over the mass of the body: a body sinks into the ground under its weight by this factor more
/// slowly than it falls from rest in a step.
const SUPPORT_INERTIA_RATIO: f64 = 1e6;

/// Corner of a body near the ground.
#[derive(Clone, Copy, Debug)]
pub struct SupportPoint {
    /// Position relative to the centre of mass (m).
    pub lever_arm: [f64; 3],
    /// Velocity of the ground (m/s).
    pub velocity: [f64; 3],
    /// Number of the obstacle; `None` for a wall.
    pub obstacle: Option<usize>,
    /// Unit normal out of the ground.
    normal: [f64; 3],
    /// Approach velocity with which the corner reaches the ground in the step (m/s).
    max_approach_velocity: f64,
    /// Friction coefficient; infinite for sticking.
    friction: f64,
}

/// Plane wall that supports rigid bodies.
#[derive(Clone, Copy, Debug)]
pub struct WallPlane {
    /// Axis normal to its face.
    pub axis: usize,
    /// Sign of the normal along that axis: 1 or -1.
    pub normal_sign: f64,
    /// Coordinate of its face (m).
    pub face: f64,
    /// Velocity (m/s).
    pub velocity: [f64; 3],
    /// Friction coefficient; infinite for sticking.
    pub friction: f64,
}

/// Obstacle that supports rigid bodies.
#[derive(Clone, Copy, Debug)]
pub struct ObstacleContact<'a, const D: usize> {
    /// Surface at its current position.
    pub surface: &'a dyn Surface<D>,
    /// Boundary laws of the obstacle.
    pub laws: &'a ObstacleLaws,
    /// Motion; `None` at rest.
    pub motion: Option<&'a MovingObstacle<D>>,
}

impl SupportPoint {
    /// Normal impulse (N s) of the ground on a body with the velocity `w` (m/s), tangential impulse per sliding velocity (kg), and sliding
    /// velocity (m/s). `None` without contact.
    fn support_force(&self, inertia: f64, w: &[f64; 3], stuck: bool) -> Option<(f64, f64, [f64; 3])> {
        let relative: [f64; 3] = std::array::from_fn(|c| w[c] - self.velocity[c]);
        let away = dot(&relative, &self.normal);
        let push = inertia * (-away - self.max_approach_velocity);
        let along: [f64; 3] = std::array::from_fn(|c| relative[c] - away * self.normal[c]);
        let slip = dot(&along, &along).sqrt();
        let held = if slip > 0.0 && !stuck { inertia.min(self.friction * push / slip) } else { inertia };
        // The comparison gives no contact for NaN.
        (push > 0.0).then_some((push, held, along))
    }
}

/// Support point with a finite inertia of the ground (kg); the last value is whether all contacts stick.
struct StiffSupport<'a>(&'a SupportPoint, f64, bool);

impl ContactLawAtPoint for StiffSupport<'_> {
    fn lever_arm(&self) -> &[f64; 3] {
        &self.0.lever_arm
    }

    fn impulse(&self, w: &[f64; 3]) -> [f64; 3] {
        let Self(plank, inertia, stuck) = *self;
        plank.support_force(inertia, w, stuck).map_or([0.0; 3], |(push, held, along)| {
            std::array::from_fn(|c| push * plank.normal[c] - held * along[c])
        })
    }

    fn stiffness(&self, w: &[f64; 3]) -> [[f64; 3]; 3] {
        let Self(plank, inertia, stuck) = *self;
        let Some((_, held, along)) = plank.support_force(inertia, w, stuck) else { return [[0.0; 3]; 3] };
        let slip = dot(&along, &along).sqrt();
        let slips = held < inertia && slip > 0.0;
        let t = along.map(|c| if slips { c / slip } else { 0.0 });
        let drag = if slips { plank.friction } else { 0.0 };
        let n = &plank.normal;
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let one = if i == j { 1.0 } else { 0.0 };
                inertia * (n[i] - drag * t[i]) * n[j] + held * (one - n[i] * n[j] - t[i] * t[j])
            })
        })
    }
}

/// Reaction of a rigid body on an obstacle in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SupportReaction {
    /// Number of the obstacle.
    pub obstacle: usize,
    /// Impulse on the obstacle (N s).
    pub impulse: [f64; 3],
    /// Position (m).
    pub position: [f64; 3],
    /// Dissipation by friction (J), not negative.
    pub friction: f64,
    /// Work of the motion of the obstacle on the body (J).
    pub work: f64,
}

/// Corners of the points of a rigid body in a step.
struct BodyCorners<'a, const D: usize> {
    step: &'a RigidStep,
    dt: f64,
    /// Positions of the points (m).
    positions: &'a [[f64; D]],
    /// Half the width of a point (m).
    half_width: f64,
    /// Positions of the corners relative to the centre of a point (m); zero along the third axis in a plane.
    corner_offsets: [[f64; 3]; 8],
    /// Distance of the farthest point from the centre of mass, without its width (m).
    radius: f64,
    /// Largest distance from a corner of surfaces that it can reach in the step (m).
    search_distance: f64,
}

impl<'a, const D: usize> BodyCorners<'a, D> {
    /// Corners of the points of a rigid body at the start of a step, with the distance within which contacts are sought (m).
    fn new(step: &'a RigidStep, dt: f64, positions: &'a [[f64; D]], half_width: f64) -> Self {
        let own = std::array::from_fn(|k| {
            let axis =
                |a: usize| if a < D { half_width * if k >> a & 1 == 0 { -1.0 } else { 1.0 } } else { 0.0 };
            let own = [axis(0), axis(1), axis(2)];
            std::array::from_fn(|c| (0..3).map(|a| step.axes[c][a] * own[a]).sum())
        });
        let size = |v: [f64; 3]| dot(&v, &v).sqrt();
        let radius = positions.iter().map(|x| size(step.mass.lever_arm(&spatial(x)))).fold(0.0, f64::max);
        let near = half_width.max(dt * (size(step.velocity()) + radius * size(step.angular_velocity())));
        Self { step, dt, positions, half_width, corner_offsets: own, radius, search_distance: near }
    }

    /// Corner position relative to the centre of mass (m).
    fn lever_arm(&self, x: &[f64; D], own: &[f64; 3]) -> [f64; 3] {
        let at = spatial(x);
        self.step.mass.lever_arm(&std::array::from_fn(|c| at[c] + own[c]))
    }

    /// Adds the corners that touch a wall or may reach it in the step.
    fn find_wall_support(&self, side: &WallPlane, found: &mut Vec<SupportPoint>) {
        let WallPlane { axis, normal_sign, face, velocity, friction } = *side;
        let normal = std::array::from_fn(|c| if c == axis { normal_sign } else { 0.0 });
        for x in self
            .positions
            .iter()
            .filter(|x| normal_sign * (x[axis] - face) <= self.search_distance + 2.0 * self.half_width)
        {
            for own in &self.corner_offsets[..1 << D] {
                let gap = normal_sign * (x[axis] + own[axis] - face);
                if gap <= self.search_distance {
                    let (lever_arm, room) = (self.lever_arm(x, own), gap.max(0.0) / self.dt);
                    found.push(SupportPoint {
                        lever_arm,
                        velocity,
                        obstacle: None,
                        normal,
                        max_approach_velocity: room,
                        friction,
                    });
                }
            }
        }
    }

    /// Adds the corners that touch an obstacle or may reach it in the step.
    fn find_obstacle_support(
        &self,
        number: usize,
        rock: &ObstacleContact<'_, D>,
        found: &mut Vec<SupportPoint>,
    ) {
        let reach = self.search_distance + (D as f64).sqrt() * self.half_width;
        let centre = std::array::from_fn(|c| self.step.mass.centre[c]);
        if rock.surface.gap(&centre, self.radius + reach).is_none() {
            return;
        }
        for x in self.positions.iter().filter(|x| rock.surface.gap(x, reach).is_some()) {
            for own in &self.corner_offsets[..1 << D] {
                let corner: [f64; D] = std::array::from_fn(|c| x[c] + own[c]);
                let gap = rock.surface.gap(&corner, reach).filter(|gap| gap.distance <= self.search_distance);
                let Some(gap) = gap else { continue };
                found.push(SupportPoint {
                    lever_arm: self.lever_arm(x, own),
                    velocity: spatial(&rock.motion.map_or([0.0; D], |moving| moving.velocity(&corner))),
                    obstacle: Some(number),
                    normal: spatial(&gap.normal),
                    max_approach_velocity: gap.distance.max(0.0) / self.dt,
                    friction: rock.laws.law_at(&gap.position).friction(),
                });
            }
        }
    }
}

/// Corners of a rigid body that can reach the ground in a step.
#[derive(Clone, Debug, Default)]
pub struct SupportPoints {
    points: Vec<SupportPoint>,
    /// Inertia of the ground (kg).
    inertia: f64,
}

impl SupportPoints {
    /// Whether there are no support points.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Adds the impulses of the ground on a body with this motion; with `stuck`, all supports stick.
    pub fn add_impulses(&self, motion: &Twist, stuck: bool, sum: &mut Twist) {
        add_impulses(self.points.iter().map(|plank| StiffSupport(plank, self.inertia, stuck)), motion, sum);
    }

    /// Adds the decrease of these impulses with the motion.
    pub fn add_stiffness(&self, motion: &Twist, stuck: bool, sum: &mut [Twist; 6]) {
        add_stiffness(self.points.iter().map(|plank| StiffSupport(plank, self.inertia, stuck)), motion, sum);
    }

    /// Reactions on obstacles for the motion of the body at the end of its step, point by point. With `stuck`, as in a step whose contact
    /// was not solved, they are the sticking forces, and friction only dissipates the work of the residual slip.
    pub fn reactions<'a>(
        &'a self,
        step: &'a RigidStep,
        stuck: bool,
    ) -> impl Iterator<Item = SupportReaction> + 'a {
        self.points.iter().filter_map(move |plank| {
            let (obstacle, w) = (plank.obstacle?, velocity_at(&step.motion, &plank.lever_arm));
            let (_, held, along) = plank.support_force(self.inertia, &w, stuck)?;
            let impulse = StiffSupport(plank, self.inertia, stuck).impulse(&w);
            Some(SupportReaction {
                obstacle,
                impulse: impulse.map(|i| -i),
                position: std::array::from_fn(|c| step.mass.centre[c] + plank.lever_arm[c]),
                friction: held * dot(&along, &along),
                work: dot(&impulse, &plank.velocity),
            })
        })
    }

    /// Finds the corners of a rigid body that can reach walls or obstacles in a step of `dt` (s). Its points are squares or cubes of half
    /// width `half_width` (m) at `positions` (m).
    pub fn list<'a, const D: usize>(
        &mut self,
        (step, dt): (&RigidStep, f64),
        (positions, half_width): (&[[f64; D]], f64),
        sides: impl Iterator<Item = WallPlane>,
        rocks: impl Iterator<Item = ObstacleContact<'a, D>>,
    ) {
        self.points.clear();
        self.inertia = SUPPORT_INERTIA_RATIO * step.mass.mass;
        let corners = BodyCorners::new(step, dt, positions, half_width);
        sides.for_each(|side| corners.find_wall_support(&side, &mut self.points));
        for (number, rock) in rocks.enumerate() {
            corners.find_obstacle_support(number, &rock, &mut self.points);
        }
    }

    /// Solves the contact of the body with the ground, and sets its motion. Returns whether the iteration has converged.
    pub fn solve(&self, step: &mut RigidStep) -> bool {
        if self.is_empty() {
            return true;
        }
        let (motion, done) = step.solve_contact(self);
        step.motion = motion;
        done
    }
}

impl ContactSystem for SupportPoints {
    fn impulse(&self, motion: &Twist, stuck: bool) -> Twist {
        let mut sum = [0.0; 6];
        self.add_impulses(motion, stuck, &mut sum);
        sum
    }

    fn stiffness(&self, motion: &Twist, stuck: bool) -> [Twist; 6] {
        let mut sum = [[0.0; 6]; 6];
        self.add_stiffness(motion, stuck, &mut sum);
        sum
    }
}
