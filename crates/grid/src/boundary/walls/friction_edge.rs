//! Frictional walls with different velocities that share an edge.
//!
//! Friction of all walls is simultaneous. `v` is the nodal velocity at the end of the step, `s_k` its tangential part relative to wall `k`,
//! and `j_k` the normal impulse of the wall (both per unit mass). Friction is `-μ_k j_k s_k/|s_k|`, or the impulse that stops the node
//! where `s_k = 0`. Friction of one wall adds to the normal impulse of another.

use crate::boundary::walls::{NodeWall, WallKind, length};

/// Iterations for the coupled normal impulses of the walls. The error is reduced by the product of their friction coefficients in two
/// iterations; with a product of one or more the node is wedged and sticks.
const MAX_ITERATIONS: usize = 64;

/// Node at an edge of unilateral or frictional walls with different velocities.
pub(super) struct FrictionEdge<'a> {
    /// Wall normal to each axis, if the node has one.
    pub walls: [Option<&'a NodeWall>; 3],
    /// Whether each velocity component is prescribed by other walls.
    pub constrained_components: [bool; 3],
    /// Velocity at the start of the step (m/s).
    pub start: [f64; 3],
    /// Velocity of the node at the end of the step without these walls (m/s).
    pub free_velocity: [f64; 3],
    /// Velocity change by the pore pressure that the wall takes (m/s).
    pub pore_pressure_part: [f64; 3],
}

impl FrictionEdge<'_> {
    /// Velocity of the node after the walls (m/s), from the normal impulses `pushes` of the walls in contact (m/s).
    pub fn solve(&self, mut pushes: [Option<f64>; 3]) -> [f64; 3] {
        let mut end = self.free_velocity;
        // Friction of the other walls may open or close the contact with a wall.
        for _ in 0..6 {
            let rubbed;
            (end, rubbed) = self.friction_velocity(&pushes);
            let before = pushes;
            for wall in self.walls.into_iter().flatten() {
                let axis = wall.axis;
                match before[axis] {
                    Some(_)
                        if wall.separation
                            && wall.approach_velocity(&self.free_velocity) + rubbed[axis] < 0.0 =>
                    {
                        pushes[axis] = None;
                    }
                    None if wall.approach_velocity(&end) > 0.0 => {
                        pushes[axis] = Some(self.normal_impulse(wall));
                    }
                    _ => {}
                }
            }
            if pushes == before {
                return end;
            }
        }
        for wall in self.walls.into_iter().flatten() {
            if wall.approach_velocity(&end) > 0.0 {
                end[wall.axis] = wall.velocity[wall.axis];
            }
        }
        end
    }

    /// Normal impulse of a wall if it acted alone (m/s).
    fn normal_impulse(&self, wall: &NodeWall) -> f64 {
        wall.approach_velocity(&std::array::from_fn(|c| self.free_velocity[c] + self.pore_pressure_part[c]))
    }

    /// Velocity after given normal impulses, and normal impulse on each wall by the friction of the others (m/s).
    fn friction_velocity(&self, pushes: &[Option<f64>; 3]) -> ([f64; 3], [f64; 3]) {
        let acting = || self.walls.into_iter().flatten().filter(|wall| pushes[wall.axis].is_some());
        let mut end = self.free_velocity;
        acting().for_each(|wall| end[wall.axis] = wall.velocity[wall.axis]);
        let rough = || acting().filter(|wall| wall.kind == WallKind::Rough);
        let loose = |c: usize| pushes[c].is_none() && !self.constrained_components[c];
        let count = rough().count();
        if count > 0 {
            for c in (0..3).filter(|c| loose(*c)) {
                end[c] = rough().map(|wall| wall.velocity[c]).sum::<f64>() / count as f64;
            }
            return (
                end,
                self.friction_normal_impulses(acting, |wall, c| match wall.kind {
                    WallKind::Rough => wall.velocity[c] - self.free_velocity[c],
                    _ => 0.0,
                }),
            );
        }
        if acting().count() == 1 {
            acting().for_each(|wall| {
                wall.apply_friction(&self.start, &mut end, pushes[wall.axis].unwrap_or(0.0));
            });
            return (end, [0.0; 3]);
        }
        let stopped = end;
        let coefficients = self.walls.map(|wall| {
            wall.map_or(0.0, |wall| {
                wall.coefficient(&self.start, length(&wall.tangential_velocity(&stopped)))
            })
        });
        let mut rubbed = [0.0; 3];
        for _ in 0..MAX_ITERATIONS {
            let bound = |wall: &NodeWall| {
                let axis = wall.axis;
                coefficients[axis] * (pushes[axis].unwrap_or(0.0) + rubbed[axis]).max(0.0)
            };
            if let Some(c) = (0..3).find(|c| loose(*c)) {
                let frictions = || {
                    acting().map(|wall| {
                        let slip = wall.tangential_velocity(&stopped);
                        let tangential_speed =
                            length(&std::array::from_fn(|d| if d == c { 0.0 } else { slip[d] }));
                        EdgeFriction { speed: wall.velocity[c], tangential_speed, bound: bound(wall) }
                    })
                };
                end[c] = friction_equilibrium(self.free_velocity[c], frictions);
            }
            let next = self.friction_normal_impulses(acting, |wall, c| {
                let slip = wall.tangential_velocity(&end);
                if slip[c] == 0.0 { 0.0 } else { -bound(wall) * slip[c] / length(&slip) }
            });
            if next == rubbed {
                break;
            }
            rubbed = next;
        }
        (end, rubbed)
    }

    /// Normal impulse on each wall by the `friction` of the others along its normal (m/s).
    fn friction_normal_impulses<'a, W: Iterator<Item = &'a NodeWall>>(
        &self,
        acting: impl Fn() -> W,
        friction: impl Fn(&NodeWall, usize) -> f64,
    ) -> [f64; 3] {
        let mut rubbed = [0.0; 3];
        for wall in acting() {
            let others = acting().filter(|other| other.axis != wall.axis);
            let sum: f64 = others.map(|other| friction(other, wall.axis)).sum();
            rubbed[wall.axis] = if wall.is_upper { sum } else { -sum };
        }
        rubbed
    }
}

