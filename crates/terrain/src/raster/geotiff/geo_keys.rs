//! GeoKeys: the coordinate reference system of a GeoTIFF.

use std::fmt::Write;
use std::io::{Read, Seek};

use colluvium_points::{GeoKey, Georeference};
use tiff::decoder::Decoder;
use tiff::tags::Tag;

use crate::projection::{map_projection, prj_file, well_known_text};
use crate::raster::geotiff::geo_keys::key::{PLAN_PARAMETERS, VERTICAL_KEYS};
use crate::raster_band;
use crate::raster_band::{BRITISH_FOOT, FOOT, SURVEY_FOOT};

/// Identifiers of GeoKeys.
pub(super) mod key {
    /// GeoKey of the kind of the coordinate system: projected, geographic or geocentric.
    pub(in crate::raster::geotiff) const MODEL_TYPE: u16 = 1024;
    /// GeoKey of the meaning of a pixel: area or point.
    pub(in crate::raster::geotiff) const RASTER_TYPE: u16 = 1025;
    /// GeoKey of the description of the whole reference system.
    pub(in crate::raster::geotiff) const CITATION: u16 = 1026;
    /// GeoKey of the EPSG code of the geographic system.
    pub(in crate::raster::geotiff) const GEOGRAPHIC: u16 = 2048;
    /// GeoKey of the EPSG code of the projected system.
    pub(in crate::raster::geotiff) const PROJECTED: u16 = 3072;
    /// GeoKey of the description of the projected system.
    pub(in crate::raster::geotiff) const PROJECTED_CITATION: u16 = 3073;
    /// GeoKey of the EPSG code of the unit of plane coordinates.
    pub(in crate::raster::geotiff) const LINEAR_UNITS: u16 = 3076;
    /// GeoKey of the size of a user-defined linear unit (m).
    pub(in crate::raster::geotiff) const LINEAR_UNIT_SIZE: u16 = 3077;
    /// GeoKeys of a user-defined projection: its code, its method and its parameters.
    pub(in crate::raster::geotiff) const PLAN_PARAMETERS: std::ops::Range<u16> = 3074..4096;
    /// GeoKey of the EPSG code of the angular unit.
    pub(in crate::raster::geotiff) const ANGLES: u16 = 2054;
    /// GeoKey of the semi-major axis of the ellipsoid.
    pub(in crate::raster::geotiff) const SEMI_MAJOR_AXIS: u16 = 2057;
    /// GeoKey of the EPSG code of the prime meridian.
    pub(in crate::raster::geotiff) const PRIME_MERIDIAN: u16 = 2051;
    /// GeoKey of the method of the projection.
    pub(in crate::raster::geotiff) const METHOD: u16 = 3075;
    /// GeoKey of the EPSG code of the vertical system.
    pub(in crate::raster::geotiff) const VERTICAL: u16 = 4096;
    /// GeoKey of the EPSG code of the unit of heights.
    pub(in crate::raster::geotiff) const VERTICAL_UNITS: u16 = 4099;
    /// GeoKeys of a vertical coordinate system.
    pub(in crate::raster::geotiff) const VERTICAL_KEYS: std::ops::Range<u16> = 4096..5120;
}

/// Kind of coordinate system: projected.
pub(super) const PROJECTED_MODEL: u16 = 1;
/// Kind of coordinate system: geographic.
pub(super) const GEOGRAPHIC_MODEL: u16 = 2;
/// Kind of coordinate system: geocentric.
const GEOCENTRIC_MODEL: u16 = 3;
/// Meaning of a pixel: its value belongs to its area.
pub(super) const PIXEL_IS_AREA: u16 = 1;
/// Meaning of a pixel: its value belongs to a point, the node.
pub(super) const PIXEL_IS_POINT: u16 = 2;
/// EPSG code of the metre.
pub(super) const METRE: u16 = 9001;
/// Code of a user-defined value of a GeoKey.
pub(super) const USER_DEFINED: u16 = 32767;

/// Prefix of a well-known text in the citation of a GeoTIFF, as Esri's programs and GDAL write it.
pub(super) const ESRI_TEXT: &str = "ESRI PE String = ";

