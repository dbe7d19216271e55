//! Animated GIF of a sequence of pictures.

use std::collections::HashMap;

use crate::Picture;
use crate::pictures::point_cloud::colour;

/// Number of colours of the scale among the 256 of a GIF; the others are greys.
const SCALE: usize = 192;

/// Palette of 256 colours: the scale of the points, and greys from black to white for axes and text.
fn palette() -> Vec<[u8; 3]> {
    let of_scale = (0..SCALE).map(|k| {
        let colour = colour(k as f64 / (SCALE - 1) as f64);
        [colour.0, colour.1, colour.2]
    });
    let greys = 256 - SCALE;
    let grey = |k: usize| [(k * 255 / (greys - 1)) as u8; 3];
    of_scale.chain((0..greys).map(grey)).collect()
}

/// Animated GIF of pictures of one size, each shown for `each` (s), in an endless loop.
///
/// # Errors
/// When there is no picture, they differ in size, or one cannot be drawn.
pub fn to_gif<P: Picture>(pictures: &[P], each: f64) -> Result<Vec<u8>, String> {
    let (width, height) = pictures.first().ok_or("the animation has no pictures")?.size();
    let side =
        |length: u32| u16::try_from(length).map_err(|_| format!("{length} pixels are too many for a GIF"));
    let (wide, high) = (side(width)?, side(height)?);
    let palette = palette();
    let mut bytes = Vec::new();
    let text = |error: gif::EncodingError| error.to_string();
    let mut encoder = gif::Encoder::new(&mut bytes, wide, high, palette.as_flattened()).map_err(text)?;
    encoder.set_repeat(gif::Repeat::Infinite).map_err(text)?;
    let mut nearest: HashMap<[u8; 3], u8> = HashMap::new();
    for picture in pictures {
        if picture.size() != (width, height) {
            return Err("the pictures of an animation must have one size".to_owned());
        }
        let pixels = picture.to_pixels()?;
        let number = |pixel: &[u8; 3]| *nearest.entry(*pixel).or_insert_with(|| closest(&palette, pixel));
        let frame = gif::Frame {
            width: wide,
            height: high,
            // In hundredths of a second.
            delay: (100.0 * each).round().clamp(2.0, 1000.0) as u16,
            buffer: pixels.as_chunks().0.iter().map(number).collect::<Vec<u8>>().into(),
            ..gif::Frame::default()
        };
        encoder.write_frame(&frame).map_err(text)?;
    }
    drop(encoder);
    Ok(bytes)
}

/// Index of the palette colour closest to that of a pixel.
fn closest(palette: &[[u8; 3]], pixel: &[u8; 3]) -> u8 {
    let distance = |colour: &[u8; 3]| -> i32 {
        colour.iter().zip(pixel).map(|(a, b)| (i32::from(*a) - i32::from(*b)).pow(2)).sum()
    };
    let found = palette.iter().enumerate().min_by_key(|(_, colour)| distance(colour));
    found.map_or(0, |(number, _)| number as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CommonScales, PointCloud};

    fn clouds() -> Vec<PointCloud> {
        let cloud = |k: i32| PointCloud {
            points: (0..20).map(|i| ([f64::from(i + k), 0.5], [1.0; 2], f64::from(i * k))).collect(),
            ..PointCloud::default()
        };
        let clouds: Vec<PointCloud> = (1..4).map(cloud).collect();
        let shared = CommonScales::of_clouds(clouds.iter());
        clouds.into_iter().map(|cloud| PointCloud { shared_scales: Some(shared.clone()), ..cloud }).collect()
    }

    #[test]
    fn a_film_has_every_picture_in_its_colours() {
        let clouds = clouds();
        let bytes = to_gif(&clouds, 0.1).unwrap();
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut decoder = options.read_info(&bytes[..]).unwrap();
        for cloud in &clouds {
            let frame = decoder.read_next_frame().unwrap().unwrap();
            assert_eq!((u32::from(frame.width), u32::from(frame.height)), cloud.size());
            assert_eq!(frame.delay, 10);
            let pixels = cloud.to_pixels().unwrap();
            // Edges of letters lie between greys, and fills between neighbours of the scale.
            for (pixel, shown) in pixels.as_chunks::<3>().0.iter().zip(frame.buffer.as_chunks::<4>().0) {
                let off = pixel.iter().zip(shown).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
                assert!(off <= 4, "{pixel:?} as {shown:?}");
            }
        }
        assert!(decoder.read_next_frame().unwrap().is_none());
    }

    #[test]
    fn pictures_of_unequal_size_and_empty_lists_give_no_animation() {
        let mut clouds = clouds();
        clouds[1].shared_scales = None;
        clouds[1].points.push(([0.0, 30.0], [1.0; 2], 0.0));
        assert!(to_gif(&clouds, 0.1).unwrap_err().contains("one size"));
        assert!(to_gif::<PointCloud>(&[], 0.1).is_err());
    }
}
