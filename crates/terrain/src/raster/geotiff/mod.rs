//! GeoTIFF rasters (OGC 19-008r4, GeoTIFF Standard 1.1).

mod geo_keys;
mod pixel_values;
mod validity_mask;

use std::io::{Cursor, Read, Seek};

use colluvium_points::{Georeference, Raster};
use tiff::decoder::Decoder;
use tiff::encoder::{TiffEncoder, colortype::Gray64Float};
use tiff::tags::Tag;

use crate::Problem;
use crate::raster::geotiff::geo_keys::{GeoKeys, PIXEL_IS_AREA, PIXEL_IS_POINT, key};
use crate::raster::world_file::WorldFile;
use crate::raster_band::{BandMetadata, parse_number};

/// Tag of the GDAL metadata (XML).
const GDAL_METADATA: Tag = Tag::Unknown(42112);

/// Decoder of a TIFF in memory.
type TiffDecoder<'a> = Decoder<Cursor<&'a [u8]>>;

/// Error message of a TIFF that cannot be decoded.
#[allow(clippy::needless_pass_by_value, reason = "`map_err(wrong)` reads well")]
fn tiff_error(error: tiff::TiffError) -> String {
    let cure = match error {
        tiff::TiffError::UnsupportedError(_) => {
            "; write it as numbers of one band, with the compression DEFLATE or LZW or none"
        }
        _ => "",
    };
    format!("is not a readable TIFF: {error}{cure}")
}

/// Position of the first pixel (m), which is its corner or its centre by the raster type, and the steps per column and row (m).
fn placement(
    decoder: &mut TiffDecoder<'_>,
    world: Option<WorldFile>,
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
    if let Some(points) = tie.as_ref().ok().map(|tie| tie.len() / 6).filter(|points| *points > 1) {
        return Err(format!(
            "has {points} ground control points: warp it to a grid along east and north, for example with gdalwarp"
        ));
    }
    let (Ok(scale), Ok(tie)) = (scale, tie) else {
        let problem = "has no georeference (neither pixel scale with tie point nor transformation, nor a world file .tfw \
                       beside it): write it as a GeoTIFF";
        let WorldFile { first, step } = world.ok_or(problem)?;
        let shift = if corner { 0.5 } else { 0.0 };
        return Ok(([first[0] - shift * step[0], first[1] - shift * step[1]], step));
    };
    if scale.len() < 2 || tie.len() < 6 {
        return Err("its pixel scale or tie point is too short".to_owned());
    }
    let step = [scale[0], -scale[1]];
    Ok(([tie[3] - tie[0] * step[0], tie[4] - tie[1] * step[1]], step))
}

/// Horizontal coordinate reference system: EPSG code, and name or text.
pub(crate) fn read_reference_system(
    source: impl Read + Seek,
) -> Result<(Option<u32>, Option<String>), String> {
    let keys = GeoKeys::read(&mut Decoder::new(source).map_err(tiff_error)?);
    let citation = keys.citation().map(str::to_owned);
    let is_text = citation.as_deref().is_some_and(crate::projection::well_known_text::is_well_known);
    let defined = keys.user_defined_text().filter(|_| keys.epsg().is_none() && !is_text);
    Ok((keys.epsg(), defined.or(citation)))
}

/// Sidecar files of a GeoTIFF.
#[derive(Default)]
pub(crate) struct GeotiffSidecars {
    /// Band metadata of the `.aux.xml`.
    pub(crate) band: BandMetadata,
    /// Validity mask of the `.msk`.
    pub(crate) mask: Option<Vec<u8>>,
    /// Placement by a world file, where the GeoTIFF has none.
    pub(crate) world: Option<WorldFile>,
}

