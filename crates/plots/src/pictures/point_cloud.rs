//! Clouds of points coloured by a value.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::charts::axis_ticks::{AxisDirection, LETTERS, Ticks};
use crate::charts::plane_axes::{plane, scale};
use crate::{FONT, Picture, clip_line, label, range};
use colluvium_case::{Field, FieldData, Snapshot};
use colluvium_constitutive::SymTensor;

/// Points at their positions, as squares or disks of their size, coloured by a value.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointCloud {
    /// Title above the picture.
    pub title: String,
    /// Position, full widths (m) and value of each point; values that are not finite are grey.
    pub points: Vec<([f64; 2], [f64; 2], f64)>,
    /// Whether points are drawn as disks, for grains.
    pub is_round: bool,
    /// Label of the colour scale: quantity with unit.
    pub label: String,
    /// Labels of the two axes.
    pub axes: [String; 2],
    /// Rigid geometry behind the points, as lines (m).
    pub lines: Vec<Vec<[f64; 2]>>,
    /// Scales in common with other pictures; `None` for scales of this picture alone.
    pub shared_scales: Option<CommonScales>,
}

/// Common scales of pictures that are to be compared.
#[derive(Clone, Debug, PartialEq)]
pub struct CommonScales {
    /// Values of the first and of the last colour. Values beyond them have the nearer of these colours.
    pub values: Range<f64>,
    /// Ranges of the picture along the two axes (m).
    pub window: [Range<f64>; 2],
}

impl CommonScales {
    /// Share of the points whose values the colour scale covers, so that single flying points do not stretch it.
    const COLOURED_FRACTION: f64 = 0.998;

    /// Common scales of several clouds.
    pub fn of_clouds<'a>(clouds: impl Iterator<Item = &'a PointCloud> + Clone) -> Self {
        let mut values: Vec<f64> = clouds.clone().flat_map(|cloud| &cloud.points).map(|p| p.2).collect();
        values.retain(|value| value.is_finite());
        values.sort_by(f64::total_cmp);
        let shown = (Self::COLOURED_FRACTION * values.len() as f64).ceil() as usize;
        let ends = clouds.map(PointCloud::bounds);
        let nothing = [f64::INFINITY..f64::NEG_INFINITY, f64::INFINITY..f64::NEG_INFINITY];
        let join = |a: Range<f64>, b: &Range<f64>| a.start.min(b.start)..a.end.max(b.end);
        let window = ends.fold(nothing, |[x, y], [a, b]| [join(x, &a), join(y, &b)]);
        Self {
            values: range(values.into_iter().take(shown), 0.0),
            window: window.map(|r| if r.start < r.end { r } else { 0.0..1.0 }),
        }
    }
}

/// Width of a picture (pixels).
const WIDTH: u32 = 900;

/// Drawn width of points without a width (pixels).
const DEFAULT_WIDTH: f64 = 4.0;

/// Name of the field of the radii of grains.
pub(crate) const RADIUS: &str = "radius";

/// Number of corners of the polygon of a disk.
const CORNERS: u32 = 20;

/// Colour of rigid geometry.
pub(crate) const EARTH: RGBColor = RGBColor(122, 92, 58);

impl PointCloud {
    /// Point cloud from a snapshot, projected to `plane` and coloured by the field `name`, or by a component of it: `velocity.x`,
    /// `stress.xy`, `stress.q`. Without a component vectors are coloured by their length and tensors by their mean pressure `-tr/3`;
    /// points with a radius are disks.
    pub fn from_snapshot(snapshot: &Snapshot, name: &str, plane: [usize; 2]) -> Option<Self> {
        let (field, values, quantity) = field_values(snapshot, name)?;
        let at = |v: &[f64; 3]| [v[plane[0]], v[plane[1]]];
        let points = snapshot.positions.iter().zip(&snapshot.extents).zip(values);
        let unit = if field.unit.is_empty() { String::new() } else { format!(" ({})", field.unit) };
        let axis = |c: usize| format!("{} (m)", ["x", "y", "z"][c]);
        Some(Self {
            title: format!("{}, t = {} s", name.replace('_', " "), label(&snapshot.time)),
            points: points.map(|((x, e), v)| (at(x), at(e), v)).collect(),
            is_round: snapshot.field(RADIUS).is_some(),
            label: format!("{}{unit}", quantity.replace('_', " ")),
            axes: [axis(plane[0]), axis(plane[1])],
            lines: Vec::new(),
            shared_scales: None,
        })
    }

