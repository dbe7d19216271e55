//! Requirements on a saw test (sheet: snow-mpm §7, row PST).
//!
//! A cut is the saw of a saw test where it removes a body of a law that softens as a weak layer and leaves a slab above it: both boxes,
//! or polygons with two sides along the direction of the saw, or layers along one track. For other cuts the same requirements give
//! warnings, from the bounds of the removed and remaining material.

use colluvium_case::Warning;
use colluvium_case::description::{Body, RemovalShape};
use colluvium_case::{Case, CaseError};
use colluvium_constitutive::laws::{CamClayHardening, CohesiveCamClaySpec};
use colluvium_constitutive::{InitialCondition, MaterialSpec, SymTensor};
use colluvium_points::Shape;

/// Least length of a column over the thickness of its slab.
const MIN_COLUMN_LENGTH: f64 = 5.0;
/// Upper bound of the speed of a saw over that of shear waves in the slab.
const HIGHEST_SPEED: f64 = 0.05;
/// Least share of the length of the weak layer above which a body is part of the slab.
const MIN_COVERAGE: f64 = 0.5;
/// Relative tolerance for round-off.
const ROUND_OFF: f64 = 1e-9;

/// Initial strength (Pa) of a law that softens as a weak layer; none for other laws.
pub(crate) fn strength_of_weak_layer(spec: &MaterialSpec) -> Option<f64> {
    match (spec, spec.inner()) {
        (_, Some(inner)) => strength_of_weak_layer(inner),
        (MaterialSpec::CohesiveCamClay(law), None) => {
            matches!(law.hardening, CamClayHardening::WeakLayer { .. }).then_some(law.compressive_strength)
        }
        _ => None,
    }
}

/// Layer in the axes of a saw test: ends along it, and from its lower to its upper side (m).
struct SawLayer {
    length_range: [f64; 2],
    height_range: [f64; 2],
}

/// Direction of a saw, axis across which its slab weighs on the weak layer, and sign of the upward direction along it.
#[derive(Clone, Copy)]
struct SawAxes {
    cut_axis: usize,
    normal_axis: usize,
    upward_sign: f64,
}

