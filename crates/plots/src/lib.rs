//! Pictures, as PNG or SVG: line charts and clouds of points; and animations of points for a browser. The font is built in, so that
//! pictures are identical on any machine.
//!
//! ```
//! use colluvium_plots::{LineChart, Picture, Series, Style};
//!
//! // Settlement of a layer by Terzaghi's first term, and three measured values.
//! let curve = (0..=100).map(|i| f64::from(i) / 50.0).map(|t| (t, 1.0 - 0.81 * (-2.47 * t).exp())).collect();
//! let measured = vec![(0.2, 0.50), (0.4, 0.70), (0.8, 0.89)];
//! let chart = LineChart {
//!     series: vec![
//!         Series::new("first term", curve, Style::Line),
//!         Series::new("measured", measured, Style::Markers),
//!     ],
//!     ..LineChart::new("Consolidation", "time factor (-)", "degree of consolidation (-)")
//! };
//! let folder = tempfile::tempdir()?;
//! let file = folder.path().join("consolidation.png");
//! chart.write(&file)?;
//! assert!(std::fs::read(&file)?.starts_with(b"\x89PNG"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A [`PointCloud`] draws the points of a [`Snapshot`](colluvium_case::Snapshot), a [`TerrainMap`] a raster with contours. The crate
//! depends on `colluvium-case` and `colluvium-constitutive`.

mod animation;
mod charts;
mod pictures;

use std::path::Path;
use std::sync::Once;

use plotters::prelude::*;
use plotters::style::register_font;

use colluvium_case::output::{OutputError, write_atomically};

pub use crate::charts::line_chart::{LineChart, Series, Style};
pub use crate::pictures::animated_gif::to_gif;
pub use crate::pictures::force_chains::{ContactRose, ForceChains};
pub use crate::pictures::frame_picture::FramePicture;
pub use crate::pictures::point_cloud::{CommonScales, PointCloud};
pub use crate::pictures::rigid_geometry::{Heights, MovingLines, MovingSurface, RigidGeometry, clip_line};
pub use crate::pictures::terrain_map::{MapCells, TerrainMap};
pub use animation::{Animation, DEFAULT_BYTES, Panel, PointClasses, QuantisedRange, SCRIPT, STYLE, View};

/// Name under which the built-in font is registered.
const FONT: &str = "sans-serif";

/// Colours that colour-blind readers can distinguish (Okabe and Ito).
const PALETTE: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(70, 70, 70),
];

/// Registers the built-in font once.
fn load_font() {
    static FONT_LOADED: Once = Once::new();
    FONT_LOADED.call_once(|| {
        // A built-in font cannot be invalid.
        let _ = register_font(FONT, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT);
    });
}

/// Picture that can be drawn as SVG, as PNG, or on an area of another picture.
pub trait Picture {
    /// Width and height (pixels).
    fn size(&self) -> (u32, u32);

    /// Draws the picture on the given area.
    ///
    /// # Errors
    /// When the back end fails.
    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, plotters::coord::Shift>) -> Result<(), String>;

    /// Returns the picture as SVG text.
    ///
    /// # Errors
    /// When the back end fails.
    fn to_svg(&self) -> Result<String, String> {
        load_font();
        let mut text = String::new();
        {
            let area = SVGBackend::with_string(&mut text, self.size()).into_drawing_area();
            self.draw(&area)?;
            area.present().map_err(|error| error.to_string())?;
        }
        Ok(text)
    }

    /// Returns the picture as red, green and blue of each pixel, row by row.
    ///
    /// # Errors
    /// When the back end fails.
    fn to_pixels(&self) -> Result<Vec<u8>, String> {
        load_font();
        let (width, height) = self.size();
        let mut pixels = vec![0; 3 * width as usize * height as usize];
        {
            let area = BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area();
            self.draw(&area)?;
            area.present().map_err(|error| error.to_string())?;
        }
        Ok(pixels)
    }

    /// Returns the picture as the bytes of a PNG file.
    ///
    /// # Errors
    /// When the back end fails.
    fn to_png(&self) -> Result<Vec<u8>, String> {
        let (width, height) = self.size();
        let pixels = self.to_pixels()?;
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Rgb);
        let written = encoder.write_header().and_then(|mut writer| {
            writer.write_image_data(&pixels)?;
            writer.finish()
        });
        written.map(|()| bytes).map_err(|error| error.to_string())
    }

    /// Writes the picture; the file's extension, `png` or `svg`, decides the format.
    ///
    /// # Errors
    /// For other extensions, or when the file cannot be written.
    fn write(&self, path: &Path) -> Result<(), OutputError> {
        let fail = |problem: String| OutputError::new(path, problem);
        let bytes = match path.extension().and_then(|extension| extension.to_str()) {
            Some("svg") => self.to_svg().map(String::into_bytes),
            Some("png") => self.to_png(),
            _ => Err("pictures are written as png or svg".to_owned()),
        };
        write_atomically(path, &bytes.map_err(fail)?)
    }
}

