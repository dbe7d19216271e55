//! Force chains and contact roses.

use std::ops::Range;

use colluvium_case::{Dataset, DatasetGeometry, Snapshot};

use plotters::coord::Shift;
use plotters::prelude::*;

use crate::charts::plane_axes::{plane, scale};
use crate::pictures::point_cloud::{EARTH, values};
use crate::{CommonScales, FONT, PALETTE, Picture, clip_line, label, range, significant};

/// Force chains: grains, with lines between the centres of grains in contact. The width of a line is proportional to the force, and lines
/// above the mean force are dark.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ForceChains {
    /// Title above the picture.
    pub title: String,
    /// Centre and radius of each grain (m).
    pub grains: Vec<([f64; 2], f64)>,
    /// Both ends (m) and force (N; N/m in the plane) of each contact.
    pub lines: Vec<([[f64; 2]; 2], f64)>,
    /// Labels of the two axes.
    pub axes: [String; 2],
    /// Rigid geometry behind the grains, as lines (m).
    pub ground: Vec<Vec<[f64; 2]>>,
    /// Window and force scale in common with other pictures, the mean force being the end of its values. `None` for scales of this picture
    /// alone.
    pub shared_scale: Option<CommonScales>,
}

/// Width of a picture (pixels).
const WIDTH: u32 = 900;
/// Margins beside and above the drawing (px).
const MARGINS: [u32; 2] = [90, 90];

impl ForceChains {
    /// Force chains from the lines of a dataset between the grains of a state, projected to `plane`. The width of the lines is proportional
    /// to the field `name`.
    pub fn from_dataset(
        contacts: &Dataset,
        grains: &Snapshot,
        name: &str,
        plane: [usize; 2],
    ) -> Option<Self> {
        let DatasetGeometry::Mesh(mesh) = &contacts.geometry else { return None };
        let field = contacts.fields.iter().find(|field| field.name == name)?;
        let at = |v: &[f64; 3]| [v[plane[0]], v[plane[1]]];
        let ends = mesh.cells().filter(|line| line.len() == 2).map(|line| [at(&line[0]), at(&line[1])]);
        let sizes = values(field).into_iter().map(f64::abs);
        let lines: Vec<_> = ends.zip(sizes).filter(|(_, size)| size.is_finite()).collect();
        let largest = lines.iter().fold(0.0f64, |maximum, (_, size)| maximum.max(*size));
        let unit = if field.unit.is_empty() { String::new() } else { format!(" {}", field.unit) };
        let (mean, largest) = (significant(mean(&lines)), significant(largest));
        let axis = |c: usize| format!("{} (m)", ["x", "y", "z"][c]);
        Some(Self {
            title: format!(
                "{}, t = {} s: mean {mean}{unit}, largest {largest}{unit}; dark: above the mean",
                name.replace('_', " "),
                label(&grains.time)
            ),
            grains: grains
                .positions
                .iter()
                .zip(&grains.extents)
                .map(|(x, e)| (at(x), 0.5 * e[plane[0]]))
                .collect(),
            lines,
            axes: [axis(plane[0]), axis(plane[1])],
            ..Self::default()
        })
    }

    /// Common scales of several pictures.
    pub fn common_scales<'a>(all: impl Iterator<Item = &'a Self> + Clone) -> CommonScales {
        let join = |a: Range<f64>, b: &Range<f64>| a.start.min(b.start)..a.end.max(b.end);
        let bounds: Vec<_> = all.clone().map(Self::bounds).collect();
        let nothing = [f64::INFINITY..f64::NEG_INFINITY, f64::INFINITY..f64::NEG_INFINITY];
        let window = bounds.iter().fold(nothing, |[x, y], [a, b]| [join(x, a), join(y, b)]);
        let lines: Vec<_> = all.flat_map(|one| one.lines.iter().copied()).collect();
        CommonScales {
            values: 0.0..mean(&lines),
            window: window.map(|r| if r.start < r.end { r } else { 0.0..1.0 }),
        }
    }

    /// Extent of the drawn grains and contact forces (m), or the extent that pictures share.
    fn bounds(&self) -> [Range<f64>; 2] {
        if let Some(shared) = &self.shared_scale {
            return shared.window.clone();
        }
        [0, 1].map(|c| {
            let rims = self.grains.iter().flat_map(|(x, r)| [x[c] - r, x[c] + r]);
            range(rims.chain(self.lines.iter().flat_map(|([a, b], _)| [a[c], b[c]])), 0.02)
        })
    }

    /// Size of a pixel (m).
    fn pixel(&self) -> f64 {
        scale(&self.bounds(), [WIDTH - MARGINS[0], self.size().1 - MARGINS[1]])
    }
}

