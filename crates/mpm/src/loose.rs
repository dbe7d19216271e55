//! Rigid bodies that forces move: mass, moments of inertia, Newton's law (docs/theory/mpm.md, rigid bodies).

use colluvium_case::description::PrescribedMotion;
use colluvium_case::spatial;

use crate::clock::Clock;
use crate::momentum::{RowSums, sign, slowed};
use crate::points::PointSet;
use crate::six::{Six, rotation, solve, times, velocity_at};

/// Velocity, momentum of turning and orientation of a rigid body.
pub struct Course {
    /// Velocity of the centre of mass (m/s).
    pub velocity: [f64; 3],
    /// Angular momentum about the centre of mass (kg m²/s), with mass scaling.
    pub turning: [f64; 3],
    /// Where its axes are, as columns.
    pub axes: [[f64; 3]; 3],
}

/// Axes of a body that has not turned.
pub const UPRIGHT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A rigid body that moves freely, in a step.
#[derive(Clone, Debug)]
pub struct Loose {
    /// Mass (kg), with mass scaling.
    mass: f64,
    /// Moments of inertia about the centre of mass (kg m²), with mass scaling.
    inertia: [[f64; 3]; 3],
    /// Centre of mass (m).
    pub centre: [f64; 3],
    /// Its axes at the start of the case, where they are now, as columns.
    pub axes: [[f64; 3]; 3],
    /// Which components of its motion follow forces.
    pub free: [bool; 6],
    /// Its motion at the start of the step.
    start: Six,
    /// Its motion at the end, as far as it is known.
    pub motion: Six,
    /// Force and moment from outside, weight included (N, N m).
    applied: Six,
}

/// Centre of mass of points (m).
pub fn centre<const D: usize>(set: &PointSet<D>) -> [f64; 3] {
    let mut sum = [0.0; D];
    for (m, x) in set.points.mass.iter().zip(&set.points.position) {
        (0..D).for_each(|c| sum[c] += m * x[c]);
    }
    let mass = set.points.mass.iter().sum::<f64>();
    spatial(&sum.map(|c| c / mass))
}

/// Moment of inertia of a point of a mass about its own middle, over the mass (m²): that of a square or cube.
pub fn own_inertia<const D: usize>(set: &PointSet<D>) -> f64 {
    set.extent[0] * set.extent[0] / 6.0
}

/// Moments of inertia of points about a place (kg m²).
fn inertia<const D: usize>(set: &PointSet<D>, centre: &[f64; 3]) -> [[f64; 3]; 3] {
    let (own, mut sum) = (own_inertia(set), [[0.0; 3]; 3]);
    for (m, x) in set.points.mass.iter().zip(&set.points.position) {
        let x = spatial(x);
        let arm: [f64; 3] = std::array::from_fn(|c| x[c] - centre[c]);
        let square = arm.iter().map(|c| c * c).sum::<f64>() + own;
        for i in 0..3 {
            (0..3).for_each(|j| sum[i][j] -= m * arm[i] * arm[j]);
            sum[i][i] += m * square;
        }
    }
    sum
}

/// Turns components of rotation that are `free` into a spin (rad/s) with a given angular momentum.
fn spin(inertia: &[[f64; 3]; 3], turning: &[f64; 3], free: &[bool; 6]) -> [f64; 3] {
    let matrix = spread(1.0, inertia);
    let right = [0.0, 0.0, 0.0, turning[0], turning[1], turning[2]];
    let only = [false, false, false, free[3], free[4], free[5]];
    solve(&matrix, &right, &only).map_or([0.0; 3], |x| [x[3], x[4], x[5]])
}

/// Mass and moments of inertia as one matrix.
fn spread(mass: f64, inertia: &[[f64; 3]; 3]) -> [Six; 6] {
    std::array::from_fn(|i| {
        std::array::from_fn(|j| match (i < 3, j < 3) {
            (true, true) if i == j => mass,
            (false, false) => inertia[i - 3][j - 3],
            _ => 0.0,
        })
    })
}