    /// Ranges of the picture along the two axes (m).
    fn bounds(&self) -> [Range<f64>; 2] {
        if let Some(shared) = &self.shared_scales {
            return shared.window.clone();
        }
        let along = |c: usize| {
            let ends = |p: &([f64; 2], [f64; 2], f64)| [p.0[c] - 0.5 * p.1[c], p.0[c] + 0.5 * p.1[c]];
            range(self.points.iter().flat_map(ends), 0.04)
        };
        [along(0), along(1)]
    }
}

/// Names of the components of vectors, and of tensors in the order of their components.
const VECTOR_COMPONENTS: [&str; 3] = ["x", "y", "z"];
const TENSOR_COMPONENTS: [&str; 6] = ["xx", "yy", "zz", "xy", "yz", "xz"];

/// Field `name` of a snapshot, or the one of a component `field.component`, with its values and the name of the quantity.
fn field_values<'a>(snapshot: &'a Snapshot, name: &str) -> Option<(&'a Field, Vec<f64>, String)> {
    if let Some(field) = snapshot.field(name) {
        let is_tensor = matches!(field.data, FieldData::Tensor(_));
        let quantity = if is_tensor { format!("{name}, mean pressure -tr/3") } else { name.to_owned() };
        return Some((field, values(field), quantity));
    }
    let (whole, component) = name.rsplit_once('.')?;
    let field = snapshot.field(whole)?;
    let place = |names: &[&str]| names.iter().position(|known| *known == component);
    let values: Vec<f64> = match &field.data {
        FieldData::Vector(vectors) => {
            let axis = place(&VECTOR_COMPONENTS)?;
            vectors.iter().map(|vector| vector[axis]).collect()
        }
        FieldData::Tensor(tensors) if component == "q" => tensors.iter().map(SymTensor::q).collect(),
        FieldData::Tensor(tensors) => {
            let component = place(&TENSOR_COMPONENTS)?;
            tensors.iter().map(|tensor| tensor[component]).collect()
        }
        _ => return None,
    };
    Some((field, values, name.to_owned()))
}

/// Values of a field by which points are coloured: scalars, lengths of vectors, pressures of tensors.
pub(crate) fn values(field: &Field) -> Vec<f64> {
    match &field.data {
        FieldData::Integer(values) => values.iter().map(|value| *value as f64).collect(),
        FieldData::Scalar(values) => values.clone(),
        FieldData::Vector(values) => {
            values.iter().map(|v| v.iter().map(|c| c * c).sum::<f64>().sqrt()).collect()
        }
        FieldData::Tensor(values) => values.iter().map(SymTensor::pressure).collect(),
    }
}

/// Perceptually uniform colours from dark blue over green to yellow, equally spaced.
pub(crate) const COLOUR_STOPS: [[f64; 3]; 6] = [
    [68.0, 1.0, 84.0],
    [65.0, 68.0, 135.0],
    [42.0, 120.0, 142.0],
    [34.0, 168.0, 132.0],
    [122.0, 209.0, 81.0],
    [253.0, 231.0, 37.0],
];

/// Colour at a share of the scale.
pub(crate) fn colour(share: f64) -> RGBColor {
    if !share.is_finite() {
        return RGBColor(170, 170, 170);
    }
    let place = share.clamp(0.0, 1.0) * (COLOUR_STOPS.len() - 1) as f64;
    let stop = (place as usize).min(COLOUR_STOPS.len() - 2);
    let mix = |c: usize| {
        let t = place - stop as f64;
        (COLOUR_STOPS[stop][c] * (1.0 - t) + COLOUR_STOPS[stop + 1][c] * t).round() as u8
    };
    RGBColor(mix(0), mix(1), mix(2))
}

