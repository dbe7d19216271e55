//! GeoTIFF rasters (OGC 19-008r4, GeoTIFF Standard 1.1).

use std::io::Cursor;

use colluvium_points::{Georeference, Raster};
use tiff::decoder::{Decoder, DecodingResult};
use tiff::encoder::{TiffEncoder, colortype::Gray64Float};
use tiff::tags::Tag;

/// Numbers of GeoKeys.
mod key {
    pub(super) const MODEL_TYPE: u16 = 1024;
    pub(super) const RASTER_TYPE: u16 = 1025;
    pub(super) const CITATION: u16 = 1026;
    pub(super) const PROJECTED: u16 = 3072;
    pub(super) const LINEAR_UNITS: u16 = 3076;
    pub(super) const VERTICAL_UNITS: u16 = 4099;
}

const PROJECTED_MODEL: u16 = 1;
const GEOGRAPHIC_MODEL: u16 = 2;
const PIXEL_IS_AREA: u16 = 1;
const PIXEL_IS_POINT: u16 = 2;
const METRE: u16 = 9001;
/// What stands where a key's value is the user's own.
const USER_DEFINED: u16 = 32767;

type Source<'a> = Decoder<Cursor<&'a [u8]>>;

/// GeoKeys with their values: numbers that stand in the directory, and texts.
#[derive(Default)]
struct Keys {
    numbers: Vec<(u16, u16)>,
    citation: Option<String>,
}

impl Keys {
    fn read(decoder: &mut Source<'_>) -> Self {
        let directory = decoder.get_tag_u16_vec(Tag::GeoKeyDirectoryTag).unwrap_or_default();
        let texts = decoder.get_tag_ascii_string(Tag::GeoAsciiParamsTag).unwrap_or_default();
        let mut keys = Self::default();
        for entry in directory.get(4..).unwrap_or_default().chunks_exact(4) {
            let [number, place, count, value] = [entry[0], entry[1], entry[2], entry[3]];
            if place == 0 {
                keys.numbers.push((number, value));
            } else if place == 34737 && number == key::CITATION {
                let (from, to) = (usize::from(value), usize::from(value) + usize::from(count));
                keys.citation =
                    texts.get(from..to.min(texts.len())).map(|t| t.trim_end_matches(['|', '\0']).to_owned());
            }
        }
        keys
    }

    fn get(&self, number: u16) -> Option<u16> {
        self.numbers.iter().find(|(key, _)| *key == number).map(|(_, value)| *value)
    }

    /// Refuses what is not in metres.
    fn check_units(&self) -> Result<(), String> {
        if self.get(key::MODEL_TYPE) == Some(GEOGRAPHIC_MODEL) {
            return Err(
                "lies in degrees (a geographic CRS): project it to metres, for example to UTM".to_owned()
            );
        }
        for (number, what) in [(key::LINEAR_UNITS, "plan"), (key::VERTICAL_UNITS, "height")] {
            if let Some(unit) = self.get(number).filter(|unit| *unit != METRE) {
                return Err(format!(
                    "its CRS has the unit {unit} (EPSG) in {what}, and only metres (9001) are known: project it to metres"
                ));
            }
        }
        Ok(())
    }
}

/// Where the node of the first pixel is (m), and the steps per column and row.
fn placement(decoder: &mut Source<'_>) -> Result<([f64; 2], [f64; 2]), String> {
    if let Ok(m) = decoder.get_tag_f64_vec(Tag::ModelTransformationTag) {
        if m.len() != 16 {
            return Err(format!("its transformation has {} numbers, not 16", m.len()));
        }
        if m[1] != 0.0 || m[4] != 0.0 {
            return Err("is rotated: resample it to a grid along east and north".to_owned());
        }
        return Ok(([m[3], m[7]], [m[0], m[5]]));
    }
    let scale = decoder.get_tag_f64_vec(Tag::ModelPixelScaleTag);
    let tie = decoder.get_tag_f64_vec(Tag::ModelTiepointTag);
    let (Ok(scale), Ok(tie)) = (scale, tie) else {
        return Err("has no georeference (neither pixel scale with tie point nor transformation)".to_owned());
    };
    if scale.len() < 2 || tie.len() < 6 {
        return Err("its pixel scale or tie point is too short".to_owned());
    }
    if tie.len() > 6 {
        return Err("has several tie points: resample it to a regular grid".to_owned());
    }
    let step = [scale[0], -scale[1]];
    Ok(([tie[3] - tie[0] * step[0], tie[4] - tie[1] * step[1]], step))
}