/// Column of a saw test.
struct SawColumn<'a> {
    /// Weak layer.
    weak_layer: (&'a Body, SawLayer),
    /// Bodies above the weak layer.
    slab: Vec<(&'a Body, SawLayer)>,
    /// Axes of the cut; none where its direction is along no axis.
    axes: Option<SawAxes>,
}

impl<'a> SawColumn<'a> {
    /// Column that a cut saws: a weak layer and the slab above it; none where it saws none, or the shapes are of other kinds.
    fn of_removal(case: &'a Case, cut: &RemovalShape) -> Option<Self> {
        let axes = SawAxes::of_removal(case, cut);
        let weak = |body: &&Body| cut.applies_to(&body.name) && is_weak(case, body);
        let body = case.bodies.iter().find(weak)?;
        let own = layer(&body.shape, &body.shape, axes)?;
        let (length, top) = (own.length_range[1] - own.length_range[0], own.height_range[1]);
        let lies_on = |of: &SawLayer| {
            let shared =
                of.length_range[1].min(own.length_range[1]) - of.length_range[0].max(own.length_range[0]);
            of.height_range[0] >= top - ROUND_OFF * length && shared >= MIN_COVERAGE * length
        };
        let left = case.bodies.iter().filter(|body| !cut.applies_to(&body.name));
        let left = left.filter_map(|of| Some((of, layer(&of.shape, &body.shape, axes)?)));
        let slab: Vec<_> = left.filter(|(_, of)| lies_on(of)).collect();
        (!slab.is_empty()).then_some(Self { weak_layer: (body, own), slab, axes })
    }

    /// Length of the weak layer (m).
    fn length(&self) -> f64 {
        self.weak_layer.1.length_range[1] - self.weak_layer.1.length_range[0]
    }

    /// Thickness of the slab (m).
    fn thickness(&self) -> f64 {
        let top = self.slab.iter().map(|(_, layer)| layer.height_range[1]).fold(f64::NEG_INFINITY, f64::max);
        top - self.weak_layer.1.height_range[1]
    }
}

impl SawAxes {
    fn of_removal(case: &Case, cut: &RemovalShape) -> Option<Self> {
        let dimension = case.dimension();
        let cut_axis = (0..dimension).find(|&axis| cut.velocity[axis].abs() == cut.speed())?;
        let gravity = case.gravity3();
        let others = (0..dimension).filter(|axis| *axis != cut_axis);
        let normal_axis = others.reduce(|a, b| if gravity[b].abs() > gravity[a].abs() { b } else { a })?;
        Some(Self { cut_axis, normal_axis, upward_sign: if gravity[normal_axis] > 0.0 { -1.0 } else { 1.0 } })
    }
}

/// Shape as a layer along the axes of a saw, or along the track of the layer below it.
fn layer(shape: &Shape, below: &Shape, axes: Option<SawAxes>) -> Option<SawLayer> {
    match (shape, below) {
        (Shape::ArcLayer { on, start, end, from, to, .. }, Shape::ArcLayer { on: same, .. }) => {
            (on == same).then_some(SawLayer { length_range: [*start, *end], height_range: [*from, *to] })
        }
        (Shape::Box { min, max }, Shape::Box { .. } | Shape::Polygon { .. }) => {
            let SawAxes { cut_axis, normal_axis, upward_sign } = axes?;
            Some(SawLayer {
                length_range: [min[cut_axis], max[cut_axis]],
                height_range: ordered(upward_sign * min[normal_axis], upward_sign * max[normal_axis]),
            })
        }
        (Shape::Polygon { vertices }, Shape::Box { .. } | Shape::Polygon { .. }) => {
            oblique_layer(vertices, axes?)
        }
        _ => None,
    }
}

fn ordered(a: f64, b: f64) -> [f64; 2] {
    [a.min(b), a.max(b)]
}

/// Polygon between two lines along the direction of a saw, as a layer that ends in the middle of its oblique ends; none for another
/// polygon.
fn oblique_layer(
    vertices: &[[f64; 2]],
    SawAxes { cut_axis, normal_axis, upward_sign }: SawAxes,
) -> Option<SawLayer> {
    let range = |places: &mut dyn Iterator<Item = f64>| {
        places.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    };
    let [low, high] = range(&mut vertices.iter().map(|vertex| vertex[normal_axis]));
    let slack = ROUND_OFF * (high - low);
    let on = |side: f64| {
        range(&mut vertices.iter().filter(|v| (v[normal_axis] - side).abs() <= slack).map(|v| v[cut_axis]))
    };
    let of_two = vertices.iter().all(|v| v[normal_axis] - low <= slack || high - v[normal_axis] <= slack);
    let (lower, upper) = (on(low), on(high));
    let ends = std::array::from_fn(|end| 0.5 * (lower[end] + upper[end]));
    of_two.then_some(SawLayer {
        length_range: ends,
        height_range: ordered(upward_sign * low, upward_sign * high),
    })
}

/// Rejects invalid saw tests (sheet: snow-mpm §7): a column shorter than five times its slab, a saw faster than a twentieth of the shear
/// waves, a layer that does not carry its slab.
///
/// # Errors
/// With the path of the cut or of the strength, and a remedy.
pub(crate) fn check_saw_tests(case: &Case) -> Result<(), CaseError> {
    for (number, cut) in case.removal_shapes.iter().enumerate() {
        let Some(column) = SawColumn::of_removal(case, cut) else { continue };
        let slab = column.slab.iter().map(|(body, _)| *body);
        if let Some(waves) = fastest_waves(case, slab).filter(|waves| is_too_fast(cut, *waves)) {
            let problem = format!(
                "{} m/s is above a twentieth of the speed of shear waves in the slab ({waves:.1} m/s), so \
                 that the crack depends on the speed of the cut: saw with {} m/s or less",
                cut.speed(),
                rounded_down(HIGHEST_SPEED * waves)
            );
            return Err(CaseError::new(format!("removal_shapes[{number}].velocity"), problem));
        }
        let (length, smallest) = (column.length(), MIN_COLUMN_LENGTH * column.thickness());
        if length < smallest * (1.0 - ROUND_OFF) {
            let problem = format!(
                "the cut column is {length:.4} m long, less than five times the thickness of its slab ({:.4} \
                 m), so that its far end affects the crack: make it {smallest:.4} m long or longer",
                column.thickness()
            );
            return Err(CaseError::new(format!("removal_shapes[{number}]"), problem));
        }
        check_layer_strength(case, &column)?;
    }
    Ok(())
}

/// Positive number, rounded down to three digits.
fn rounded_down(x: f64) -> f64 {
    let scale = 10f64.powi(2 - x.log10().floor() as i32);
    (scale * x).floor() / scale
}

fn is_too_fast(cut: &RemovalShape, waves: f64) -> bool {
    cut.speed() > HIGHEST_SPEED * waves * (1.0 + ROUND_OFF)
}

/// Rejects a weak layer that yields under its slab at rest: at its lower side, far from the ends, where all strain is across the layer.
/// Along a track the weight changes with its slope: the run checks it (see [`sawn_layer`]).
fn check_layer_strength(case: &Case, column: &SawColumn<'_>) -> Result<(), CaseError> {
    let ((body, own), Some(axes)) = (&column.weak_layer, column.axes) else { return Ok(()) };
    let spec = &case.materials[&body.material];
    let (false, MaterialSpec::CohesiveCamClay(law)) = (matches!(body.shape, Shape::ArcLayer { .. }), spec)
    else {
        return Ok(());
    };
    let mass = |(body, of): &(&Body, SawLayer)| {
        case.materials[&body.material].density() * (of.height_range[1] - of.height_range[0])
    };
    let mass = column.slab.iter().map(mass).sum::<f64>()
        + spec.density() * (own.height_range[1] - own.height_range[0]);
    let gravity = case.gravity3();
    let (pressure, shear) = (mass * gravity[axes.normal_axis].abs(), mass * gravity[axes.cut_axis]);
    let side = -law.poissons_ratio / (1.0 - law.poissons_ratio) * pressure;
    // Across the layer, along it and sideways: not in the axes of the case.
    let stress = SymTensor([-pressure, side, side, shear, 0.0, 0.0]);
    let strict = MaterialSpec::CohesiveCamClay(CohesiveCamClaySpec {
        return_initial_stress_to_yield: false,
        ..law.clone()
    });
    let Ok(material) = strict.build() else { return Ok(()) };
    if material.initial(&[InitialCondition { stress, density: spec.density() }]).is_ok() {
        return Ok(());
    }
    let problem = format!(
        "a layer of {} Pa yields at rest under its slab (pressure {pressure:.0} Pa, shear stress {:.0} Pa), \
         before the saw begins: make the layer stronger, or the slab lighter",
        law.compressive_strength,
        shear.abs()
    );
    Err(CaseError::new(format!("materials.{}.compressive_strength", body.material), problem))
}

/// Whether a body has the law of weak layers.
pub(crate) fn is_weak(case: &Case, body: &Body) -> bool {
    strength_of_weak_layer(&case.materials[&body.material]).is_some()
}

/// Name of the weak layer of a saw test with this cut; `None` for other cuts.
pub(crate) fn sawn_layer<'a>(case: &'a Case, cut: &RemovalShape) -> Option<&'a str> {
    Some(&SawColumn::of_removal(case, cut)?.weak_layer.0.name)
}

