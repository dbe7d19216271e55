//! Warnings on the setup of a case.

use colluvium_case::Case;
use colluvium_case::description::{Body, Boundary, Obstacle, ObstacleWall, Space, Wall};
use colluvium_constitutive::MaterialSpec;
use colluvium_constitutive::basal::BasalFlow;

use crate::config::{
    COURANT, InternalForceIntegration, ShapeFunctions, StepCriterion, VolumetricStrain, WallFriction,
};
use crate::obstacles::could_act_on_nodes;
use crate::setup::fall_time::{body_height, time_of_fall};
use crate::{FixedNodes, MpmOptions, ObstacleCoupling, StressScheme, VelocityTransfer};
use colluvium_case::Warning;

/// Largest Courant number for which stress last is stable with splines at open ends of the domain. 0.5 was unstable in two and three
/// dimensions, 0.45 marginally stable.
const OPEN_SIDE: f64 = 0.4;

/// Warnings for bodies at ends of the domain without a permanent wall, with steps that are unstable there.
fn open_side_warnings(case: &Case, options: &MpmOptions) -> Vec<Warning> {
    let spline = matches!(options.shape, ShapeFunctions::Quadratic | ShapeFunctions::Cubic);
    if !spline || options.stress_update != StressScheme::Usl || options.courant <= OPEN_SIDE {
        return Vec::new();
    }
    let last = case.active_boundaries(case.stages.len());
    let has_wall = |axis: usize, upper: bool| {
        last.iter().any(|(_, boundary)| {
            boundary.side.axis() == axis
                && boundary.side.is_max() == upper
                && boundary.position.is_none()
                && !matches!(boundary.wall, Wall::Absorbing { .. })
        })
    };
    let mut found = Vec::new();
    for (number, body) in case.bodies.iter().enumerate() {
        let (low, high) = body.shape.bounds(case.dimension());
        for axis in (0..case.dimension()).filter(|axis| !case.domain.is_periodic(*axis)) {
            let reach = 0.5 * options.cell_size;
            let lower = low[axis] - case.domain.min[axis] < reach
                && !(axis == 0 && case.space == Space::Axisymmetric);
            for (upper, reaches) in [(false, lower), (true, case.domain.max[axis] - high[axis] < reach)] {
                if reaches && !has_wall(axis, upper) {
                    let side = format!("{}-{}", ["x", "y", "z"][axis], if upper { "max" } else { "min" });
                    found.push(Warning::new(
                        "open-side-unstable",
                        format!(
                            "bodies[{number}]: reaches the side {side} of the domain, which has no permanent \
                         wall. There splines with usl are stable only up to a courant of {OPEN_SIDE}: make \
                         the domain a cell larger, or use musl"
                        ),
                    ));
                }
            }
        }
    }
    found
}

/// Warning for a search for a factor of safety in soil that locks in yielding.
fn locking_warning(case: &Case, options: &MpmOptions) -> Option<Warning> {
    let (name, _) = case.factors_of_safety().next()?;
    let free = if options.mesh.is_some() { "nodal" } else { "cell-average" };
    (options.volumetric_strain == VolumetricStrain::Point).then(|| {
        Warning::new("locking", format!(
            "measures.{name}: with methods.mpm.volumetric_strain `point`, soil of constant volume locks when \
             it yields, and slides slowly where it should fail. The factor is then too large, or undecided \
             (1.41 to 1.55 for 1.36 on 20 cells): use `{free}`"
        ))
    })
}

/// Least bulk modulus over `ρgH` for a stable liquid at rest. With linear functions on 16 cells 163 was stable, 92 was not.
const MIN_STIFFNESS_RATIO: f64 = 200.0;
/// Least bulk modulus over `ρgH` and the square of the cells over the depth, for linear functions: 1.56 was stable, 0.78 not, on 8, 16 and
/// 32 cells.
const MIN_STIFFNESS_RATIO_OF_CELLS: f64 = 1.6;

/// Most steps between outputs at which cut steps may amplify pressure waves: up to 7 were observed to.
const FEW_STEPS_TO_OUTPUT: f64 = 12.0;