/// Friction of a wall on the single free velocity component of a node.
struct EdgeFriction {
    /// Velocity of the wall (m/s).
    speed: f64,
    /// Speed of the node relative to the wall in the other components (m/s).
    tangential_speed: f64,
    /// Largest velocity change by friction (m/s).
    bound: f64,
}

/// Velocity component after the friction of all walls (m/s), the minimum of `½(v-v₀)² + Σ b √(a² + (v-V)²)` with `v₀ = free`.
fn friction_equilibrium<I: Iterator<Item = EdgeFriction>>(free: f64, frictions: impl Fn() -> I) -> f64 {
    let slope = |velocity: f64| {
        let rub = |friction: EdgeFriction| match velocity - friction.speed {
            0.0 => 0.0,
            slip => friction.bound * slip / slip.hypot(friction.tangential_speed),
        };
        velocity - free + frictions().map(rub).sum::<f64>()
    };
    for stick in frictions().filter(|friction| friction.tangential_speed == 0.0) {
        let same =
            frictions().filter(|friction| friction.tangential_speed == 0.0 && friction.speed == stick.speed);
        if slope(stick.speed).abs() <= same.map(|friction| friction.bound).sum() {
            return stick.speed;
        }
    }
    let reach: f64 = frictions().map(|friction| friction.bound).sum();
    let (mut low, mut high) = (free - reach, free + reach);
    loop {
        let middle = 0.5 * (low + high);
        if !(low < middle && middle < high) {
            return middle;
        }
        if slope(middle) > 0.0 { high = middle } else { low = middle }
    }
}

#[cfg(test)]
mod tests {
    use crate::boundary::walls::{NodeWall, NodeWalls, WallKind};

    const FREE_VELOCITY: [f64; 3] = [1.3, -0.8, 0.5];
    const COEFFICIENTS: [f64; 2] = [0.3, 0.6];

    /// A wall at the upper end of x and a floor, with velocities.
    fn walls(separation: bool, [side, floor]: [[f64; 3]; 2]) -> [NodeWall; 2] {
        let [a, b] = COEFFICIENTS.map(|coefficient| WallKind::Frictional { coefficient });
        let wall =
            |axis, is_upper, kind, velocity| NodeWall { axis, is_upper, node: 0, kind, separation, velocity };
        [wall(0, true, a, side), wall(1, false, b, floor)]
    }

    /// Velocity after the walls, with permuted axes: axis `c` becomes `order[c]`.
    fn constrained_velocity(walls: &[NodeWall], order: [usize; 3], free: [f64; 3]) -> [f64; 3] {
        let turned = |v: [f64; 3]| {
            let mut out = [0.0; 3];
            (0..3).for_each(|c| out[order[c]] = v[c]);
            out
        };
        let turn =
            |wall: &NodeWall| NodeWall { axis: order[wall.axis], velocity: turned(wall.velocity), ..*wall };
        let (mut start, mut end) = ([0.0; 3], turned(free));
        NodeWalls::new(&[1; 3], walls.iter().map(turn).collect())
            .constrain(&[0; 3], &mut start, &mut end, true);
        order.map(|c| end[c])
    }

    const VELOCITIES: [[[f64; 3]; 2]; 6] = [
        [[0.1, 0.3, -0.2], [0.4, 0.05, 0.9]],
        [[0.1, -0.3, 0.2], [-0.4, 0.05, -0.9]],
        [[0.0, 0.0, 0.7], [0.0, 0.0, -0.1]],
        [[0.0, 0.0, 0.49], [0.0, 0.0, 0.52]],
        [[0.0, 9.0, 0.1], [0.0; 3]],
        [[0.0; 3], [-30.0, 0.0, 0.1]],
    ];