/// Reads a raster of one band.
pub(crate) fn parse(bytes: &[u8]) -> Result<Raster, String> {
    let wrong = |error: tiff::TiffError| format!("is not a TIFF that can be read: {error}");
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(wrong)?;
    let (columns, rows) = decoder.dimensions().map_err(wrong)?;
    let (columns, rows) = (columns as usize, rows as usize);
    let keys = Keys::read(&mut decoder);
    keys.check_units()?;
    let (start, step) = placement(&mut decoder)?;
    if !(step[0] > 0.0 && step[1] < 0.0) {
        return Err(format!("its steps of {step:?} m do not go east and south"));
    }
    let no_data = decoder.get_tag_ascii_string(Tag::GdalNodata).ok();
    let no_data = no_data.and_then(|text| text.trim_matches(['\0', ' ']).parse::<f64>().ok());
    let values = numbers(decoder.read_image().map_err(wrong)?)?;
    if values.len() != columns * rows {
        return Err(format!(
            "has {} values for {columns} columns and {rows} rows: it must have one band",
            values.len()
        ));
    }
    let known = |value: &f64| if Some(*value) == no_data || !value.is_finite() { f64::NAN } else { *value };
    let corner = keys.get(key::RASTER_TYPE) != Some(PIXEL_IS_POINT);
    let shift = if corner { 0.5 } else { 0.0 };
    let north = start[1] + shift * step[1];
    let epsg = keys.get(key::PROJECTED).filter(|code| *code != USER_DEFINED && *code != 0);
    Ok(Raster {
        columns,
        rows,
        origin: [start[0] + shift * step[0], north + (rows.max(1) - 1) as f64 * step[1]],
        spacing: [step[0], -step[1]],
        values: values.chunks(columns.max(1)).rev().flatten().map(known).collect(),
        reference: Georeference { epsg: epsg.map(u32::from), crs: keys.citation, corner, no_data },
    })
}

fn numbers(image: DecodingResult) -> Result<Vec<f64>, String> {
    fn all<T: Into<f64>>(values: Vec<T>) -> Vec<f64> {
        values.into_iter().map(Into::into).collect()
    }
    Ok(match image {
        DecodingResult::U8(values) => all(values),
        DecodingResult::U16(values) => all(values),
        DecodingResult::U32(values) => all(values),
        DecodingResult::I8(values) => all(values),
        DecodingResult::I16(values) => all(values),
        DecodingResult::I32(values) => all(values),
        DecodingResult::F32(values) => all(values),
        DecodingResult::F64(values) => values,
        _ => {
            return Err(
                "its numbers have 16 bits with a point or 64 without: write it with 32 bits".to_owned()
            );
        }
    })
}