/// Warning for liquids in which the shortening of steps at output times excites pressure waves; `dt` is the step (s).
fn cut_step_warning(case: &Case, dt: f64) -> Option<Warning> {
    let interval = case.output.measures.into_iter().chain(case.output.frames).reduce(f64::min)?;
    let (steps, liquid) = (interval / dt, |body: &&Body| {
        let spec = case.materials.get(&body.material);
        !body.rigid && matches!(spec, Some(MaterialSpec::NewtonianFluid(_)))
    });
    let whole = (steps - steps.round()).abs() < 1e-6 * steps;
    let body = case.bodies.iter().find(liquid)?;
    (steps > 1.0 && steps < FEW_STEPS_TO_OUTPUT && !whole).then(|| {
        Warning::new("output-excites-waves", format!(
            "output: steps of {dt:.2e} s are shortened at every output, each {interval} s ({steps:.1} steps). \
             This can make pressure waves in the liquid {} grow (by 4 to 10/s): use an interval of more than \
             {FEW_STEPS_TO_OUTPUT} steps, or a methods.mpm.time_step that divides it",
            body.name
        ))
    })
}

/// Warnings for liquids at rest in which disturbances grow.
fn liquid_at_rest_warnings(case: &Case, options: &MpmOptions) -> Vec<Warning> {
    let linear = options.shape == ShapeFunctions::Linear;
    if options.integration != InternalForceIntegration::Points
        || !(linear || options.shape == ShapeFunctions::Ugimp)
    {
        return Vec::new();
    }
    let shared = options.volumetric_strain != VolumetricStrain::Point;
    let gravity = case.gravity_magnitude();
    let mut found = Vec::new();
    for body in &case.bodies {
        let Some(MaterialSpec::NewtonianFluid(spec)) = case.materials.get(&body.material) else { continue };
        if body.rigid || gravity == 0.0 {
            continue;
        }
        let (weight, cells) =
            (spec.density * gravity * body_height(case, body), body_height(case, body) / options.cell_size);
        let enough = if options.stress_update == StressScheme::Usl {
            MIN_STIFFNESS_RATIO
        } else {
            0.5 * MIN_STIFFNESS_RATIO
        } * weight;
        let wanted = MIN_STIFFNESS_RATIO.max(MIN_STIFFNESS_RATIO_OF_CELLS * cells * cells) * weight;
        if shared && (linear || spec.bulk_modulus < enough) {
            found.push(Warning::new("liquid-unstable-at-rest", format!(
                "methods.mpm.volumetric_strain: in the liquid {} at rest, averages leave motions within cells \
                 without stiffness, and the pressure makes these motions grow, with musl and with usl. Use \
                 ugimp with a bulk modulus of {enough:.2e} Pa at least, point with ugimp, quadratic \
                 functions, or mixed integration",
                body.name
            )));
        } else if linear && spec.bulk_modulus < wanted {
            found.push(Warning::new("liquid-unstable-at-rest", format!(
                "methods.mpm.shape: in the liquid {} at rest, disturbances grow with linear functions if its \
                 bulk modulus is less than {:.0} ρgH ({wanted:.2e} Pa). Use at least that modulus, or ugimp, \
                 quadratic functions or mixed integration",
                body.name,
                wanted / weight
            )));
        }
    }
    found
}

/// Number of cells over the thickness of a flow at which a rough floor has about 90 % of its friction.
const MIN_CELLS_OVER_THICKNESS: f64 = 5.0;