/// Speed of the fastest shear waves (m/s) in bodies whose law has a Young's modulus and a Poisson's ratio.
fn fastest_waves<'a>(case: &Case, bodies: impl Iterator<Item = &'a Body>) -> Option<f64> {
    bodies.filter_map(|body| shear_speed(&case.materials[&body.material])).reduce(f64::max)
}

/// Speed of shear waves (m/s).
fn shear_speed(spec: &MaterialSpec) -> Option<f64> {
    let (youngs, poissons) = elastic_constants(spec)?;
    Some((youngs / (2.0 * (1.0 + poissons)) / spec.density()).sqrt())
}

/// Young's modulus (Pa) and Poisson's ratio of the laws of snow, ice and ground.
pub(crate) fn elastic_constants(spec: &MaterialSpec) -> Option<(f64, f64)> {
    Some(match spec {
        MaterialSpec::LinearElastic(law) => (law.youngs_modulus, law.poissons_ratio),
        MaterialSpec::StVenantKirchhoff(law) => (law.youngs_modulus, law.poissons_ratio),
        MaterialSpec::FixedCorotated(law) => (law.youngs_modulus, law.poissons_ratio),
        MaterialSpec::NeoHookean(law) => (law.youngs_modulus, law.poissons_ratio),
        MaterialSpec::CohesiveCamClay(law) => (law.youngs_modulus, law.poissons_ratio),
        MaterialSpec::DruckerPrager(law) => (law.youngs_modulus, law.poissons_ratio),
        MaterialSpec::Snow(law) => (law.youngs_modulus, law.poissons_ratio),
        MaterialSpec::Sand(law) => (law.youngs_modulus, law.poissons_ratio),
        _ => return elastic_constants(spec.inner()?),
    })
}