/// Range of finite values with a margin. Around constants it has the width one; without values it is 0 to 1.
fn range(values: impl Iterator<Item = f64>, margin: f64) -> std::ops::Range<f64> {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if low > high {
        return 0.0..1.0;
    }
    let width = high - low;
    if width <= 1e-12 * high.abs().max(1e-300) {
        let half = if high == 0.0 { 0.5 } else { 0.5 * high.abs() };
        return low - half..high + half;
    }
    low - margin * width..high + margin * width
}

/// Short label for an axis, with an exponent where it would be long without.
fn label(value: &f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e5).contains(&size) {
        return format!("{value:.1e}");
    }
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Text of a number with three significant digits.
fn significant(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || !size.is_finite() {
        return format!("{}", value + 0.0);
    }
    // Rounded first: 0.9996 has the digits of 1.
    let rounded: f64 = format!("{value:.2e}").parse().unwrap_or(value);
    let digits = 2 - rounded.abs().log10().floor() as i32;
    match digits {
        -2..=5 => {
            let plain = format!("{rounded:.*}", digits.max(0) as usize);
            if plain.contains('.') {
                plain.trim_end_matches('0').trim_end_matches('.').to_owned()
            } else {
                plain
            }
        }
        _ => format!("{value:.2e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn significant_digits_are_three_at_any_size() {
        let numbers = [0.0, 5.0, 0.123456, 0.9996, 1.5e-7, 17.3456, 1234.5678, 54321.9, 1.23456e6, f64::NAN];
        let texts = ["0", "5", "0.123", "1", "1.50e-7", "17.3", "1230", "54300", "1.23e6", "NaN"];
        assert_eq!(numbers.map(significant), texts);
    }

    #[test]
    fn a_constant_is_at_the_middle_of_its_axis_range() {
        for value in [4e-8, 1e-3, -2.0, 7e12] {
            let range = range([value; 3].into_iter(), 0.05);
            let share = (value - range.start) / (range.end - range.start);
            assert!((share - 0.5).abs() < 1e-12 && !range.contains(&0.0), "{range:?}");
        }
        assert_eq!(range([0.0].into_iter(), 0.05), -0.5..0.5);
    }

    #[test]
    fn charts_of_empty_and_non_finite_data_are_drawn() {
        let odd = [
            vec![],
            vec![(f64::NAN, 1.0)],
            vec![(1.0, 1.0)],
            vec![(0.0, f64::INFINITY), (1.0, 2.0)],
            vec![(-1.0, 0.0), (1.0, -1e300)],
        ];
        for points in odd {
            for log in [false, true] {
                let chart = LineChart {
                    title: "odd".into(),
                    log,
                    series: vec![Series::new("s", points.clone(), Style::Line)],
                    ..LineChart::default()
                };
                assert!(chart.to_svg().unwrap().contains("</svg>"));
            }
        }
    }

    /// Boxes of the texts of an SVG picture that have a size of 13 or 14 px, those of ticks: text, left, right, upper and lower end.
    fn boxes(svg: &str) -> Vec<(String, [f64; 4])> {
        let one = |part: &str| {
            let attribute = |name: &str| {
                let start = part.find(&format!(" {name}=\"")).unwrap() + name.len() + 3;
                part[start..].split('"').next().unwrap().to_owned()
            };
            let number = |name: &str| attribute(name).parse::<f64>().unwrap();
            let text = part[part.find('>').unwrap() + 1..part.find("</text>").unwrap()].trim().to_owned();
            // The back end writes sizes as 1.24 times smaller letters.
            let width = 0.5 * 14.0 * text.len() as f64;
            let (x, y) = (number("x"), number("y"));
            let left = match attribute("text-anchor").as_str() {
                "end" => x - width,
                "middle" => x - 0.5 * width,
                _ => x,
            };
            let turned = part[..part.find('>').unwrap()].contains("transform");
            (!turned).then_some((text, [left, left + width, y - 6.0, y + 6.0]))
        };
        svg.split("<text").skip(1).filter_map(one).filter(|(text, _)| text.parse::<f64>().is_ok()).collect()
    }

    fn overlapping(svg: &str) -> Vec<(String, String)> {
        let boxes = boxes(svg);
        let meet = |a: &[f64; 4], b: &[f64; 4]| a[0] < b[1] && b[0] < a[1] && a[2] < b[3] && b[2] < a[3];
        let mut found = Vec::new();
        for (k, (text, one)) in boxes.iter().enumerate() {
            for (other, two) in boxes[k + 1..].iter().filter(|(_, two)| meet(one, two)) {
                found.push((text.clone(), format!("{other} {one:?} {two:?}")));
            }
        }
        found
    }

    #[test]
    fn numbers_at_axes_differ_and_do_not_overlap() {
        let line = |low: f64, high: f64| vec![(low, high), (high, low)];
        let ends =
            [(0.0, 1.0), (6.0e5, 6.0e5 + 3.0), (2.67e11, 2.671e11), (1e-9, 3e4), (2.0, 2.1), (1e-12, 4e-12)];
        for (low, high) in ends {
            for log in [false, true].into_iter().filter(|log| !log || low > 0.0) {
                let series = vec![Series::new("", line(low, high), Style::Line)];
                let svg = LineChart { log, series, ..LineChart::default() }.to_svg().unwrap();
                assert!(boxes(&svg).len() >= 4, "{low} {high} {log}");
                assert_eq!(overlapping(&svg), [], "{low} {high} {log}");
            }
            let points = [low, high].map(|x| ([x, x], [0.05 * (high - low); 2], x));
            let cloud = PointCloud { points: points.to_vec(), ..PointCloud::default() };
            assert_eq!(overlapping(&cloud.to_svg().unwrap()), [], "{low} {high}");
        }
    }

    #[test]
    fn pictures_are_written_by_extension() {
        let dir = tempfile::tempdir().unwrap();
        let cloud = PointCloud {
            title: "cloud".into(),
            points: vec![([0.0, 0.0], [0.1, 0.1], 1.0), ([1.0, 0.5], [0.1, 0.1], f64::NAN)],
            label: "speed (m/s)".into(),
            ..PointCloud::default()
        };
        for name in ["a.png", "a.svg"] {
            cloud.write(&dir.path().join(name)).unwrap();
            assert!(std::fs::metadata(dir.path().join(name)).unwrap().len() > 500);
        }
        assert!(cloud.write(&dir.path().join("a.gif")).is_err());
    }

    /// Picture whose drawing fails after the first elements.
    struct Broken;

    impl Picture for Broken {
        fn size(&self) -> (u32, u32) {
            (40, 30)
        }
        fn draw<B: DrawingBackend>(
            &self,
            area: &DrawingArea<B, plotters::coord::Shift>,
        ) -> Result<(), String> {
            area.fill(&WHITE).map_err(|error| error.to_string())?;
            Err("out of ink".to_owned())
        }
    }

    #[test]
    fn a_picture_is_replaced_as_a_whole_or_not_at_all() {
        let dir = tempfile::tempdir().unwrap();
        for name in ["a.png", "a.svg"] {
            let path = dir.path().join(name);
            std::fs::write(&path, "old").unwrap();
            // A reader that has the old file open keeps its whole content.
            let reader = dir.path().join("reader");
            std::fs::hard_link(&path, &reader).unwrap();
            assert!(Broken.write(&path).unwrap_err().to_string().contains("out of ink"));
            assert_eq!(std::fs::read(&path).unwrap(), b"old");
            LineChart::default().write(&path).unwrap();
            assert!(std::fs::metadata(&path).unwrap().len() > 500);
            assert_eq!(std::fs::read(&reader).unwrap(), b"old");
            std::fs::remove_file(&reader).unwrap();
        }
        let left = std::fs::read_dir(dir.path()).unwrap().count();
        assert_eq!(left, 2, "nothing but the pictures");
    }
}