/// Warns of sheets of soil that slide on rough floors with too little friction.
fn thin_sheet_warning(case: &Case, options: &MpmOptions) -> Vec<Warning> {
    if options.fixed_nodes != FixedNodes::Force || case.stages.iter().all(|stage| stage.equilibrium.is_some())
    {
        return Vec::new();
    }
    let rubs = |body: &Body| {
        let law = case.materials.get(&body.material).and_then(|spec| spec.basal().ok());
        let under = |normal_stress: f64| BasalFlow {
            depth: 1.0,
            speed: 0.0,
            normal_stress,
            pore_pressure: 0.0,
            slope: 0.0,
            unit_weight: 1.0,
        };
        law.is_some_and(|law| law.static_shear_strength(&under(2.0)) > law.static_shear_strength(&under(1.0)))
    };
    let mut found = Vec::new();
    for (wall, boundary) in case.boundaries.iter().enumerate().filter(|(_, one)| one.wall == Wall::Rough) {
        let (axis, upper) = (boundary.side.axis(), boundary.side.is_max());
        let domain = if upper { &case.domain.max } else { &case.domain.min };
        let place = boundary.position.unwrap_or(domain[axis]);
        let weighs = if upper { case.gravity[axis] > 0.0 } else { case.gravity[axis] < 0.0 };
        for body in case.bodies.iter().filter(|body| weighs && !body.rigid && rubs(body)) {
            let (low, high) = body.shape.bounds(case.dimension());
            let reach = if upper { place - high[axis] } else { low[axis] - place };
            let cells = (high[axis] - low[axis]) / options.cell_size;
            if reach.abs() < 0.5 * options.cell_size && cells < MIN_CELLS_OVER_THICKNESS {
                found.push(Warning::new("few-cells-over-height", format!(
                    "boundaries[{wall}]: the friction of a rough floor follows from the mean stress of the \
                     cell on it, and {} is {cells:.1} cells thick. Its friction is {:.0} % too small where it \
                     slides: use a `frictional` wall with the sine of the friction angle, or smaller cells",
                    body.name,
                    50.0 / cells.max(0.5)
                )));
            }
        }
    }
    found
}

/// Most steps in the time of a fall through the height of a body at which XPIC does not affect the flow.
const MAX_STEPS_OF_FALL: f64 = 50.0;

/// Warning for XPIC that removes all null-space velocities in each of many steps; `dt` is the step (s).
fn xpic_filter_warning(case: &Case, options: &MpmOptions, dt: f64) -> Option<Warning> {
    let time = time_of_fall(case)?;
    let often = options.transfer == VelocityTransfer::Xpic
        && options.residual_time.is_none()
        && dt * MAX_STEPS_OF_FALL < time;
    often.then(|| {
        Warning::new("xpic-removes-motion", format!(
            "methods.mpm.transfer: xpic removes the motion that the grid does not represent in each step, \
             {:.0} times while the bodies fall by their height. This also removes nearly all of the motion \
             within cells: set residual_time, for example to {time:.2} s",
            time / dt
        ))
    })
}

/// Warning for round bodies on obstacles or walls with friction at nodes, where they do not roll.
fn round_body_warning(case: &Case, options: &MpmOptions) -> Option<Warning> {
    let obstacle = |obstacle: &Obstacle| obstacle.wall != ObstacleWall::Smooth;
    let wall = |boundary: &Boundary| matches!(boundary.wall, Wall::Rough | Wall::Frictional { .. });
    let on_nodes = options.obstacles == ObstacleCoupling::Nodes && case.obstacles.iter().any(obstacle);
    if !on_nodes && !case.boundaries.iter().any(wall) {
        return None;
    }
    let is_liquid = |name: &String| matches!(case.materials.get(name), Some(MaterialSpec::NewtonianFluid(_)));
    let rolls = |body: &Body| !body.rigid && body.shape.has_round_edges() && !is_liquid(&body.material);
    let number = case.bodies.iter().position(rolls)?;
    Some(Warning::new(
        "round-body-on-nodes",
        format!(
            "bodies[{number}]: {} is round. Wall nodes constrain all of the material within a cell, so that the \
         body hardly rolls: use an obstacle, and methods.mpm.obstacles points",
            case.bodies[number].name
        ),
    ))
}

/// Share of the extent of a body by which a wall may move without a warning.
const MAX_WALL_TRAVEL: f64 = 0.02;