impl Picture for PointCloud {
    fn size(&self) -> (u32, u32) {
        // Equal scales on both axes, within reason.
        let [x, y] = self.bounds();
        let ratio = ((y.end - y.start) / (x.end - x.start)).clamp(0.15, 1.2);
        (WIDTH, (f64::from(WIDTH - 190) * ratio) as u32 + 100)
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), String> {
        let text = |error: DrawingAreaErrorKind<B::ErrorType>| error.to_string();
        area.fill(&WHITE).map_err(text)?;
        let (main, bar) = area.split_horizontally(WIDTH - 100);
        let own = || range(self.points.iter().map(|p| p.2), 0.0);
        let values = self.shared_scales.as_ref().map_or_else(own, |shared| shared.values.clone());
        let pixels = [WIDTH - 190, self.size().1 - 100];
        let pixel = scale(&self.bounds(), pixels);
        let mut chart = plane(&main, &self.title, &self.axes, self.bounds(), pixels)?;
        let window = [chart.x_range(), chart.y_range()];
        for part in self.lines.iter().flat_map(|line| clip_line(line, &window)) {
            let corners = part.iter().map(|x| (x[0], x[1]));
            chart.draw_series(LineSeries::new(corners, EARTH.stroke_width(2))).map_err(text)?;
        }
        let share = |v: f64| (v - values.start) / (values.end - values.start);
        let paint = |v: f64| colour(share(v)).filled();
        if self.is_round {
            let disks = self.points.iter().map(|(p, e, v)| Polygon::new(disk_polygon(p, e), paint(*v)));
            chart.draw_series(disks).map_err(text)?;
        } else {
            let squares = self.points.iter().map(|(p, e, v)| {
                let half =
                    e.map(|width| 0.5 * if width > 0.0 { width.max(pixel) } else { DEFAULT_WIDTH * pixel });
                let corner = |s: f64| (p[0] + s * half[0], p[1] + s * half[1]);
                Rectangle::new([corner(-1.0), corner(1.0)], paint(*v))
            });
            chart.draw_series(squares).map_err(text)?;
        }
        let label = draw_bar(&bar, values, &self.label)?;
        // Above the bar and to its left: turned along the bar, a long label would not fit a flat picture.
        let style = TextStyle::from((FONT, 15)).pos(Pos::new(HPos::Right, VPos::Top));
        let corner = (WIDTH as i32 - 8, 12);
        area.draw(&Text::new(label, corner, style)).map_err(text)
    }
}

/// Corners of the polygon of a disk of these widths.
fn disk_polygon(place: &[f64; 2], widths: &[f64; 2]) -> Vec<(f64, f64)> {
    let corner = |k: u32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / f64::from(CORNERS)).sin_cos();
        (place[0] + 0.5 * widths[0] * cos, place[1] + 0.5 * widths[1] * sin)
    };
    (0..CORNERS).map(corner).collect()
}

/// Position and width of the colour bar in its strip (pixels): distance from the right edge, from the upper and from the lower one.
const COLOUR_BAR: [i32; 3] = [28, 36, 50];
/// Distance of the labels from the bar (px).
const LABEL_DISTANCE: i32 = 8;