/// Parses a raster of one band, with its sidecar files `beside`.
pub(crate) fn parse(bytes: &[u8], beside: GeotiffSidecars) -> Result<Raster, Problem> {
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(tiff_error)?;
    let size = decoder.dimensions().map_err(tiff_error)?;
    let (columns, rows) = (size.0 as usize, size.1 as usize);
    let keys = GeoKeys::read(&mut decoder);
    keys.check_metres().map_err(Problem::coded("crs-not-metres"))?;
    let heights = keys.height_unit().map_err(Problem::coded("crs-not-metres"))?;
    let corner = keys.get(key::RASTER_TYPE) != Some(PIXEL_IS_POINT);
    let (start, step) =
        placement(&mut decoder, beside.world, corner).map_err(Problem::coded("no-georeference"))?;
    if !(step[0] > 0.0 && step[1] != 0.0) {
        return Err(Problem::coded("no-georeference")(format!(
            "its columns and rows advance by {step:?} m, but columns must go east and rows north or south: \
             resample it to such a grid"
        )));
    }
    let mut band = band(&mut decoder)?.completed_by(beside.band);
    let mut values = pixel_values::pixel_values(bytes, decoder, band.no_data.unwrap_or(0.0))?;
    if values.len() != columns * rows {
        return Err(Problem::coded("unsupported-format")(format!(
            "has {} values for {columns} columns and {rows} rows: it must have one band",
            values.len()
        )));
    }
    let beside = (beside.mask).map(|mask| {
        validity_mask::mask_file(&mask, size).map_err(|problem| format!(".msk beside it: {problem}"))
    });
    if let Some(valid) = beside.transpose()?.or(validity_mask::embedded_mask(bytes, size)?) {
        // Masked pixels have no data, whatever their value.
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
        reference: Georeference {
            epsg: keys.epsg(),
            crs,
            pixel_is_area: corner,
            geo_keys: keys.plan_keys(),
            ..Georeference::default()
        },
    };
    band.apply(&mut raster, heights)?;
    Ok(raster)
}

/// Band metadata of the tags of the file.
fn band(decoder: &mut TiffDecoder<'_>) -> Result<BandMetadata, String> {
    let metadata = decoder.get_tag_ascii_string(GDAL_METADATA).ok();
    let citation = metadata.map(|text| BandMetadata::from_xml(text.trim_end_matches('\0')));
    let mut band = citation
        .transpose()
        .map_err(|problem| format!("its metadata of GDAL {problem}"))?
        .unwrap_or_default();
    if let Ok(text) = decoder.get_tag_ascii_string(Tag::GdalNodata) {
        let problem = || format!("its no-data value is {text:?}, not a number");
        band.no_data = Some(parse_number(&text).ok_or_else(problem)?);
    }
    Ok(band)
}