/// Warnings for walls that move towards or away from a body: their nodes have the velocity, but their plane does not move.
fn moving_wall_warnings(case: &Case) -> Vec<Warning> {
    let mut found = Vec::new();
    for (number, (boundary, time)) in case.boundaries.iter().zip(case.boundary_durations()).enumerate() {
        let axis = boundary.side.axis();
        let normal = boundary.velocity.as_ref().and_then(|velocity| velocity.get(axis));
        let travel = normal.map_or(0.0, |speed| speed.abs() * time);
        let extent = |body: &Body| {
            let (low, high) = body.shape.bounds(case.dimension());
            high[axis] - low[axis]
        };
        let shortest = case.bodies.iter().map(extent).fold(f64::INFINITY, f64::min);
        if travel > MAX_WALL_TRAVEL * shortest {
            found.push(Warning::new(
                "wall-plane-fixed",
                format!(
                    "boundaries[{number}].velocity: the plane of the wall stays in place while its nodes move the \
                     material by {travel:.3e} m. Strains next to it are then wrong by up to {:.1} % of their value: use a \
                     patch with a prescribed motion, or method sph, whose walls move",
                    50.0 * travel / shortest
                ),
            ));
        }
    }
    found
}

/// Returns the warnings on a case; `courant` is the Courant number of its first step, of `dt` (s).
pub(super) fn warnings(
    case: &Case,
    options: &MpmOptions,
    (courant, dt): (f64, f64),
    points: usize,
) -> Vec<Warning> {
    let mut warnings = case.warnings();
    warnings.extend(locking_warning(case, options));
    warnings.extend(points_per_cell_warning(case, options));
    if options.shape == ShapeFunctions::Linear && points > 0 {
        warnings.push(Warning::new(
            "mesh-crossing",
            "methods.mpm.shape: linear shape functions make noise when points cross cells; refining the \
             grid makes it worse. Use ugimp, cpgimp, cpdi or quadratic, unless points stay in their cells",
        ));
    }
    warnings.extend(small_mass_warning(case, options, courant));
    warnings.extend(liquid_at_rest_warnings(case, options));
    warnings.extend(cut_step_warning(case, dt));
    warnings.extend(thin_sheet_warning(case, options));
    warnings.extend(xpic_filter_warning(case, options, dt));
    warnings.extend(round_body_warning(case, options));
    warnings.extend(obstacle_coupling_warning(case, options));
    warnings.extend(rigid_bodies_warning(case));
    warnings.extend(moving_wall_warnings(case));
    warnings.extend(step_warnings(case, options));
    warnings.extend(open_side_warnings(case, options));
    let slides = |boundary: &Boundary| matches!(boundary.wall, Wall::Frictional { .. });
    if options.wall_friction != WallFriction::default() && !case.boundaries.iter().any(slides) {
        warnings.push(Warning::new(
            "option-without-effect",
            "methods.mpm.wall_friction: has no effect, no wall is frictional. Leave it out, or \
                       make a wall frictional",
        ));
    }
    for number in 0..case.stages.len() {
        warnings.extend(stage_warnings(case, options, number));
    }
    warnings
}

/// Warns of too few points per cell.
fn points_per_cell_warning(case: &Case, options: &MpmOptions) -> Option<Warning> {
    let dimension = case.dimension() as u32;
    let wanted = if dimension == 3 { 8 } else { 2usize.pow(dimension) };
    let per_cell = options.points_per_cell.pow(dimension);
    (per_cell < wanted).then(|| {
        Warning::new("under-sampled", format!(
            "methods.mpm.points_per_cell: {per_cell} points per cell; fewer than {wanted} under-sample the \
             grid. Give 2 or more, the number per direction"
        ))
    })
}

/// Warns of forces on nodes of small mass that can invert points.
fn small_mass_warning(case: &Case, options: &MpmOptions, courant: f64) -> Option<Warning> {
    let needed = 0.5 * courant * courant;
    let wet = case.bodies.iter().any(|body| body.pore_fluid.is_some());
    let cutoff = options.node_mass_cutoff.unwrap_or(if wet { 0.0 } else { 1.0 });
    (options.has_unbounded_small_node_strain() && cutoff < 0.99 * needed).then(|| {
        Warning::new("small-node-mass", format!(
            "methods.mpm.stress_update: usl with linear shape functions (also dual-domain) can invert points \
             at free surfaces; use musl, ugimp, or a node_mass_cutoff of {needed:.2e}, half the square of the \
             Courant number of the step"
        ))
    })
}