/// Projection methods by their codes (OGC 19-008r4, annex C; map projections of GeoTIFF 1.0, section 6.3.3.3).
const METHODS: [(u16, &str); 20] = [
    (1, "Transverse_Mercator"),
    (3, "Hotine_Oblique_Mercator"),
    (7, "Mercator"),
    (8, "Lambert_Conformal_Conic_2SP"),
    (9, "Lambert_Conformal_Conic_1SP"),
    (10, "Lambert_Azimuthal_Equal_Area"),
    (11, "Albers_Conic_Equal_Area"),
    (12, "Azimuthal_Equidistant"),
    (14, "Stereographic"),
    (15, "Polar_Stereographic"),
    (16, "Oblique_Stereographic"),
    (17, "Equirectangular"),
    (18, "Cassini_Soldner"),
    (20, "Miller_Cylindrical"),
    (22, "Polyconic"),
    (23, "Robinson"),
    (24, "Sinusoidal"),
    (25, "Van_der_Grinten"),
    (26, "New_Zealand_Map_Grid"),
    (28, "Cylindrical_Equal_Area"),
];

/// GeoKeys of projection parameters.
const PARAMETERS: [(u16, &str); 18] = [
    (3078, "standard_parallel_1"),
    (3079, "standard_parallel_2"),
    (3080, "central_meridian"),
    (3081, "latitude_of_origin"),
    (3082, "false_easting"),
    (3083, "false_northing"),
    (3084, "longitude_of_origin"),
    (3085, "latitude_of_origin"),
    (3086, "false_easting"),
    (3087, "false_northing"),
    (3088, "longitude_of_center"),
    (3089, "latitude_of_center"),
    (3090, "false_easting"),
    (3091, "false_northing"),
    (3092, "scale_factor"),
    (3093, "scale_factor"),
    (3094, "azimuth"),
    (3095, "central_meridian"),
];

/// EPSG code of the degree.
const DEGREE: u16 = 9102;
/// EPSG code of the Greenwich meridian.
const GREENWICH: u16 = 8901;

/// Vertical systems of the EPSG registry in feet, and the size of such a foot (m).
const HEIGHTS_IN_FEET: [(u16, f64); 9] = [
    (5702, SURVEY_FOOT),
    (6360, SURVEY_FOOT),
    (8052, SURVEY_FOOT),
    (5754, BRITISH_FOOT),
    (6130, FOOT),
    (6131, FOOT),
    (6132, FOOT),
    (8050, FOOT),
    (8228, FOOT),
];

/// Vertical systems of the EPSG registry with depths, positive downwards.
const DEPTHS: [u16; 52] = [
    5336, 5612, 5614, 5706, 5715, 5734, 5739, 5789, 5831, 5861, 5862, 5863, 5864, 5865, 5866, 5867, 5873,
    6357, 6358, 6359, 7976, 8051, 8053, 8358, 8378, 8897, 9287, 9288, 9672, 10150, 10151, 10349, 10364,
    10370, 10371, 10372, 10373, 10374, 10375, 10376, 10377, 10378, 10379, 10547, 10548, 10549, 10550, 10551,
    10552, 10649, 10650, 10678,
];

/// GeoKeys with their values.
#[derive(Default)]
pub(super) struct GeoKeys(Vec<(u16, GeoKey)>);

/// TIFF tag of the numbers of GeoKeys.
const NUMBERS: u16 = 34736;
/// TIFF tag of the texts of GeoKeys.
const TEXTS: u16 = 34737;

