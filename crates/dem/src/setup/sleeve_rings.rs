//! Rings of grains around a cylinder: the sleeve of a triaxial test.

use std::f64::consts::PI;

use colluvium_points::Shape;

use crate::config::Diameters;

/// Relative tolerance of lengths that should be equal.
const EQUAL_TOLERANCE: f64 = 1e-9;

/// Tube between two cylinders with the same axis.
struct Tube {
    axis: usize,
    base_centre: [f64; 3],
    height: f64,
    /// Inner and outer radius (m).
    radii: [f64; 2],
}

/// Tube of a shape, if it is one.
fn tube(shape: &Shape) -> Option<Tube> {
    let Shape::Difference { from, cut } = shape else { return None };
    let (
        Shape::Cylinder { base, axis, radius: outer, height },
        Shape::Cylinder { base: below, axis: along, radius: inner, height: cut },
    ) = (&**from, &**cut)
    else {
        return None;
    };
    let near = |a: f64, b: f64| (a - b).abs() <= EQUAL_TOLERANCE * outer;
    let one_axis = axis == along && (0..3).all(|c| c == *axis || near(base[c], below[c]));
    let through = below[*axis] <= base[*axis] + EQUAL_TOLERANCE * outer
        && below[*axis] + cut >= base[*axis] + height - EQUAL_TOLERANCE * outer;
    let is_tube = one_axis && through && inner < outer;
    is_tube.then_some(Tube { axis: *axis, base_centre: *base, height: *height, radii: [*inner, *outer] })
}

/// Number of rings of a tube, at about the spacing of the grains of a ring, and at least two.
fn rows(height: f64, chord: f64) -> usize {
    ((height / chord).round() as usize).max(2)
}

/// Centres of rings of `columns` grains each, one ring above another from the base of the tube, in contact with its inner surface.
pub(super) fn rings<const D: usize>(
    shape: &Shape,
    sizes: &Diameters,
    columns: usize,
) -> Result<Vec<([f64; D], f64)>, String> {
    let tube = tube(shape).filter(|_| D == 3).ok_or(
        "a sleeve must be the difference of two cylinders in 3d about the same axis, and the cut must \
         extend over the height of the other one",
    )?;
    let (smallest, diameter) = sizes.range();
    if smallest < diameter {
        return Err("the grains of a sleeve must have one size: give their diameter as equal".to_owned());
    }
    let [inner, outer] = tube.radii;
    if diameter > (outer - inner) * (1.0 + EQUAL_TOLERANCE) {
        return Err(format!(
            "the diameter of the grains, {diameter} m, is larger than the thickness of the tube, {} m",
            outer - inner
        ));
    }
    let radius = inner + 0.5 * diameter;
    let chord = 2.0 * radius * (PI / columns as f64).sin();
    let rows = rows(tube.height, chord);
    let pitch = tube.height / rows as f64;
    if chord.min(pitch) < diameter * (1.0 - EQUAL_TOLERANCE) {
        let largest = (PI / (0.5 * diameter / radius).asin()).floor();
        return Err(format!(
            "{columns} grains of {diameter} m do not fit into a ring of the sleeve, or {rows} rings do not \
             fit into its height: use at most {largest} columns"
        ));
    }
    let (a, b) = ((tube.axis + 1) % 3, (tube.axis + 2) % 3);
    let place = |number: usize| {
        let (row, column) = (number / columns, number % columns);
        let (sin, cos) = (2.0 * PI * column as f64 / columns as f64).sin_cos();
        let mut x = tube.base_centre;
        x[a] += radius * cos;
        x[b] += radius * sin;
        x[tube.axis] += pitch * (row as f64 + 0.5);
        (std::array::from_fn(|c| x[c]), 0.5 * diameter)
    };
    Ok((0..rows * columns).map(place).collect())
}

/// Approximate number of grains of the rings.
pub(super) fn count(shape: &Shape, sizes: &Diameters, columns: usize) -> f64 {
    let Some(tube) = tube(shape) else { return 0.0 };
    let radius = tube.radii[0] + 0.5 * sizes.range().1;
    (rows(tube.height, 2.0 * radius * (PI / columns as f64).sin()) * columns) as f64
}