/// Draws a colour bar with its scale; returns the description of its numbers.
pub(crate) fn draw_bar<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    values: Range<f64>,
    label: &str,
) -> Result<String, String> {
    let text = |error: DrawingAreaErrorKind<B::ErrorType>| error.to_string();
    let (width, height) = area.dim_in_pixel();
    let [left, upper, lower] = [width as i32 - COLOUR_BAR[0], COLOUR_BAR[1], height as i32 - COLOUR_BAR[2]];
    let right = width as i32 - 5;
    let tall = (lower - upper).max(1);
    for row in 0..tall {
        let share = 1.0 - (f64::from(row) + 0.5) / f64::from(tall);
        let ends = [(left, upper + row), (right, upper + row + 1)];
        area.draw(&Rectangle::new(ends, colour(share).filled())).map_err(text)?;
    }
    let ticks = Ticks::linear(&values, f64::from(tall), AxisDirection::Vertical);
    let style = TextStyle::from((FONT, LETTERS)).pos(Pos::new(HPos::Right, VPos::Center));
    for (place, said) in ticks.visible_labels() {
        let share = (place - values.start) / (values.end - values.start);
        let row = lower - (share * f64::from(tall)).round() as i32;
        area.draw(&PathElement::new(vec![(left - 4, row), (left, row)], BLACK)).map_err(text)?;
        area.draw(&Text::new(said, (left - LABEL_DISTANCE, row), style.clone())).map_err(text)?;
    }
    Ok(ticks.axis_label(label))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_label_stays_within_a_flat_picture() {
        let flat = PointCloud {
            title: "t = 0.25 s".into(),
            points: (0..40).map(|i| ([f64::from(i), 0.5], [1.0; 2], f64::from(i))).collect(),
            label: "equivalent plastic strain rate (1/s)".into(),
            axes: ["x (m)".into(), "y (m)".into()],
            ..PointCloud::default()
        };
        let svg = flat.to_svg().unwrap();
        let element = svg.split("<text").find(|part| part.contains(&flat.label)).unwrap();
        let number = |name: &str| -> f64 {
            let start = element.find(&format!(" {name}=\"")).unwrap() + name.len() + 3;
            element[start..].split('"').next().unwrap().parse().unwrap()
        };
        // Anchored at its right end, and level: it runs to the left from there, about half its height per letter.
        assert!(element.contains("text-anchor=\"end\"") && !element.contains("transform"), "{element}");
        let width = 0.6 * 15.0 * flat.label.len() as f64;
        assert!(number("x") <= f64::from(WIDTH) && number("x") - width > 0.5 * f64::from(WIDTH));
        // The position is that of the upper edge; the bar begins at 36.
        assert!(number("y") > 0.0 && number("y") + 15.0 < 36.0, "between the edge and the bar");
    }

    #[test]
    fn grains_are_disks_and_other_points_squares() {
        let squares = PointCloud { points: vec![([0.0, 1.0], [2.0; 2], 1.0)], ..PointCloud::default() };
        let disks = PointCloud { is_round: true, ..squares.clone() };
        let polygons = |cloud: &PointCloud| cloud.to_svg().unwrap().matches("<polygon").count();
        assert_eq!([polygons(&squares), polygons(&disks)], [0, 1]);
        let on_rim = |(x, y): &(f64, f64)| (x.hypot(y - 1.0) - 1.0).abs() < 1e-12;
        assert!(disk_polygon(&[0.0, 1.0], &[2.0; 2]).iter().all(on_rim));
    }

    #[test]
    fn shared_scales_cover_all_clouds_and_outliers_do_not_widen_the_colour_range() {
        let cloud = |offset: f64| PointCloud {
            points: (0..1000).map(|i| ([offset + f64::from(i), 1.0], [2.0; 2], f64::from(i % 10))).collect(),
            ..PointCloud::default()
        };
        let (left, mut right) = (cloud(-500.0), cloud(500.0));
        right.points[3].2 = 1e6;
        let shared = CommonScales::of_clouds([&left, &right].into_iter());
        assert_eq!(shared.values, 0.0..9.0);
        let [x, y] = &shared.window;
        assert!(x.start <= -501.0 && x.end >= 1500.0 && y.start <= 0.0 && y.end >= 2.0, "{shared:?}");
        let with_scale = PointCloud { shared_scales: Some(shared.clone()), ..left };
        assert_eq!(with_scale.size(), PointCloud { shared_scales: Some(shared), ..right }.size());
    }

    #[test]
    fn components_of_tensors_and_vectors_colour_points() {
        let stress = SymTensor([-3.0, -6.0, 0.0, 1.5, 0.0, 0.0]);
        let field = |name: &str, data| Field { name: name.to_owned(), unit: "Pa", data };
        let snapshot = Snapshot {
            positions: vec![[0.0; 3]],
            extents: vec![[1.0; 3]],
            fields: vec![
                field("stress", FieldData::Tensor(vec![stress])),
                field("force", FieldData::Vector(vec![[3.0, -4.0, 0.0]])),
            ],
            ..Snapshot::default()
        };
        let value =
            |name: &str| PointCloud::from_snapshot(&snapshot, name, [0, 1]).map(|cloud| cloud.points[0].2);
        assert_eq!(value("stress"), Some(3.0));
        assert_eq!((value("stress.yy"), value("stress.xy")), (Some(-6.0), Some(1.5)));
        assert_eq!(value("stress.q"), Some(stress.q()));
        assert_eq!((value("force"), value("force.y")), (Some(5.0), Some(-4.0)));
        assert_eq!((value("stress.y"), value("force.q"), value("heat.x")), (None, None, None));
    }
}