impl GeoKeys {
    /// Reads the GeoKeys of a TIFF.
    pub(super) fn read<R: Read + Seek>(decoder: &mut Decoder<R>) -> Self {
        let directory = decoder.get_tag_u16_vec(Tag::GeoKeyDirectoryTag).unwrap_or_default();
        let numbers = decoder.get_tag_f64_vec(Tag::GeoDoubleParamsTag).unwrap_or_default();
        let texts = decoder.get_tag_ascii_string(Tag::GeoAsciiParamsTag).unwrap_or_default();
        let value = |entry: &[u16]| {
            let [number, place, count, value] = [entry[0], entry[1], entry[2], entry[3]];
            let (from, to) = (usize::from(value), usize::from(value) + usize::from(count));
            let found = match place {
                0 => GeoKey::Code(value),
                NUMBERS => GeoKey::Numbers(numbers.get(from..to)?.to_vec()),
                TEXTS => {
                    let text = texts.get(from..to.min(texts.len()))?;
                    GeoKey::Text(text.trim_end_matches(['|', '\0']).to_owned())
                }
                _ => return None,
            };
            Some((number, found))
        };
        Self(directory.get(4..).unwrap_or_default().chunks_exact(4).filter_map(value).collect())
    }

    /// GeoKeys of a raster with this georeference, in metres and without a vertical system, since the values need not be heights.
    pub(super) fn from_georeference(reference: &Georeference, raster_type: u16) -> Self {
        let mut all = vec![(key::RASTER_TYPE, GeoKey::Code(raster_type))];
        let in_plan = reference
            .epsg
            .map(|code| map_projection::epsg_well_known_text(code).and_then(prj_file::epsg).unwrap_or(code));
        let epsg = in_plan.and_then(|code| u16::try_from(code).ok());
        let crs = reference
            .crs
            .as_deref()
            .map(well_known_text::horizontal_part)
            .filter(|crs| crs.is_ascii() && !crs.contains('|'));
        let is_text = crs.is_some_and(well_known_text::is_well_known);
        let model = if is_text && epsg.is_none() { USER_DEFINED } else { PROJECTED_MODEL };
        all.push((key::MODEL_TYPE, GeoKey::Code(model)));
        match crs {
            // GDAL takes the text of a system from its citation in plan where the model is user-defined.
            Some(crs) if is_text && epsg.is_none() => {
                all.push((key::PROJECTED_CITATION, GeoKey::Text(format!("{ESRI_TEXT}{crs}"))));
            }
            Some(crs) => {
                let name =
                    if is_text { prj_file::system_name(crs).unwrap_or_default() } else { crs.to_owned() };
                all.push((key::CITATION, GeoKey::Text(name)));
            }
            None => {}
        }
        all.push((key::PROJECTED, GeoKey::Code(epsg.unwrap_or(USER_DEFINED))));
        all.push((key::LINEAR_UNITS, GeoKey::Code(METRE)));
        if epsg.is_none() && !is_text {
            let is_of_plan = |(number, _): &&(u16, GeoKey)| !VERTICAL_KEYS.contains(number);
            let is_new = |(number, _): &&(u16, GeoKey)| all.iter().all(|(key, _)| key != number);
            let own: Vec<_> = reference.geo_keys.iter().filter(is_of_plan).filter(is_new).cloned().collect();
            all.extend(own);
        }
        all.sort_by_key(|(number, _)| *number);
        Self(all)
    }

    /// Key directory, numbers and texts of a file.
    pub(super) fn encoded(&self) -> (Vec<u16>, Vec<f64>, String) {
        let (mut directory, mut numbers, mut texts) =
            (vec![1, 1, 0, self.0.len() as u16], Vec::new(), String::new());
        for (number, value) in &self.0 {
            let [place, count, value] = match value {
                GeoKey::Code(code) => [0, 1, *code],
                GeoKey::Numbers(own) => {
                    let from = numbers.len() as u16;
                    numbers.extend(own);
                    [NUMBERS, own.len() as u16, from]
                }
                GeoKey::Text(text) => {
                    let from = texts.len() as u16;
                    texts.extend([text, "|"]);
                    [TEXTS, text.len() as u16 + 1, from]
                }
            };
            directory.extend([*number, place, count, value]);
        }
        (directory, numbers, texts)
    }

    /// GeoKeys from their numbers and values.
    #[cfg(test)]
    pub(super) fn from_pairs(keys: Vec<(u16, GeoKey)>) -> Self {
        Self(keys)
    }

    /// Value of a GeoKey.
    fn value(&self, number: u16) -> Option<&GeoKey> {
        self.0.iter().find(|(key, _)| *key == number).map(|(_, value)| value)
    }