impl Picture for ForceChains {
    fn size(&self) -> (u32, u32) {
        let [x, y] = self.bounds();
        let ratio = ((y.end - y.start) / (x.end - x.start)).clamp(0.15, 1.3);
        (WIDTH, (f64::from(WIDTH - MARGINS[0]) * ratio) as u32 + MARGINS[1])
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), String> {
        let text = |error: DrawingAreaErrorKind<B::ErrorType>| error.to_string();
        area.fill(&WHITE).map_err(text)?;
        let (pixel, (_, height)) = (self.pixel(), self.size());
        let pixels = [WIDTH - MARGINS[0], height - MARGINS[1]];
        let mut chart = plane(area, &self.title, &self.axes, self.bounds(), pixels)?;
        let window = [chart.x_range(), chart.y_range()];
        for part in self.ground.iter().flat_map(|line| clip_line(line, &window)) {
            let corners = part.iter().map(|x| (x[0], x[1]));
            chart.draw_series(LineSeries::new(corners, EARTH.stroke_width(2))).map_err(text)?;
        }
        let grey = RGBColor(214, 214, 214);
        let disks = self.grains.iter().map(|(c, r)| {
            Circle::new((c[0], c[1]), (r / pixel).round().max(1.0) as i32, grey.stroke_width(1))
        });
        chart.draw_series(disks).map_err(text)?;
        // The mean force has the width of a sixth of the mean grain, the largest force that of a grain.
        let mean = self.shared_scale.as_ref().map_or_else(|| mean(&self.lines), |shared| shared.values.end);
        let grain =
            2.0 * self.grains.iter().map(|(_, r)| r).sum::<f64>() / self.grains.len().max(1) as f64 / pixel;
        let mut sorted: Vec<&([[f64; 2]; 2], f64)> = self.lines.iter().collect();
        sorted.sort_by(|a, b| a.1.total_cmp(&b.1));
        let lines = sorted.into_iter().filter(|(_, force)| *force > 0.0).map(|([from, to], force)| {
            let width = (force / mean * grain / 6.0).clamp(1.0, grain);
            let colour = if *force < mean { PALETTE[5] } else { PALETTE[0] };
            PathElement::new([(from[0], from[1]), (to[0], to[1])], colour.stroke_width(width.round() as u32))
        });
        chart.draw_series(lines).map_err(text).map(drop)
    }
}

/// Mean force of lines; zero where there are none.
fn mean(lines: &[([[f64; 2]; 2], f64)]) -> f64 {
    lines.iter().map(|(_, force)| force.max(0.0)).sum::<f64>() / lines.len().max(1) as f64
}

/// Contact rose: distribution of the directions of the contacts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactRose {
    /// Title above the picture.
    pub title: String,
    /// Share of the contacts in each of equal sectors of the half turn from the x axis towards y.
    pub sector_shares: Vec<f64>,
    /// Expected shares of the sectors by angle (rad), drawn as a line.
    pub line: Vec<f64>,
}