/// Bytes of a GeoTIFF with 64 bits per value.
pub(crate) fn encode(raster: &Raster) -> Result<Vec<u8>, String> {
    let failed = |error: tiff::TiffError| format!("cannot be written: {error}");
    let side =
        |count: usize| u32::try_from(count).map_err(|_| format!("{count} nodes in a row are too many"));
    let (columns, rows) = (side(raster.columns)?, side(raster.rows)?);
    let Raster { origin, spacing: [dx, dy], reference, .. } = raster;
    let no_data = reference.no_data.unwrap_or(-9999.0);
    let shift = if reference.pixel_is_area { 0.5 } else { 0.0 };
    let north = raster.last_node_position()[1] + shift * dy;
    let tie = [0.0, 0.0, 0.0, origin[0] - shift * dx, north, 0.0];
    let kind = if reference.pixel_is_area { PIXEL_IS_AREA } else { PIXEL_IS_POINT };
    let (directory, numbers, texts) = GeoKeys::from_georeference(reference, kind).encoded();
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
    if !numbers.is_empty() {
        head.write_tag(Tag::GeoDoubleParamsTag, &numbers[..]).map_err(failed)?;
    }
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
    use colluvium_points::GeoKey;
    use geo_keys::GEOGRAPHIC_MODEL;

    fn parse(bytes: &[u8]) -> Result<Raster, String> {
        super::parse(bytes, GeotiffSidecars::default()).map_err(|problem| problem.text)
    }

    fn raster(corner: bool) -> Raster {
        let mut raster =
            Raster::from_function([4, 3], [500_000.5, 5e6], [2.0, 2.5], |x, y| 0.1 * x - 1e-3 * y);
        raster.values[5] = f64::NAN;
        raster.reference = Georeference {
            epsg: Some(25832),
            crs: Some("ETRS89 / UTM zone 32N".to_owned()),
            pixel_is_area: corner,
            no_data: Some(-9999.0),
            undeclared_no_data: 0,
            huge_values: 0,
            geo_keys: Vec::new(),
        };
        raster
    }

    #[test]
    fn a_raster_is_read_back_with_all_digits_and_its_georeference() {
        for corner in [true, false] {
            let raster = raster(corner);
            let back = parse(&encode(&raster).unwrap()).unwrap();
            assert_eq!((back.columns, back.rows, back.spacing), (4, 3, raster.spacing));
            assert_eq!(back.reference, raster.reference);
            assert!((0..2).all(|c| (back.origin[c] - raster.origin[c]).abs() < 1e-9));
            let same = |(a, b): (&f64, &f64)| a == b || a.is_nan() && b.is_nan();
            assert!(back.values.iter().zip(&raster.values).all(same));
        }
    }

    /// Bytes of a small TIFF with these GeoKeys and this placement.
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
            // An incomplete placement does not count.
            let bytes = file(&keys, Tag::ModelPixelScaleTag, &[9.0; 3]);
            let world = Some(WorldFile { first: [10.0, 20.0], step: [2.0, -2.0] });
            let placed =
                super::parse(&bytes, GeotiffSidecars { world, ..GeotiffSidecars::default() }).unwrap();
            assert_eq!((placed.origin, placed.spacing, placed.value(0, 1)), ([10.0, 18.0], [2.0; 2], 1.0));
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
        assert_eq!((straight.origin, straight.value(0, 0), straight.value(0, 1)), ([10.0, 18.0], 3.0, 1.0));
        let problem = |keys: &[u16], numbers: &[f64]| {
            parse(&file(keys, Tag::ModelTransformationTag, numbers)).unwrap_err()
        };
        assert!(problem(&keys(key::MODEL_TYPE, GEOGRAPHIC_MODEL), &transform).contains("degrees"));
        assert!(problem(&keys(key::LINEAR_UNITS, 9003), &transform).contains("9003"));
        // Rows from south to north.
        (transform[5], transform[7]) = (2.0, 18.0);
        let turned = parse(&file(&point, Tag::ModelTransformationTag, &transform)).unwrap();
        assert_eq!((turned.origin, turned.value(0, 0), turned.value(0, 1)), ([10.0, 18.0], 1.0, 3.0));
        transform[0] = -2.0;
        assert!(problem(&point, &transform).contains("columns must go east"));
        transform[1] = 0.5;
        assert!(problem(&point, &transform).contains("rotated"));
        assert!(
            parse(&file(&point, Tag::ModelPixelScaleTag, &[1.0; 3])).unwrap_err().contains("no georeference")
        );
        let points = parse(&file(&point, Tag::ModelTiepointTag, &[1.0; 24])).unwrap_err();
        assert!(points.contains("has 4 ground control points: warp it"), "{points}");
        assert!(parse(b"not a tiff").is_err());
    }

    #[test]
    fn strips_without_data_have_the_no_data_value() {
        for (mark, expected) in [(Some("-9999"), f64::NAN), (None, 0.0)] {
            let mut target = Cursor::new(Vec::new());
            let mut encoder = TiffEncoder::new(&mut target).unwrap();
            let mut image = encoder.new_image::<Gray64Float>(2, 3).unwrap();
            image.rows_per_strip(2).unwrap();
            let head = image.encoder();
            head.write_tag(Tag::ModelPixelScaleTag, &[1.0, 1.0, 0.0][..]).unwrap();
            head.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, 10.0, 20.0, 0.0][..]).unwrap();
            if let Some(mark) = mark {
                head.write_tag(Tag::GdalNodata, mark).unwrap();
            }
            image.write_data(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]).unwrap();
            let mut bytes = target.into_inner();
            // Byte counts of the strips: 32 and 16.
            let lengths = [32u32, 16].map(u32::to_le_bytes).concat();
            let at = bytes.windows(8).rposition(|eight| eight == lengths).unwrap();
            bytes[at..at + 4].fill(0);
            let read = parse(&bytes).unwrap();
            assert_eq!((read.value(0, 0), read.value(1, 0)), (5.0, 6.0));
            for (column, row) in [(0, 1), (1, 1), (0, 2), (1, 2)] {
                let value: f64 = read.value(column, row);
                assert!(value == expected || value.is_nan() && expected.is_nan(), "{mark:?}: {value}");
            }
        }
    }

    #[test]
    fn written_geotiffs_name_only_the_horizontal_reference_system() {
        let texts = |crs: &str, epsg: Option<u32>| {
            let mut raster = raster(true);
            (raster.reference.crs, raster.reference.epsg) = (Some(crs.to_owned()), epsg);
            let bytes = encode(&raster).unwrap();
            let mut decoder = Decoder::new(Cursor::new(&bytes[..])).unwrap();
            let texts = decoder.get_tag_ascii_string(Tag::GeoAsciiParamsTag).unwrap_or_default();
            let keys = GeoKeys::read(&mut decoder);
            assert_eq!(keys.height_unit(), Ok(None), "{crs}");
            assert_eq!(keys.epsg(), epsg, "{crs}");
            // GDAL reads a text only where the model is user-defined, 32767.
            let is_text = texts.starts_with(geo_keys::ESRI_TEXT);
            assert_eq!(keys.get(key::MODEL_TYPE), Some(if is_text { 32767 } else { 1 }), "{crs}");
            texts
        };
        assert_eq!(texts("NAD83 / UTM zone 10N + NAVD88 height (ft)", Some(26910)), "NAD83 / UTM zone 10N|");
        let plan = r#"PROJCS["site [1]",UNIT["metre",1]]"#;
        let both = format!(r#"COMPD_CS["both (ft)",{plan},VERT_CS["NAVD88 height (ft)",UNIT["metre",1]]]"#);
        assert_eq!(texts(&both, None), format!("{}{plan}|", geo_keys::ESRI_TEXT));
        assert_eq!(texts(&both, Some(26910)), "site [1]|");
    }

    #[test]
    fn vertical_codes_override_citation_texts_and_the_default_unit_is_the_metre() {
        let unit = |numbers: &[(u16, u16)], citation: &str| {
            let all = numbers.iter().map(|(number, code)| (*number, GeoKey::Code(*code)));
            let words = (key::CITATION, GeoKey::Text(citation.to_owned()));
            GeoKeys::from_pairs(all.chain([words]).collect()).height_unit()
        };
        let feet = "NAD83 / UTM zone 10N + NAVD88 height (ft)";
        assert_eq!(unit(&[], feet), Ok(Some(0.3048)));
        assert_eq!(unit(&[(key::VERTICAL, 5703)], feet), Ok(None));
        assert_eq!(unit(&[(key::VERTICAL, 8228)], "any"), Ok(Some(0.3048)));
        let own = [(key::VERTICAL, 32767), (key::VERTICAL_UNITS, 32767)];
        assert_eq!(unit(&own, "site"), Ok(None));
        assert_eq!(unit(&own, feet), Ok(Some(0.3048)));
        assert!(unit(&[(key::VERTICAL_UNITS, 9014)], "fathoms").is_err());
        assert_eq!(unit(&own, "site (2005) + depth of 2005 (m)"), Ok(Some(1.0)));
        for name in ["fathom", "Fathoms", "yd", "links", "ch", "degree"] {
            let named = format!("NAD83 / UTM zone 10N + site height ({name})");
            assert!(unit(&own, &named).unwrap_err().contains(name), "{named}");
            let plan = r#"PROJCS["site",UNIT["metre",1]]"#;
            let text = format!(r#"COMPD_CS["both",{plan},VERT_CS["height",UNIT["{name}",1.8288]]]"#);
            assert!(unit(&own, &text).unwrap_err().contains(name), "{text}");
        }
        let feet = r#"COMPD_CS["both",PROJCS["site",UNIT["metre",1]],VERT_CS["height",UNIT["foot",0.3048]]]"#;
        assert_eq!(unit(&own, feet), Ok(Some(0.3048)));
    }

    #[test]
    fn systems_whose_lengths_are_not_those_on_the_ground_are_refused() {
        let problem = |number: u16, value: u16| {
            let keys = [1, 1, 0, 2, number, 0, 1, value, key::LINEAR_UNITS, 0, 1, 9001];
            parse(&file(&keys, Tag::ModelTiepointTag, &[0.0; 6])).unwrap_err()
        };
        assert!(problem(key::PROJECTED, 3857).contains("Web Mercator"));
        for code in [3395, 6933, 4087] {
            assert!(problem(key::PROJECTED, code).contains("maps of the world"), "{code}");
        }
        assert!(problem(key::MODEL_TYPE, 3).contains("geocentric"));
        // Mercator, Equirectangular, Robinson and Sinusoidal by their parameters.
        for code in [7, 17, 23, 24] {
            let parameters = GeoKeys::from_pairs(vec![
                (key::METHOD, GeoKey::Code(code)),
                (3082, GeoKey::Numbers(vec![0.0])),
                (key::LINEAR_UNITS, GeoKey::Code(9001)),
            ]);
            assert!(parameters.check_metres().unwrap_err().contains("maps of the world"), "{code}");
        }
        for code in [3388, 25832, 2056, 31254, 3001] {
            assert!(problem(key::PROJECTED, code).contains("no georeference"), "{code} is taken");
        }
    }

    #[test]
    fn projection_parameters_are_read_back_without_vertical_ones() {
        let mut raster = raster(true);
        let own = vec![
            (2048, GeoKey::Code(4269)),
            (2057, GeoKey::Numbers(vec![6_378_137.0])),
            (3075, GeoKey::Code(11)),
            (3078, GeoKey::Numbers(vec![29.5])),
            (3080, GeoKey::Numbers(vec![-96.0, 1.0])),
        ];
        raster.reference =
            Georeference { crs: Some("Albers".to_owned()), geo_keys: own.clone(), ..raster.reference };
        raster.reference.epsg = None;
        let back = parse(&encode(&raster).unwrap()).unwrap().reference;
        assert!(own.iter().all(|key| back.geo_keys.contains(key)), "{:?}", back.geo_keys);
        assert_eq!(back.crs.as_deref(), Some("Albers"));
        // Reading the system alone finds the same projection.
        let (number, text) = read_reference_system(Cursor::new(encode(&raster).unwrap())).unwrap();
        let text = text.unwrap();
        assert!(number.is_none() && text.contains(r#"PROJECTION["Albers_Conic_Equal_Area"]"#), "{text}");
        assert!(
            text.contains(r#"PARAMETER["standard_parallel_1",29.5],PARAMETER["central_meridian",-96]"#),
            "{text}"
        );
        raster.reference.geo_keys.push((key::VERTICAL, GeoKey::Code(8228)));
        assert_eq!(parse(&encode(&raster).unwrap()).unwrap().reference.geo_keys, back.geo_keys);
    }
}
