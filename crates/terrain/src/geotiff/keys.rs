//! GeoKeys: what a GeoTIFF says of its coordinate reference system.

use std::io::{Read, Seek};

use tiff::decoder::Decoder;
use tiff::tags::Tag;

use crate::band::{BRITISH_FOOT, FOOT, SURVEY_FOOT};
use crate::{prj, projection};

/// Numbers of GeoKeys.
pub(super) mod key {
    pub(in super::super) const MODEL_TYPE: u16 = 1024;
    pub(in super::super) const RASTER_TYPE: u16 = 1025;
    pub(in super::super) const CITATION: u16 = 1026;
    pub(in super::super) const GEOGRAPHIC: u16 = 2048;
    pub(in super::super) const PROJECTED: u16 = 3072;
    pub(in super::super) const PROJECTED_CITATION: u16 = 3073;
    pub(in super::super) const LINEAR_UNITS: u16 = 3076;
    pub(in super::super) const VERTICAL: u16 = 4096;
    pub(in super::super) const VERTICAL_UNITS: u16 = 4099;
}

pub(super) const PROJECTED_MODEL: u16 = 1;
pub(super) const GEOGRAPHIC_MODEL: u16 = 2;
pub(super) const PIXEL_IS_AREA: u16 = 1;
pub(super) const PIXEL_IS_POINT: u16 = 2;
pub(super) const METRE: u16 = 9001;
/// Value of a key that the user defines.
pub(super) const USER_DEFINED: u16 = 32767;

/// Words before a well-known text in the citation of a GeoTIFF, by which Esri's programs and GDAL know it.
pub(super) const ESRI_TEXT: &str = "ESRI PE String = ";

/// Systems of heights of the EPSG registry in feet, and the metres in such a foot.
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

/// Systems of the EPSG registry that count depths downwards.
const DEPTHS: [u16; 52] = [
    5336, 5612, 5614, 5706, 5715, 5734, 5739, 5789, 5831, 5861, 5862, 5863, 5864, 5865, 5866, 5867, 5873,
    6357, 6358, 6359, 7976, 8051, 8053, 8358, 8378, 8897, 9287, 9288, 9672, 10150, 10151, 10349, 10364,
    10370, 10371, 10372, 10373, 10374, 10375, 10376, 10377, 10378, 10379, 10547, 10548, 10549, 10550, 10551,
    10552, 10649, 10650, 10678,
];

/// GeoKeys with their values: numbers that stand in the directory, and texts.
#[derive(Default)]
pub(super) struct Keys {
    numbers: Vec<(u16, u16)>,
    texts: Vec<(u16, String)>,
}

impl Keys {
    pub(super) fn read<R: Read + Seek>(decoder: &mut Decoder<R>) -> Self {
        let directory = decoder.get_tag_u16_vec(Tag::GeoKeyDirectoryTag).unwrap_or_default();
        let texts = decoder.get_tag_ascii_string(Tag::GeoAsciiParamsTag).unwrap_or_default();
        let mut keys = Self::default();
        for entry in directory.get(4..).unwrap_or_default().chunks_exact(4) {
            let [number, place, count, value] = [entry[0], entry[1], entry[2], entry[3]];
            if place == 0 {
                keys.numbers.push((number, value));
            } else if place == 34737 {
                let (from, to) = (usize::from(value), usize::from(value) + usize::from(count));
                if let Some(text) = texts.get(from..to.min(texts.len())) {
                    keys.texts.push((number, text.trim_end_matches(['|', '\0']).to_owned()));
                }
            }
        }
        keys
    }

    pub(super) fn get(&self, number: u16) -> Option<u16> {
        self.numbers.iter().find(|(key, _)| *key == number).map(|(_, value)| *value)
    }

    fn text(&self, number: u16) -> Option<&str> {
        self.texts.iter().find(|(key, _)| *key == number).map(|(_, text)| text.as_str())
    }

    /// Name or well-known text of the coordinate reference system.
    pub(super) fn citation(&self) -> Option<&str> {
        self.text(key::CITATION).map(|text| text.strip_prefix(ESRI_TEXT).unwrap_or(text))
    }

    /// Number of the coordinate reference system in plan in the EPSG registry.
    pub(super) fn epsg(&self) -> Option<u32> {
        self.get(key::PROJECTED).filter(|code| *code != USER_DEFINED && *code != 0).map(u32::from)
    }

    /// Refuses what does not lie in metres in plan.
    pub(super) fn check_plan(&self) -> Result<(), String> {
        let is_projected = self.get(key::PROJECTED).is_some();
        if self.get(key::MODEL_TYPE) == Some(GEOGRAPHIC_MODEL)
            || self.get(key::MODEL_TYPE).is_none() && self.get(key::GEOGRAPHIC).is_some() && !is_projected
        {
            return Err(
                "lies in degrees (a geographic CRS): project it to metres, for example to UTM".to_owned()
            );
        }
        match self.get(key::LINEAR_UNITS) {
            Some(METRE) => return Ok(()),
            Some(unit) => {
                return Err(format!(
                    "its CRS has the unit {unit} (EPSG) in plan, and only metres (9001) are known: project it to metres"
                ));
            }
            None => {}
        }
        // Without the key the unit is that of the system: by the EPSG registry, or by its name where it has no number.
        let citation = self.text(key::PROJECTED_CITATION).or(self.citation()).unwrap_or_default();
        let plan = citation.split(" + ").next().unwrap_or_default();
        let named = plan.contains("(ft") || plan.to_lowercase().contains("_feet");
        let own = self.citation().filter(|text| prj::is_well_known(text));
        match self.epsg().and_then(projection::text_of).or(own) {
            Some(text) if prj::is_web_mercator(text) => Err(prj::WEB_MERCATOR.to_owned()),
            Some(text) => match prj::other_unit(text) {
                Some(unit) => Err(format!(
                    "its CRS {plan:?} is in {unit:?}, and only metres are known in plan: project it to metres"
                )),
                None => Ok(()),
            },
            None if named => Err(format!(
                "its CRS {plan:?} is in feet, and only metres are known in plan: project it to metres"
            )),
            None => Ok(()),
        }
    }

    /// Metres in the unit of heights; `None` where nothing is said of them.
    ///
    /// # Errors
    /// Units that are not known, and depths.
    pub(super) fn height_unit(&self) -> Result<Option<f64>, String> {
        let system = self.get(key::VERTICAL);
        if let Some(code) = system.filter(|code| DEPTHS.contains(code)) {
            return Err(format!("its vertical CRS, EPSG:{code}, counts depths downwards: write heights"));
        }
        match self.get(key::VERTICAL_UNITS) {
            Some(METRE) => return Ok(Some(1.0)),
            Some(9002) => return Ok(Some(FOOT)),
            Some(9003) => return Ok(Some(SURVEY_FOOT)),
            Some(unit) => {
                return Err(format!(
                    "its CRS has the unit {unit} (EPSG) in height, and only metres (9001) and feet (9002, 9003) are known: \
                     write its heights in metres"
                ));
            }
            None => {}
        }
        if let Some((_, unit)) = HEIGHTS_IN_FEET.iter().find(|(code, _)| Some(*code) == system) {
            return Ok(Some(*unit));
        }
        let heights =
            self.citation().and_then(|citation| citation.split_once(" + ")).map(|(_, heights)| heights);
        Ok(heights
            .and_then(|heights| {
                [("(ftUS)", SURVEY_FOOT), ("(ft)", FOOT)].into_iter().find(|(end, _)| heights.contains(end))
            })
            .map(|(_, unit)| unit))
    }
}