impl Loose {
    /// The body at the start of a step, with the motion at its end that forces from outside give it.
    pub fn new<const D: usize>(
        clock: &Clock,
        set: &PointSet<D>,
        motion: &PrescribedMotion,
        course: &Course,
    ) -> Self {
        let scale = clock.options.mass_scaling;
        let elapsed = clock.time + clock.dt - clock.stage_start;
        let own = set.points.mass.iter().sum::<f64>();
        let centre = centre(set);
        let mass = scale * own;
        let inertia = inertia(set, &centre).map(|row| row.map(|i| scale * i));
        let held = motion.velocity_at(elapsed);
        let free = std::array::from_fn(|c| match c {
            0..3 => c < D && held[c].is_none(),
            5 => motion.turns && D >= 2,
            _ => motion.turns && D == 3,
        });
        let (force, moment, gravity) =
            (motion.force_at(elapsed), motion.moment_at(elapsed), clock.gravity_at_end());
        let mut applied = [0.0; 6];
        for c in 0..3 {
            applied[c] = force[c] + own * gravity[c];
            applied[c + 3] = moment[c];
        }
        let share = clock.dt * clock.stage().rayleigh_damping;
        let turning = course.turning.map(|l| if motion.turns { l } else { 0.0 });
        let begun = spin(&inertia, &turning, &free);
        let pushed: [f64; 3] =
            std::array::from_fn(|c| slowed(turning[c], turning[c] + clock.dt * moment[c], share));
        let turned = spin(&inertia, &pushed, &free);
        let mut start = [0.0; 6];
        let mut end = [0.0; 6];
        for c in 0..3 {
            start[c] = course.velocity[c];
            let pushed = slowed(start[c], start[c] + clock.dt * applied[c] / mass, share);
            end[c] = held[c].unwrap_or(if free[c] { pushed } else { 0.0 });
            (start[c + 3], end[c + 3]) = (begun[c], turned[c]);
        }
        Self { mass, inertia, centre, axes: course.axes, free, start, motion: end, applied }
    }

    /// Mass and moments of inertia.
    pub fn matrix(&self) -> [Six; 6] {
        spread(self.mass, &self.inertia)
    }

    /// Mass (kg), with mass scaling.
    pub fn mass(&self) -> f64 {
        self.mass
    }

    /// Velocity of the body at a place (m/s).
    pub fn velocity_at(&self, x: &[f64; 3]) -> [f64; 3] {
        velocity_at(&self.motion, &self.arm(x))
    }

    /// A place from the centre of mass (m).
    pub fn arm(&self, x: &[f64; 3]) -> [f64; 3] {
        std::array::from_fn(|c| x[c] - self.centre[c])
    }

    /// Takes an impulse and its moment about the centre of mass (N s, N m s).
    pub fn push(&mut self, impulse: &Six) {
        if let Some(change) = solve(&self.matrix(), impulse, &self.free) {
            (0..6).for_each(|k| self.motion[k] += change[k]);
        }
    }

    /// Local damping of its free components by all that accelerates it; rotation by the largest factor of the axes.
    pub fn damp(&mut self, damping: &[f64; 3]) {
        let most = damping.iter().copied().fold(0.0, f64::max);
        for k in (0..6).filter(|k| self.free[*k]) {
            let change = self.motion[k] - self.start[k];
            let factor = damping.get(k).copied().unwrap_or(most);
            self.motion[k] -= factor * change.abs() * sign(self.start[k]);
        }
    }

    /// Angular momentum about the centre of mass (kg m²/s), with mass scaling.
    pub fn turning(&self) -> [f64; 3] {
        if self.free[5] { times(&self.inertia, &self.spin()) } else { [0.0; 3] }
    }