    /// Code that is the value of a GeoKey.
    pub(super) fn get(&self, number: u16) -> Option<u16> {
        match self.value(number)? {
            GeoKey::Code(code) => Some(*code),
            _ => None,
        }
    }

    /// Text that is the value of a GeoKey.
    fn text(&self, number: u16) -> Option<&str> {
        match self.value(number)? {
            GeoKey::Text(text) => Some(text),
            _ => None,
        }
    }

    /// Name or well-known text of the coordinate reference system.
    pub(super) fn citation(&self) -> Option<&str> {
        let citations = [key::CITATION, key::PROJECTED_CITATION].map(|number| self.text(number));
        let mut citations =
            citations.into_iter().flatten().map(|text| text.strip_prefix(ESRI_TEXT).unwrap_or(text));
        citations.clone().find(|text| well_known_text::is_well_known(text)).or_else(|| citations.next())
    }

    /// EPSG code of the horizontal coordinate reference system.
    pub(super) fn epsg(&self) -> Option<u32> {
        self.get(key::PROJECTED).filter(|code| *code != USER_DEFINED && *code != 0).map(u32::from)
    }

    /// Well-known text of the horizontal system that the keys define by a projection, with the parts that comparisons use.
    pub(super) fn user_defined_text(&self) -> Option<String> {
        let number = |key: u16| match self.value(key)? {
            GeoKey::Numbers(numbers) => numbers.first(),
            _ => None,
        };
        let method = self.get(key::METHOD)?;
        let (_, method) = METHODS.iter().find(|(code, _)| *code == method)?;
        let is_other = |key: u16, code: u16| self.get(key).is_some_and(|own| own != code);
        if is_other(key::ANGLES, DEGREE) || is_other(key::PRIME_MERIDIAN, GREENWICH) {
            return None;
        }
        let globe = number(key::SEMI_MAJOR_AXIS)
            .map_or_else(String::new, |a| format!(r#",SPHEROID["unknown",{a},298]"#));
        let mut text = format!(
            r#"PROJCS["{}",GEOGCS["unknown",DATUM["unknown"{globe}],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["{method}"]"#,
            self.citation().unwrap_or("user-defined").replace('"', " ")
        );
        for (key, name) in PARAMETERS {
            if let Some(value) = number(key) {
                let _ = write!(text, r#",PARAMETER["{name}",{value}]"#);
            }
        }
        text.push(']');
        Some(text)
    }

    /// Keys that define the horizontal system, where it has neither an EPSG code nor a text.
    pub(super) fn plan_keys(&self) -> Vec<(u16, GeoKey)> {
        let is_defined =
            self.0.iter().any(|(number, _)| PLAN_PARAMETERS.contains(number) && *number != key::LINEAR_UNITS);
        if self.epsg().is_some() || !is_defined || self.citation().is_some_and(well_known_text::is_well_known)
        {
            return Vec::new();
        }
        self.0.iter().filter(|(number, _)| !VERTICAL_KEYS.contains(number)).cloned().collect()
    }

    /// Reports an error where horizontal coordinates are not in metres.
    pub(super) fn check_metres(&self) -> Result<(), String> {
        let is_projected = self.get(key::PROJECTED).is_some();
        if self.get(key::MODEL_TYPE) == Some(GEOGRAPHIC_MODEL)
            || self.get(key::MODEL_TYPE).is_none() && self.get(key::GEOGRAPHIC).is_some() && !is_projected
        {
            return Err(
                "is in degrees (a geographic CRS): project it to metres, for example to UTM".to_owned()
            );
        }
        if self.get(key::MODEL_TYPE) == Some(GEOCENTRIC_MODEL) {
            return Err(well_known_text::GEOCENTRIC.to_owned());
        }
        let own = self.citation().filter(|text| well_known_text::is_well_known(text));
        let system = self.epsg().and_then(map_projection::epsg_well_known_text).or(own);
        let defined = self.user_defined_text();
        if let Some(fault) = system.or(defined.as_deref()).and_then(map_projection::length_distortion) {
            return Err(fault.to_owned());
        }
        let size = match self.value(key::LINEAR_UNIT_SIZE) {
            Some(GeoKey::Numbers(numbers)) => numbers.first().copied(),
            _ => None,
        };
        match self.get(key::LINEAR_UNITS) {
            Some(METRE) => return Ok(()),
            Some(USER_DEFINED) if size == Some(1.0) => return Ok(()),
            Some(unit) => {
                return Err(format!(
                    "its CRS has the unit {unit} (EPSG) in plan, but only metres (9001) are supported: \
                     project it to metres"
                ));
            }
            None => {}
        }
        // Without the key the unit is that of the system: by its EPSG code, or by its name where it has no code.
        let citation = self.text(key::PROJECTED_CITATION).or(self.citation()).unwrap_or_default();
        let plan = citation.split(" + ").next().unwrap_or_default();
        let brackets = plan.split('(').skip(1).filter_map(|part| Some(part.split_once(')')?.0));
        let other = brackets
            .filter(|word| raster_band::is_length(word) && raster_band::metres_per_unit(word) != Some(1.0))
            .last();
        let is_in_feet = plan.contains("(ft") || plan.to_lowercase().contains("_feet");
        let named = other.or(is_in_feet.then_some("feet"));
        match system {
            Some(text) => match prj_file::non_metre_unit(text) {
                Some(unit) => Err(format!(
                    "its CRS {plan:?} is in {unit:?}, but only metres are supported in plan: project it to \
                     metres"
                )),
                None => Ok(()),
            },
            None => match named {
                Some(unit) => Err(format!(
                    "its CRS {plan:?} is in {unit}, but only metres are supported in plan: project it to \
                     metres"
                )),
                None => Ok(()),
            },
        }
    }

    /// Size of the unit of heights (m); `None` where the file does not state it.
    ///
    /// # Errors
    /// Unknown units, and depths.
    pub(super) fn height_unit(&self) -> Result<Option<f64>, String> {
        let system = self.get(key::VERTICAL);
        if let Some(code) = system.filter(|code| DEPTHS.contains(code)) {
            return Err(format!("its vertical CRS, EPSG:{code}, has depths (downwards): write heights"));
        }
        match self.get(key::VERTICAL_UNITS) {
            Some(METRE) => return Ok(Some(1.0)),
            Some(9002) => return Ok(Some(FOOT)),
            Some(9003) => return Ok(Some(SURVEY_FOOT)),
            // A user-defined unit without further information: GDAL writes and reads it so for metres.
            Some(USER_DEFINED) => {}
            Some(unit) => {
                return Err(format!(
                    "its CRS has the unit {unit} (EPSG) in height, but only metres (9001) and feet (9002, \
                     9003) are supported: write its heights in metres"
                ));
            }
            None => {}
        }
        if let Some((_, unit)) = HEIGHTS_IN_FEET.iter().find(|(code, _)| Some(*code) == system) {
            return Ok(Some(*unit));
        }
        // A code takes precedence over texts, which may be those of the terrain from which a raster was computed.
        if system.is_some_and(|code| code != USER_DEFINED && code != 0) {
            return Ok(None);
        }
        let unknown = |unit: &str| {
            format!(
                "its CRS has heights in {unit:?}, but only metres and feet are supported: write its heights \
                 in metres"
            )
        };
        let Some(citation) = self.citation() else { return Ok(None) };
        if well_known_text::is_well_known(citation) {
            return match prj_file::height_unit(citation) {
                Some((unit, _)) => {
                    raster_band::metres_per_unit(&unit).map(Some).ok_or_else(|| unknown(&unit))
                }
                None => Ok(None),
            };
        }
        let Some((_, heights)) = citation.split_once(" + ") else { return Ok(None) };
        // Of the texts in brackets only a unit counts: a year may be there too.
        let brackets = heights.split('(').skip(1).filter_map(|part| Some(part.split_once(')')?.0));
        match brackets.filter(|word| raster_band::is_length(word)).last() {
            Some(unit) => raster_band::metres_per_unit(unit).map(Some).ok_or_else(|| unknown(unit)),
            None => Ok(None),
        }
    }
}
