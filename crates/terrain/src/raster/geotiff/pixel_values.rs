//! Pixel values of a TIFF.

use std::io::Cursor;

use tiff::ColorType;
use tiff::decoder::{ChunkType, Decoder, DecodingResult};
use tiff::tags::Tag;

use crate::raster::geotiff::{TiffDecoder, tiff_error, validity_mask};

/// Pixel values of the image, from north to south. Values of a colour palette are class numbers. Tiles and strips that were not written
/// have the value `missing`, as in GDAL.
pub(super) fn pixel_values(
    bytes: &[u8],
    mut decoder: TiffDecoder<'_>,
    missing: f64,
) -> Result<Vec<f64>, String> {
    let meaning = decoder.find_tag_unsigned::<u32>(Tag::PhotometricInterpretation).ok().flatten();
    if meaning == Some(validity_mask::PALETTE)
        && let Some(plain) = validity_mask::without_palette(bytes, &mut decoder)
    {
        let mut decoder = Decoder::new(Cursor::new(&plain[..])).map_err(tiff_error)?;
        return image_values(&mut decoder, missing);
    }
    image_values(&mut decoder, missing)
}

/// Values of all pixels as floating-point numbers; parts that the file leaves out have the value `missing`.
fn image_values(decoder: &mut TiffDecoder<'_>, missing: f64) -> Result<Vec<f64>, String> {
    match decoder.colortype().map_err(tiff_error)? {
        ColorType::Gray(bits) if bits < 8 => {
            Err(format!("has {bits} bits per number: write it with 8 bits or more"))
        }
        ColorType::Gray(_) => {
            let lengths = match decoder.get_chunk_type() {
                ChunkType::Strip => Tag::StripByteCounts,
                ChunkType::Tile => Tag::TileByteCounts,
            };
            let lengths = decoder.get_tag_u64_vec(lengths).unwrap_or_default();
            if lengths.contains(&0) {
                return chunk_values(decoder, &lengths, missing);
            }
            decoder.read_image().map(to_f64).map_err(tiff_error)
        }
        _ => {
            Err("has several bands or colours: write the band with the numbers to a separate file".to_owned())
        }
    }
}

/// Values of the tiles or strips that have bytes, and `missing` in the others.
fn chunk_values(decoder: &mut TiffDecoder<'_>, lengths: &[u64], missing: f64) -> Result<Vec<f64>, String> {
    let (columns, rows) = decoder.dimensions().map_err(tiff_error)?;
    let (width, height) = decoder.chunk_dimensions();
    let across = columns.div_ceil(width.max(1));
    let (columns, rows) = (columns as usize, rows as usize);
    let mut values = vec![missing; columns * rows];
    for number in (0..lengths.len() as u32).filter(|number| lengths[*number as usize] > 0) {
        let (own_width, _) = decoder.chunk_data_dimensions(number);
        let (left, top) = ((number % across * width) as usize, (number / across * height) as usize);
        let chunk = to_f64(decoder.read_chunk(number).map_err(tiff_error)?);
        for (row, line) in chunk.chunks_exact(own_width.max(1) as usize).enumerate() {
            let from = (top + row) * columns + left;
            if let Some(place) = values.get_mut(from..from + line.len()) {
                place.copy_from_slice(line);
            }
        }
    }
    Ok(values)
}

/// Converts decoded pixels to floating-point numbers.
fn to_f64(image: DecodingResult) -> Vec<f64> {
    fn to_floats<T: Into<f64>>(values: Vec<T>) -> Vec<f64> {
        values.into_iter().map(Into::into).collect()
    }
    match image {
        DecodingResult::U8(values) => to_floats(values),
        DecodingResult::U16(values) => to_floats(values),
        DecodingResult::U32(values) => to_floats(values),
        DecodingResult::U64(values) => values.into_iter().map(|value| value as f64).collect(),
        DecodingResult::I8(values) => to_floats(values),
        DecodingResult::I16(values) => to_floats(values),
        DecodingResult::I32(values) => to_floats(values),
        DecodingResult::I64(values) => values.into_iter().map(|value| value as f64).collect(),
        DecodingResult::F16(values) => to_floats(values),
        DecodingResult::F32(values) => to_floats(values),
        DecodingResult::F64(values) => values,
    }
}
