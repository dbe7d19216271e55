//! Velocities of controlled walls: those that a program prescribes, and those of servos that follow a stress (sheet: dem §3.7).

use crate::boundary::boundary_conditions::BoundaryConditions;
use crate::boundary::controlled_cell::ControlledCell;
use crate::clock::Clock;
use crate::contact::contact_laws::ContactLaws;
use crate::force_loop::ContactInput;
use crate::neighbours::wall_list::WallList;
use crate::points::grains::Grains;

/// Updates the velocities of walls that a program moves, and of servo-controlled walls, for a step of `dt` (s). The inward velocity is `(α (F - F_w) + Δt Σ k_n v_n + Σ γ_n v)
/// / (Δt Σ k_n + Σ γ_n)`, limited to the given speed, and that speed without contact. `v` is the old wall velocity, as the wall force
/// includes dashpots. Without dashpots in the rule, a wall with `α Σ γ_n > Δt Σ k_n` reverses every step. `v_n` are the velocities of the
/// grains in contact with the wall: the wall moves with them, and also corrects a share of the missing force (sheet: dem §3.7).
pub fn update_servo_walls<const D: usize, const R: usize>(
    clock: &Clock,
    laws: &ContactLaws,
    cell: &ControlledCell<D>,
    grains: &Grains<D, R>,
    wall_list: &WallList<R>,
    boundary: &mut BoundaryConditions<D>,
    dt: f64,
) {
    for number in 0..boundary.walls.len() {
        let wall = &mut boundary.walls[number];
        if let Some(velocity) = wall.program_velocity {
            wall.velocity = velocity;
            continue;
        }
        let wall = &boundary.walls[number];
        let Some(servo) = clock.stage_options().and_then(|stage| stage.walls.get(&wall.name)) else {
            continue;
        };
        let (axis, inward) = wall.inward_normal();
        let area = boundary.servo_area(clock, &cell.geometry, grains, servo, axis);
        let missing = -servo.stress * area - wall.outward_force();
        let input = ContactInput::new(grains.view(), &laws.stage.pairs, laws.kinds.len());
        let [stiffness, dashpots, carried] = input.wall_stiffness_sums(number, wall, wall_list);
        let free = if stiffness > 0.0 {
            let known = dt * carried + dashpots * inward * wall.velocity[axis];
            (servo.gain * missing + known) / (dt * stiffness + dashpots)
        } else {
            servo.speed * missing.signum()
        };
        boundary.walls[number].velocity[axis] = inward * free.clamp(-servo.speed, servo.speed);
    }
}
