//! Validity masks in a TIFF, and conversion of masks and palettes, which the TIFF library does not decode.

use std::io::Cursor;

use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult};
use tiff::tags::{ByteOrder, Tag};

use crate::raster::geotiff::{TiffDecoder, tiff_error};

/// TIFF tag of the photometric interpretation.
const PHOTOMETRIC: u16 = 262;
/// Photometric interpretation of a picture in grey in which zero is black.
const BLACK_IS_ZERO: u8 = 1;
/// Photometric interpretation of a picture with a palette.
pub(super) const PALETTE: u32 = 3;
/// Flag of a picture of is image mask.
const MASK_BIT: u32 = 4;
/// Flag of a picture that is a reduced copy of another.
const REDUCED_BIT: u32 = 1;

/// Copy of a TIFF whose current image is declared to have plain numbers in place of a colour palette.
pub(super) fn without_palette(bytes: &[u8], decoder: &mut TiffDecoder<'_>) -> Option<Vec<u8>> {
    let at = usize::try_from(decoder.ifd_pointer()?.0).ok()?;
    let is_little = decoder.byte_order() == ByteOrder::LittleEndian;
    let short = |at: usize| {
        let two: [u8; 2] = bytes.get(at..at + 2)?.try_into().ok()?;
        Some(if is_little { u16::from_le_bytes(two) } else { u16::from_be_bytes(two) })
    };
    let is_big = short(2)? == 43;
    // The count of entries has two or eight bytes, an entry twelve or twenty; its value begins four or eight bytes before its end.
    let (first, entry, value) = if is_big { (8, 20, 12) } else { (2, 12, 8) };
    let count = usize::from(short(if is_big && !is_little { at + 6 } else { at })?);
    let found = (0..count).map(|k| at + first + k * entry).find(|at| short(*at) == Some(PHOTOMETRIC))?;
    let mut changed = bytes.to_vec();
    let place = changed.get_mut(found + value..found + value + 2)?;
    place.copy_from_slice(&if is_little { [BLACK_IS_ZERO, 0] } else { [0, BLACK_IS_ZERO] });
    Some(changed)
}

/// Validity of each pixel by the mask in the raster file, from north to south; `None` without a mask.
pub(super) fn embedded_mask(bytes: &[u8], size: (u32, u32)) -> Result<Option<Vec<bool>>, String> {
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(tiff_error)?;
    let mut number = 0;
    while decoder.more_images() {
        decoder.next_image().map_err(tiff_error)?;
        number += 1;
        let kind: u32 = decoder.find_tag_unsigned(Tag::NewSubfileType).ok().flatten().unwrap_or(0);
        if kind & MASK_BIT != 0 && kind & REDUCED_BIT == 0 && decoder.dimensions().ok() == Some(size) {
            return decode_mask(bytes, &mut decoder, number, size).map(Some);
        }
    }
    Ok(None)
}

/// Validity of each pixel by a separate mask file.
pub(super) fn mask_file(bytes: &[u8], size: (u32, u32)) -> Result<Vec<bool>, String> {
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(tiff_error)?;
    let found = decoder.dimensions().map_err(tiff_error)?;
    if found != size {
        return Err(format!(
            "has {} columns and {} rows, the raster {} and {}",
            found.0, found.1, size.0, size.1
        ));
    }
    decode_mask(bytes, &mut decoder, 0, size)
}

/// Decodes a validity mask: whether each pixel has a value.
fn decode_mask(
    bytes: &[u8],
    decoder: &mut TiffDecoder<'_>,
    number: usize,
    size: (u32, u32),
) -> Result<Vec<bool>, String> {
    let changed = without_palette(bytes, decoder);
    let mut decoder = Decoder::new(Cursor::new(changed.as_deref().unwrap_or(bytes))).map_err(tiff_error)?;
    decoder.seek_to_image(number).map_err(tiff_error)?;
    let (columns, rows) = (size.0 as usize, size.1 as usize);
    let kind = decoder.colortype().map_err(tiff_error)?;
    let DecodingResult::U8(values) = decoder.read_image().map_err(tiff_error)? else {
        return Err("has a mask whose values are neither bits nor bytes".to_owned());
    };
    match kind {
        ColorType::Gray(8) if values.len() == columns * rows => {
            Ok(values.iter().map(|value| *value != 0).collect())
        }
        ColorType::Gray(1) if values.len() == columns.div_ceil(8) * rows => {
            let bit = |k: usize| {
                let (row, column) = (k / columns, k % columns);
                values[row * columns.div_ceil(8) + column / 8] >> (7 - column % 8) & 1 == 1
            };
            Ok((0..columns * rows).map(bit).collect())
        }
        _ => Err("has a mask whose values are neither bits nor bytes".to_owned()),
    }
}