impl Picture for ContactRose {
    fn size(&self) -> (u32, u32) {
        (620, 640)
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), String> {
        let text = |error: DrawingAreaErrorKind<B::ErrorType>| error.to_string();
        area.fill(&WHITE).map_err(text)?;
        let largest = self.sector_shares.iter().chain(&self.line).copied().fold(1e-12, f64::max);
        let span = -1.08 * largest..1.08 * largest;
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, (FONT, 20))
            .margin(14)
            .x_label_area_size(36)
            .y_label_area_size(56)
            .build_cartesian_2d(span.clone(), span)
            .map_err(text)?;
        let shown = |value: &f64| label(&value.abs());
        chart
            .configure_mesh()
            .disable_mesh()
            .x_labels(5)
            .y_labels(5)
            .x_desc("share of the contacts in a direction")
            .x_label_formatter(&shown)
            .y_label_formatter(&shown)
            .label_style((FONT, 14))
            .axis_desc_style((FONT, 16))
            .draw()
            .map_err(text)?;
        let wide = std::f64::consts::PI / self.sector_shares.len().max(1) as f64;
        let at = |size: f64, angle: f64| (size * angle.cos(), size * angle.sin());
        // Twice: a contact has both directions.
        let petals = (0..2 * self.sector_shares.len()).map(|k| {
            let (size, from) = (self.sector_shares[k % self.sector_shares.len()], k as f64 * wide);
            let mut corners = vec![(0.0, 0.0)];
            corners.extend((0..=6).map(|part| at(size, from + wide * f64::from(part) / 6.0)));
            Polygon::new(corners, PALETTE[5].filled())
        });
        chart.draw_series(petals).map_err(text)?;
        if self.line.is_empty() {
            return Ok(());
        }
        let count = self.line.len();
        let step = std::f64::consts::PI / count as f64;
        let around = (0..=2 * count).map(|k| at(self.line[k % count], (k as f64 + 0.5) * step));
        let style = PALETTE[1].stroke_width(2);
        chart.draw_series([PathElement::new(around.collect::<Vec<_>>(), style)]).map_err(text).map(drop)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stronger_force_is_a_wider_line_above_the_others() {
        let chains = ForceChains {
            title: "chains".into(),
            grains: (0..3).map(|k| ([f64::from(k), 0.0], 0.5)).collect(),
            lines: vec![([[0.0, 0.0], [1.0, 0.0]], 3.0), ([[1.0, 0.0], [2.0, 0.0]], 1.0)],
            axes: ["x (m)".into(), "y (m)".into()],
            ..ForceChains::default()
        };
        let svg = chains.to_svg().unwrap();
        let width = |part: &str| -> f64 {
            let start = part.find("stroke-width=\"").unwrap() + 14;
            part[start..].split('"').next().unwrap().parse().unwrap()
        };
        let lines: Vec<f64> =
            svg.split("<polyline").skip(1).map(width).filter(|width| *width > 2.0).collect();
        assert!(lines.len() >= 2 && lines[lines.len() - 1] > 2.5 * lines[lines.len() - 2], "{lines:?}");
    }

    #[test]
    fn contacts_of_a_frame_are_lines_as_wide_as_their_forces() {
        use colluvium_case::solver::PolygonMesh;
        use colluvium_case::{Field, FieldData};
        let ends = [[[0.0; 3], [1.0, 0.0, 0.0]], [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]];
        let force = FieldData::Vector(vec![[-3.0, 4.0, 0.0], [0.0, 1.0, 0.0]]);
        let contacts = Dataset {
            name: "contacts".into(),
            geometry: DatasetGeometry::Mesh(PolygonMesh::of_lines(&ends)),
            fields: vec![Field { name: "force".into(), unit: "N", data: force }],
        };
        let grains = Snapshot {
            positions: (0..3).map(|k| [f64::from(k), 0.0, 0.0]).collect(),
            extents: vec![[1.0; 3]; 3],
            ..Snapshot::default()
        };
        let chains = ForceChains::from_dataset(&contacts, &grains, "force", [0, 1]).unwrap();
        assert_eq!(chains.lines, [([[0.0, 0.0], [1.0, 0.0]], 5.0), ([[1.0, 0.0], [2.0, 0.0]], 1.0)]);
        assert_eq!(chains.title, "force, t = 0 s: mean 3 N, largest 5 N; dark: above the mean");
        // Blue pixels are those of the lines: the grains are grey, and the text is black.
        let pixels = chains.to_pixels().unwrap();
        let blue = pixels
            .as_chunks::<3>()
            .0
            .iter()
            .filter(|[r, _, b]| *b > 100 && u32::from(*r) + 60 < u32::from(*b));
        assert!(blue.count() > 5000);
        assert!(ForceChains::from_dataset(&contacts, &grains, "overlap", [0, 1]).is_none());
        let mut odd = contacts.clone();
        odd.fields[0].data = FieldData::Scalar(vec![1234.5678, 0.0]);
        let title = ForceChains::from_dataset(&odd, &grains, "force", [0, 1]).unwrap().title;
        assert!(title.contains("mean 617 N, largest 1230 N"), "{title}");
        let double = ForceChains {
            lines: chains.lines.iter().map(|(x, f)| (*x, 3.0 * f)).collect(),
            ..chains.clone()
        };
        let shared = ForceChains::common_scales([&chains, &double].into_iter());
        assert_eq!(shared.values, 0.0..6.0);
    }

    #[test]
    fn a_rose_of_nothing_can_be_drawn() {
        assert!(ContactRose::default().to_svg().is_ok());
        assert!(ForceChains::default().to_svg().is_ok());
        let rose = ContactRose { title: "rose".into(), sector_shares: vec![0.1, 0.9], line: vec![0.5; 8] };
        assert_eq!(rose.to_svg().unwrap().matches("<polygon").count(), 4);
    }
}