/// Warnings of cuts: of saw tests that begin with the run; of other cuts, or of a column with shapes of other kinds, where the
/// requirements on saw tests are not fulfilled.
pub(crate) fn warnings(case: &Case) -> Vec<Warning> {
    let mut warnings = Vec::new();
    for (number, cut) in case.removal_shapes.iter().enumerate() {
        if SawColumn::of_removal(case, cut).is_some() {
            let first = cut.stage.as_ref().is_none_or(|stage| *stage == case.stages[0].name);
            // Sheet: snow-mpm P25.
            if first && cut.start == 0.0 {
                warnings.push(Warning::new("cut-before-rest", format!(
                    "removal_shapes[{number}]: begins with the run, before the layer carries the weight of \
                     the slab: let the slab settle first, in a stage with gravity_ramp and damping"
                )));
            }
            continue;
        }
        if case.bodies.len() > 1
            && case.bodies.iter().all(|body| cut.applies_to(&body.name))
            && case.bodies.iter().any(|body| is_weak(case, body))
        {
            warnings.push(Warning::new("cut-removes-slab", format!(
                "removal_shapes[{number}]: removes all bodies, also those above the weak layer. For a saw \
                 test set its `bodies` to the weak layer alone"
            )));
            continue;
        }
        let left = case.bodies.iter().filter(|body| !cut.applies_to(&body.name));
        if let Some(waves) = fastest_waves(case, left).filter(|waves| is_too_fast(cut, *waves)) {
            warnings.push(Warning::new(
                "fast-cut",
                format!(
                    "removal_shapes[{number}].velocity: {} m/s is above a twentieth of the speed of shear \
                 waves in the remaining material ({waves:.1} m/s): the crack depends on the speed of the \
                 cut. Saw with {} m/s or less",
                    cut.speed(),
                    rounded_down(HIGHEST_SPEED * waves)
                ),
            ));
        }
        if let Some([length, thickness]) = extents(case, cut)
            && length < MIN_COLUMN_LENGTH * thickness * (1.0 - ROUND_OFF)
        {
            warnings.push(Warning::new(
                "short-column",
                format!(
                    "removal_shapes[{number}]: the cut material is {length} m long, less than five times the \
                 thickness of the remaining material ({thickness:.3} m): its far end affects the crack. \
                 Make the column longer"
                ),
            ));
        }
    }
    warnings
}

/// Extent of the removed bodies along the direction of a cut, and of the remaining bodies across it (m), by the bounds of their shapes.
fn extents(case: &Case, cut: &RemovalShape) -> Option<[f64; 2]> {
    let dimension = case.dimension();
    let SawAxes { cut_axis, normal_axis, .. } = SawAxes::of_removal(case, cut)?;
    let (sawn, left): (Vec<&Body>, Vec<&Body>) =
        case.bodies.iter().partition(|body| cut.applies_to(&body.name));
    if sawn.is_empty() || left.is_empty() {
        return None;
    }
    let extent = |bodies: &[&Body], axis: usize| {
        let ends = bodies.iter().map(|body| body.shape.bounds(dimension));
        let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (from, to)| {
            (low.min(from[axis]), high.max(to[axis]))
        });
        high - low
    };
    Some([extent(&sawn, cut_axis), extent(&left, normal_axis)])
}