    #[test]
    fn edges_of_moving_walls_are_independent_of_the_order_of_axes() {
        let orders = [[0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        for (velocities, separation) in VELOCITIES.into_iter().flat_map(|v| [(v, false), (v, true)]) {
            let [side, floor] = walls(separation, velocities);
            let roof = NodeWall { axis: 2, velocity: [0.2, -0.1, 0.3], ..side };
            for walls in [vec![side, floor], vec![side, floor, roof]] {
                let here = constrained_velocity(&walls, [0, 1, 2], FREE_VELOCITY);
                let back: Vec<NodeWall> = walls.iter().rev().copied().collect();
                for there in orders
                    .map(|order| constrained_velocity(&walls, order, FREE_VELOCITY))
                    .into_iter()
                    .chain([constrained_velocity(&back, [0, 1, 2], FREE_VELOCITY)])
                {
                    let distance = (0..3).map(|c| (here[c] - there[c]).abs()).fold(0.0, f64::max);
                    assert!(distance < 1e-15, "{walls:?}: {here:?}, {there:?}");
                }
            }
        }
    }

    /// Coulomb's law of both walls at once, each with its normal impulse, from the final velocity.
    #[test]
    fn friction_of_both_walls_is_proportional_to_their_normal_impulses() {
        for velocities in &VELOCITIES[..2] {
            let [side, floor] = walls(false, *velocities);
            let end = constrained_velocity(&[side, floor], [0, 1, 2], FREE_VELOCITY);
            assert_eq!([end[0], end[1]], [side.velocity[0], floor.velocity[1]]);
            // Friction direction of each wall.
            let [on_side, on_floor] = [side, floor].map(|wall| {
                let slip: [f64; 3] =
                    std::array::from_fn(|c| if c == wall.axis { 0.0 } else { wall.velocity[c] - end[c] });
                let length = slip.iter().map(|c| c * c).sum::<f64>().sqrt();
                slip.map(|c| c / length)
            });
            // Normal impulses: the node's own approach and the friction of the other wall. Two equations.
            let [a, b] = COEFFICIENTS;
            let (into_side, into_floor) =
                (FREE_VELOCITY[0] - side.velocity[0], floor.velocity[1] - FREE_VELOCITY[1]);
            let (p, q) = (b * on_floor[0], -a * on_side[1]);
            let impulse_on_side = (into_side + p * into_floor) / (1.0 - p * q);
            let impulse_on_floor = into_floor + q * impulse_on_side;
            assert!(impulse_on_side > 0.0 && impulse_on_floor > 0.0);
            let along =
                FREE_VELOCITY[2] + a * impulse_on_side * on_side[2] + b * impulse_on_floor * on_floor[2];
            assert!((end[2] - along).abs() < 1e-14, "{end:?}, {along}");
        }
    }

    #[test]
    fn walls_moving_along_their_edge_each_apply_friction_towards_their_velocity() {
        // Normal impulses of 1.3 and 0.8: the frictions are up to 0.39 and 0.48.
        let along = |side: f64, floor: f64, free: f64| {
            constrained_velocity(
                &walls(true, [[0.0, 0.0, side], [0.0, 0.0, floor]]),
                [0, 1, 2],
                [1.3, -0.8, free],
            )[2]
        };
        assert!((along(2.0, -2.0, 0.5) - (0.5 + 0.39 - 0.48)).abs() < 1e-14, "between them");
        assert!((along(2.0, 3.0, 0.5) - (0.5 + 0.39 + 0.48)).abs() < 1e-14, "slower than both");
        assert_eq!(along(0.1, 0.55, 0.5), 0.55, "it sticks to the floor, which is stronger");
    }

    #[test]
    fn friction_of_a_moving_floor_separates_a_node_from_the_side_or_presses_it() {
        let acts = |speed: f64, free: [f64; 3]| {
            constrained_velocity(&walls(true, [[0.0; 3], [speed, 0.0, 0.0]]), [0, 1, 2], free)
        };
        // Friction of up to 0.6 against the normal impulse of the wall at the side.
        assert_eq!(acts(-9.0, [0.8, -1.0, 0.0])[0], 0.0, "pushed by more");
        assert!((acts(-9.0, [0.1, -1.0, 0.0])[0] + 0.5).abs() < 1e-15, "pulled off");
        assert_eq!(acts(-0.2, [0.1, -1.0, 0.0]), [-0.2, 0.0, 0.0], "it goes with the floor");
        // A separating node keeps the acceleration of the separation.
        let plane = WallKind::StaticAndSliding { static_coefficient: 0.6, sliding_coefficient: 0.6 };
        let [side, floor] =
            walls(true, [[0.0; 3], [-9.0, 0.0, 0.0]]).map(|wall| NodeWall { kind: plane, ..wall });
        let (mut start, mut end) = ([-0.1, 0.0, 0.0], [0.1, -1.0, 0.0]);
        NodeWalls::new(&[1; 3], vec![side, floor]).constrain(&[0; 3], &mut start, &mut end, false);
        assert!((end[0] + 0.5).abs() < 1e-15 && start == [-0.1, 0.0, 0.0], "{start:?}, {end:?}");
        // The node rests at the side; the floor friction presses it there by 0.6, and 0.3 × 0.6 acts on the third component.
        let end = acts(1e9, [0.0, -1.0, 0.5]);
        assert!(end[0] == 0.0 && end[1] == 0.0 && (end[2] - (0.5 - 0.18)).abs() < 1e-8, "{end:?}");
    }
}