    /// Velocity of the centre of mass (m/s).
    pub fn velocity(&self) -> [f64; 3] {
        [self.motion[0], self.motion[1], self.motion[2]]
    }

    /// Spin (rad/s).
    pub fn spin(&self) -> [f64; 3] {
        [self.motion[3], self.motion[4], self.motion[5]]
    }

    /// Work of the forces from outside in a step of `dt` (J).
    pub fn work(&self, dt: f64) -> f64 {
        (0..6).filter(|k| self.free[*k]).map(|k| self.applied[k] * self.motion[k] * dt).sum()
    }

    /// What it adds to the measures of equilibrium in a step of `dt`, with local damping of the axes and Rayleigh damping.
    pub fn audit(&self, dt: f64, damping: &[f64; 3], rayleigh: f64) -> RowSums {
        let mut sums = RowSums { work: self.work(dt), ..RowSums::default() };
        for c in (0..3).filter(|c| self.free[*c]) {
            let (start, end) = (self.start[c], self.motion[c]);
            let net = self.mass * ((end - start) / dt + rayleigh * 0.5 * (start + end));
            let unbalanced = net / (1.0 - damping[c] * sign(start) * sign(net));
            sums.unbalanced += unbalanced * unbalanced;
            sums.external += self.applied[c] * self.applied[c];
        }
        let momentum = times(&self.matrix(), &self.motion);
        sums.kinetic = 0.5 * (0..6).map(|k| momentum[k] * self.motion[k]).sum::<f64>();
        sums
    }

    /// Where its axes are after a step of `dt`.
    pub fn turned_axes(&self, dt: f64) -> [[f64; 3]; 3] {
        let turn = rotation(&self.spin().map(|w| dt * w));
        std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| turn[i][k] * self.axes[k][j]).sum()))
    }

    /// Radius of gyration about the axis of the largest (m).
    pub fn radius(&self) -> f64 {
        (0..3).map(|k| self.inertia[k][k] / self.mass).fold(0.0, f64::max).sqrt()
    }

    /// Moves its points in a step of `dt`; returns the spin with which the body keeps its angular momentum where it then is.
    pub fn move_points<const D: usize>(&self, dt: f64, set: &mut PointSet<D>) -> [f64; 3] {
        let turn = rotation(&self.spin().map(|w| dt * w));
        let turns = self.free[5];
        let back: [[f64; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| turn[j][i]));
        let after = times(&turn, &spin(&self.inertia, &times(&back, &self.turning()), &self.free));
        let [vx, vy, vz] = self.velocity();
        let motion = [vx, vy, vz, after[0], after[1], after[2]];
        for (x, v) in set.points.position.iter_mut().zip(&mut set.points.velocity) {
            let mut arm = self.arm(&spatial(x));
            if turns {
                arm = times(&turn, &arm);
            }
            let velocity = velocity_at(&motion, &arm);
            for c in 0..D {
                x[c] = if turns { self.centre[c] + arm[c] } else { x[c] } + dt * self.motion[c];
                v[c] = velocity[c];
            }
        }
        after
    }
}

/// Motion and spin (rad/s) with which a body begins, when the case gives it a velocity.
pub fn course_at_start<const D: usize>(clock: &Clock, set: &PointSet<D>) -> (Course, [f64; 3]) {
    let centre = centre(set);
    let given = &clock.case.bodies[set.body as usize].velocity;
    let velocity = given.at(centre);
    // The velocity is linear: differences over a metre are its gradient.
    let slope = |i: usize, j: usize| {
        let mut to = centre;
        to[j] += 1.0;
        given.at(to)[i] - velocity[i]
    };
    let spin = [slope(2, 1), slope(0, 2), slope(1, 0)];
    let scale = clock.options.mass_scaling;
    let turning = times(&inertia(set, &centre), &spin).map(|l| scale * l);
    (Course { velocity, turning, axes: UPRIGHT }, spin)
}