/// The bytes of a raster with 64 bits a number.
pub(crate) fn bytes(raster: &Raster) -> Result<Vec<u8>, String> {
    let failed = |error: tiff::TiffError| format!("cannot be written: {error}");
    let side =
        |count: usize| u32::try_from(count).map_err(|_| format!("{count} nodes in a row are too many"));
    let (columns, rows) = (side(raster.columns)?, side(raster.rows)?);
    let Raster { origin, spacing: [dx, dy], reference, .. } = raster;
    let no_data = reference.no_data.unwrap_or(-9999.0);
    let shift = if reference.corner { 0.5 } else { 0.0 };
    let north = raster.end()[1] + shift * dy;
    let tie = [0.0, 0.0, 0.0, origin[0] - shift * dx, north, 0.0];
    let mut keys = vec![(key::MODEL_TYPE, 0, 1, PROJECTED_MODEL)];
    let kind = if reference.corner { PIXEL_IS_AREA } else { PIXEL_IS_POINT };
    keys.push((key::RASTER_TYPE, 0, 1, kind));
    let mut texts = String::new();
    if let Some(crs) = reference.crs.as_deref().filter(|crs| crs.is_ascii()) {
        texts = format!("{crs}|");
        keys.push((key::CITATION, 34737, texts.len() as u16, 0));
    }
    let epsg = reference.epsg.and_then(|code| u16::try_from(code).ok());
    keys.push((key::PROJECTED, 0, 1, epsg.unwrap_or(USER_DEFINED)));
    keys.push((key::LINEAR_UNITS, 0, 1, METRE));
    let mut directory = vec![1, 1, 0, keys.len() as u16];
    directory.extend(keys.iter().flat_map(|(a, b, c, d)| [*a, *b, *c, *d]));
    let data: Vec<f64> = raster
        .values
        .chunks(raster.columns)
        .rev()
        .flatten()
        .map(|value| if value.is_finite() { *value } else { no_data })
        .collect();
    let mut target = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut target).map_err(failed)?;
    let mut image = encoder.new_image::<Gray64Float>(columns, rows).map_err(failed)?;
    let head = image.encoder();
    head.write_tag(Tag::ModelPixelScaleTag, &[*dx, *dy, 0.0][..]).map_err(failed)?;
    head.write_tag(Tag::ModelTiepointTag, &tie[..]).map_err(failed)?;
    head.write_tag(Tag::GeoKeyDirectoryTag, &directory[..]).map_err(failed)?;
    if !texts.is_empty() {
        head.write_tag(Tag::GeoAsciiParamsTag, &texts[..]).map_err(failed)?;
    }
    head.write_tag(Tag::GdalNodata, &no_data.to_string()[..]).map_err(failed)?;
    image.write_data(&data).map_err(failed)?;
    Ok(target.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn raster(corner: bool) -> Raster {
        let mut raster =
            Raster::from_function([4, 3], [500_000.5, 5e6], [2.0, 2.5], |x, y| 0.1 * x - 1e-3 * y);
        raster.values[5] = f64::NAN;
        raster.reference = Georeference {
            epsg: Some(25832),
            crs: Some("ETRS89 / UTM zone 32N".to_owned()),
            corner,
            no_data: Some(-9999.0),
        };
        raster
    }

    #[test]
    fn a_raster_comes_back_with_all_its_digits_and_its_georeference() {
        for corner in [true, false] {
            let raster = raster(corner);
            let back = parse(&bytes(&raster).unwrap()).unwrap();
            assert_eq!((back.columns, back.rows, back.spacing), (4, 3, raster.spacing));
            assert_eq!(back.reference, raster.reference);
            assert!((0..2).all(|c| (back.origin[c] - raster.origin[c]).abs() < 1e-9));
            let same = |(a, b): (&f64, &f64)| a == b || a.is_nan() && b.is_nan();
            assert!(back.values.iter().zip(&raster.values).all(same));
        }
    }

    /// A small TIFF with these GeoKeys and this placement.
    fn file(keys: &[u16], tag: Tag, numbers: &[f64]) -> Vec<u8> {
        let mut target = Cursor::new(Vec::new());
        let mut encoder = TiffEncoder::new(&mut target).unwrap();
        let mut image = encoder.new_image::<Gray64Float>(2, 2).unwrap();
        image.encoder().write_tag(tag, numbers).unwrap();
        image.encoder().write_tag(Tag::GeoKeyDirectoryTag, keys).unwrap();
        image.write_data(&[1.0, 2.0, 3.0, 4.0]).unwrap();
        target.into_inner()
    }

    #[test]
    fn rotated_rasters_degrees_and_feet_are_refused() {
        let keys = |number: u16, value: u16| vec![1, 1, 0, 1, number, 0, 1, value];
        let mut transform = [0.0; 16];
        (transform[0], transform[3], transform[5], transform[7], transform[15]) =
            (2.0, 10.0, -2.0, 20.0, 1.0);
        let point = keys(key::RASTER_TYPE, PIXEL_IS_POINT);
        let straight = parse(&file(&point, Tag::ModelTransformationTag, &transform)).unwrap();
        assert_eq!((straight.origin, straight.at(0, 0), straight.at(0, 1)), ([10.0, 18.0], 3.0, 1.0));
        let problem = |keys: &[u16], numbers: &[f64]| {
            parse(&file(keys, Tag::ModelTransformationTag, numbers)).unwrap_err()
        };
        assert!(problem(&keys(key::MODEL_TYPE, GEOGRAPHIC_MODEL), &transform).contains("degrees"));
        assert!(problem(&keys(key::LINEAR_UNITS, 9003), &transform).contains("9003"));
        transform[1] = 0.5;
        assert!(problem(&point, &transform).contains("rotated"));
        assert!(
            parse(&file(&point, Tag::ModelPixelScaleTag, &[1.0; 3])).unwrap_err().contains("no georeference")
        );
        assert!(parse(b"not a tiff").is_err());
    }
}