/// Warns of obstacles on the points of saturated bodies that nodes could represent exactly.
fn obstacle_coupling_warning(case: &Case, options: &MpmOptions) -> Option<Warning> {
    could_act_on_nodes(case, options).then(|| {
        Warning::new(
            "obstacle-loses-pressure",
            "methods.mpm.obstacles: with points, stress and pore pressure in the cells at an obstacle are a \
         quarter too small, because points exert their pressure at their centres. With GIMP and CPDI the \
         pressure of the row of points at the obstacle is lost within seconds. These obstacles lie on \
         nodes: use nodes, which is exact there",
        )
    })
}

/// Warning for free rigid bodies, which can pass through other rigid bodies.
fn rigid_bodies_warning(case: &Case) -> Option<Warning> {
    let mut rigid = case.bodies.iter().filter(|body| body.rigid);
    let count = rigid.clone().count();
    let free = rigid.find(|body| case.moves_freely(&body.name)).filter(|_| count > 1)?;
    Some(Warning::new(
        "rigid-bodies-pass",
        format!(
            "bodies: rigid bodies do not act on each other: {:?} passes through the others. Use a wall, or \
         make one of two bodies deformable",
            free.name
        ),
    ))
}

/// Warns of time steps that are not stable.
fn step_warnings(case: &Case, options: &MpmOptions) -> Vec<Warning> {
    let mut warnings = Vec::new();
    if options.step_criterion == StepCriterion::Simple {
        warnings.push(Warning::new(
            "unstable-step-criterion",
            "methods.mpm.step_criterion: with simple, steps may be longer than the drag and the fast wave of \
             both phases allow: use combined",
        ));
    }
    let stable = options.surface_courant(case.dimension());
    // Without an entry the default is the largest stable value.
    if options.courant > stable.max(COURANT) {
        warnings.push(Warning::new(
            "courant-limited",
            format!(
                "methods.mpm.courant: with usl and this shape, more than {stable:.3} is not stable at free \
             surfaces; steps are limited to that. Give at most that, or use musl"
            ),
        ));
    }
    warnings
}

/// Warns of options that change real motion or its time in a stage.
fn stage_warnings(case: &Case, options: &MpmOptions, number: usize) -> Vec<Warning> {
    let stage = &case.stages[number];
    let ends_at_rest = stage.equilibrium.is_some();
    let wet = case.bodies.iter().any(|body| body.pore_fluid.is_some());
    let mut warnings = Vec::new();
    if options.mass_scaling > 1.0 && !ends_at_rest {
        warnings.push(Warning::new(
            "option-slows-motion",
            format!(
                "methods.mpm.mass_scaling: slows the motion of stages[{number}], which has no `equilibrium`; \
             it is for quasi-static stages. Give that stage `equilibrium`, or leave the option out"
            ),
        ));
    }
    if options.integration == InternalForceIntegration::Gauss && !ends_at_rest {
        warnings.push(Warning::new("gauss-in-motion", format!(
            "methods.mpm.integration: with gauss, partly filled cells contribute to the internal force as \
             if they were full; stages[{number}] has no `equilibrium`, and it is for quasi-static stages. \
             Use points or mixed"
        )));
    }
    if wet && options.mass_scaling > 1.0 && ends_at_rest {
        warnings.push(Warning::new("option-slows-motion", format!(
            "stages[{number}]: mass scaling slows consolidation: the state at rest is correct, the time to \
             reach it is not. Leave methods.mpm.mass_scaling out where times matter"
        )));
    }
    if stage.damping > 0.0 && !ends_at_rest {
        warnings.push(Warning::new(
            "option-slows-motion",
            format!(
                "stages[{number}].damping: local damping in a stage without `equilibrium` also slows real \
             motion. Leave it out where the motion matters"
            ),
        ));
    }
    warnings
}
