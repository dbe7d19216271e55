//! GeoTIFF rasters (OGC 19-008r4, GeoTIFF Standard 1.1).

mod keys;
mod mask;

use std::io::{Cursor, Read, Seek};

use colluvium_points::{Georeference, Raster};
use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult};
use tiff::encoder::{TiffEncoder, colortype::Gray64Float};
use tiff::tags::Tag;

use crate::band::{Band, mark};
use crate::prj;
use crate::world_file::World;
use keys::{Keys, METRE, PIXEL_IS_AREA, PIXEL_IS_POINT, PROJECTED_MODEL, USER_DEFINED, key};

/// Tag of the metadata of GDAL, as XML.
const GDAL_METADATA: Tag = Tag::Unknown(42112);

type Source<'a> = Decoder<Cursor<&'a [u8]>>;

#[allow(clippy::needless_pass_by_value, reason = "`map_err(wrong)` reads well")]
fn wrong(error: tiff::TiffError) -> String {
    let cure = match error {
        tiff::TiffError::UnsupportedError(_) => {
            "; write it as numbers of one band, with the compression DEFLATE or LZW or none"
        }
        _ => "",
    };
    format!("is not a TIFF that can be read: {error}{cure}")
}

/// Place of the first pixel, its corner or its centre as the raster has it (m), and the steps per column and row.
fn placement(
    decoder: &mut Source<'_>,
    world: Option<World>,
    corner: bool,
) -> Result<([f64; 2], [f64; 2]), String> {
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
        let problem = "has no georeference (neither pixel scale with tie point nor transformation, nor a world file .tfw \
                       beside it): write it as a GeoTIFF";
        let World { first, step } = world.ok_or(problem)?;
        let shift = if corner { 0.5 } else { 0.0 };
        return Ok(([first[0] - shift * step[0], first[1] - shift * step[1]], step));
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

/// Coordinate reference system in plan: number in the EPSG registry, and name or text.
pub(crate) fn system(source: impl Read + Seek) -> Result<(Option<u32>, Option<String>), String> {
    let keys = Keys::read(&mut Decoder::new(source).map_err(wrong)?);
    Ok((keys.epsg(), keys.citation().map(str::to_owned)))
}

/// Files beside a GeoTIFF.
#[derive(Default)]
pub(crate) struct Beside {
    /// Meaning of the numbers, by `.aux.xml`.
    pub(crate) band: Band,
    /// Mask, by `.msk`.
    pub(crate) mask: Option<Vec<u8>>,
    /// Placement where the file has none itself.
    pub(crate) world: Option<World>,
}

/// Reads a raster of one band, with what files `beside` it say.
pub(crate) fn parse(bytes: &[u8], beside: Beside) -> Result<Raster, String> {
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(wrong)?;
    let size = decoder.dimensions().map_err(wrong)?;
    let (columns, rows) = (size.0 as usize, size.1 as usize);
    let keys = Keys::read(&mut decoder);
    keys.check_plan()?;
    let heights = keys.height_unit()?;
    let corner = keys.get(key::RASTER_TYPE) != Some(PIXEL_IS_POINT);
    let (start, step) = placement(&mut decoder, beside.world, corner)?;
    if !(step[0] > 0.0 && step[1] != 0.0) {
        return Err(format!(
            "its columns and rows go on by {step:?} m: columns must go east and rows north or south; resample it to such a grid"
        ));
    }
    let mut band = band(&mut decoder)?.or(beside.band);
    let mut values = numbers(image(bytes, decoder)?);
    if values.len() != columns * rows {
        return Err(format!(
            "has {} values for {columns} columns and {rows} rows: it must have one band",
            values.len()
        ));
    }
    let beside = (beside.mask)
        .map(|mask| mask::of_own_file(&mask, size).map_err(|problem| format!(".msk beside it: {problem}")));
    if let Some(valid) = beside.transpose()?.or(mask::of_file(bytes, size)?) {
        // What a mask takes away is no data, whatever stands there.
        let hole = *band.no_data.get_or_insert(f64::NAN);
        values.iter_mut().zip(valid).filter(|(_, valid)| !valid).for_each(|(value, _)| *value = hole);
    }
    let shift = if corner { 0.5 } else { 0.0 };
    let first = [start[0] + shift * step[0], start[1] + shift * step[1]];
    let lines = values.chunks(columns.max(1));
    let (south, values) = if step[1] < 0.0 {
        (first[1] + (rows.max(1) - 1) as f64 * step[1], lines.rev().flatten().copied().collect())
    } else {
        (first[1], values)
    };
    let crs = keys.citation().map(str::to_owned);
    let mut raster = Raster {
        columns,
        rows,
        origin: [first[0], south],
        spacing: [step[0], step[1].abs()],
        values,
        reference: Georeference { epsg: keys.epsg(), crs, corner, ..Georeference::default() },
    };
    band.apply(&mut raster, heights)?;
    Ok(raster)
}

/// Meaning of the numbers, by tags of the file.
fn band(decoder: &mut Source<'_>) -> Result<Band, String> {
    let metadata = decoder.get_tag_ascii_string(GDAL_METADATA).ok();
    let said = metadata.map(|text| Band::of_xml(text.trim_end_matches('\0')));
    let mut band =
        said.transpose().map_err(|problem| format!("its metadata of GDAL {problem}"))?.unwrap_or_default();
    if let Ok(text) = decoder.get_tag_ascii_string(Tag::GdalNodata) {
        let problem = || format!("its mark of no data is {text:?}, not a number");
        band.no_data = Some(mark(&text).ok_or_else(problem)?);
    }
    Ok(band)
}

/// The numbers of the image, those of classes with a palette of colours too.
fn image(bytes: &[u8], mut decoder: Source<'_>) -> Result<DecodingResult, String> {
    let meaning = decoder.find_tag_unsigned::<u32>(Tag::PhotometricInterpretation).ok().flatten();
    if meaning == Some(mask::PALETTE)
        && let Some(plain) = mask::as_numbers(bytes, &mut decoder)
    {
        let mut decoder = Decoder::new(Cursor::new(&plain[..])).map_err(wrong)?;
        return image_of(&mut decoder);
    }
    image_of(&mut decoder)
}

fn image_of(decoder: &mut Source<'_>) -> Result<DecodingResult, String> {
    match decoder.colortype().map_err(wrong)? {
        ColorType::Gray(bits) if bits < 8 => {
            Err(format!("has {bits} bits a number: write it with 8 bits or more"))
        }
        ColorType::Gray(_) => decoder.read_image().map_err(wrong),
        _ => {
            Err("has several bands or colours: write the one with the numbers to a file of its own"
                .to_owned())
        }
    }
}

fn numbers(image: DecodingResult) -> Vec<f64> {
    fn all<T: Into<f64>>(values: Vec<T>) -> Vec<f64> {
        values.into_iter().map(Into::into).collect()
    }
    match image {
        DecodingResult::U8(values) => all(values),
        DecodingResult::U16(values) => all(values),
        DecodingResult::U32(values) => all(values),
        DecodingResult::U64(values) => values.into_iter().map(|value| value as f64).collect(),
        DecodingResult::I8(values) => all(values),
        DecodingResult::I16(values) => all(values),
        DecodingResult::I32(values) => all(values),
        DecodingResult::I64(values) => values.into_iter().map(|value| value as f64).collect(),
        DecodingResult::F16(values) => all(values),
        DecodingResult::F32(values) => all(values),
        DecodingResult::F64(values) => values,
    }
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
        let head = if prj::is_well_known(crs) { keys::ESRI_TEXT } else { "" };
        texts = format!("{head}{crs}|");
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
    use keys::GEOGRAPHIC_MODEL;

    fn parse(bytes: &[u8]) -> Result<Raster, String> {
        super::parse(bytes, Beside::default())
    }

    fn raster(corner: bool) -> Raster {
        let mut raster =
            Raster::from_function([4, 3], [500_000.5, 5e6], [2.0, 2.5], |x, y| 0.1 * x - 1e-3 * y);
        raster.values[5] = f64::NAN;
        raster.reference = Georeference {
            epsg: Some(25832),
            crs: Some("ETRS89 / UTM zone 32N".to_owned()),
            corner,
            no_data: Some(-9999.0),
            unmarked: 0,
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
    fn a_world_file_places_the_centre_of_the_first_pixel() {
        for raster_type in [PIXEL_IS_AREA, PIXEL_IS_POINT] {
            let keys = [1, 1, 0, 1, key::RASTER_TYPE, 0, 1, raster_type];
            // Half of a placement is none.
            let bytes = file(&keys, Tag::ModelPixelScaleTag, &[9.0; 3]);
            let world = Some(World { first: [10.0, 20.0], step: [2.0, -2.0] });
            let placed = super::parse(&bytes, Beside { world, ..Beside::default() }).unwrap();
            assert_eq!((placed.origin, placed.spacing, placed.at(0, 1)), ([10.0, 18.0], [2.0; 2], 1.0));
        }
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
        // The same from the south on.
        (transform[5], transform[7]) = (2.0, 18.0);
        let turned = parse(&file(&point, Tag::ModelTransformationTag, &transform)).unwrap();
        assert_eq!((turned.origin, turned.at(0, 0), turned.at(0, 1)), ([10.0, 18.0], 1.0, 3.0));
        transform[0] = -2.0;
        assert!(problem(&point, &transform).contains("columns must go east"));
        transform[1] = 0.5;
        assert!(problem(&point, &transform).contains("rotated"));
        assert!(
            parse(&file(&point, Tag::ModelPixelScaleTag, &[1.0; 3])).unwrap_err().contains("no georeference")
        );
        assert!(parse(b"not a tiff").is_err());
    }
}
