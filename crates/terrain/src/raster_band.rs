//! Metadata of a raster band: scale, offset, unit and no-data value, from the metadata that GDAL writes into a GeoTIFF or into an
//! `.aux.xml` beside any raster.

use std::path::Path;

use colluvium_points::Raster;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

/// International foot (m).
pub(crate) const FOOT: f64 = 0.3048;
/// US survey foot (m).
pub(crate) const SURVEY_FOOT: f64 = 1200.0 / 3937.0;
/// British foot of 1895 (m).
pub(crate) const BRITISH_FOOT: f64 = 0.304_800_749_1;

/// Magnitude above which a number is no elevation, thickness or class. Programs mark no data with the largest single-precision number, to
/// six digits or more.
const NO_DATA_MAGNITUDE: f64 = 1e30;

/// Metadata of a band; `None` where the file does not state them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct BandMetadata {
    /// Value that stands for no data.
    pub(crate) no_data: Option<f64>,
    scale: Option<f64>,
    offset: Option<f64>,
    unit: Option<String>,
    /// Well-known text of the coordinate reference system.
    pub(crate) crs: Option<String>,
}

impl BandMetadata {
    /// Reads the metadata of the first band in an XML text of GDAL: in a TIFF, or in the file beside a raster.
    pub(crate) fn from_xml(text: &str) -> Result<Self, String> {
        let mut reader = Reader::from_str(text);
        let (mut band, mut key, mut is_first) = (Self::default(), String::new(), true);
        loop {
            let event = reader.read_event().map_err(|error| format!("cannot be read: {error}"))?;
            match event {
                Event::Eof => return Ok(band),
                Event::Start(tag) if tag.name().as_ref() == b"PAMRasterBand" => {
                    is_first = attribute(&tag, "band").is_none_or(|band| band == "1");
                }
                Event::End(tag) if tag.name().as_ref() == b"PAMRasterBand" => is_first = true,
                Event::Start(tag) => key = tag_meaning(&tag),
                Event::End(_) => key.clear(),
                Event::Text(text) if is_first && !key.is_empty() => {
                    let text = text.unescape().map_err(|error| format!("cannot be read: {error}"))?;
                    band.set_value(&key, text.trim())?;
                }
                _ => {}
            }
        }
    }

    /// Sets an item of the metadata of a band from its text.
    fn set_value(&mut self, key: &str, text: &str) -> Result<(), String> {
        let number = || {
            parse_number(text)
                .ok_or_else(|| format!("has the {key} {text:?} for its band, which is not a number"))
        };
        match key {
            "no-data value" => self.no_data = Some(number()?),
            "scale" => self.scale = Some(number()?),
            "offset" => self.offset = Some(number()?),
            "unit" => self.unit = Some(text.to_owned()),
            "srs" => self.crs = Some(text.to_owned()),
            _ => {}
        }
        Ok(())
    }

    /// Metadata with a no-data value only.
    pub(crate) fn with_no_data(no_data: Option<f64>) -> Self {
        Self { no_data, ..Self::default() }
    }

    /// Metadata of this band, completed by those of `other`.
    pub(crate) fn completed_by(self, other: Self) -> Self {
        Self {
            no_data: self.no_data.or(other.no_data),
            scale: self.scale.or(other.scale),
            offset: self.offset.or(other.offset),
            unit: self.unit.or(other.unit),
            crs: self.crs.or(other.crs),
        }
    }

    /// Converts the numbers of a file to metres. Values without data become NaN; so do other values that are not finite, which are counted
    /// in the reference. `vertical` is the unit of heights of the coordinate reference system (m), for a band without a unit.
    pub(crate) fn apply(&self, raster: &mut Raster, vertical: Option<f64>) -> Result<(), String> {
        let metres = match self.unit.as_deref().filter(|unit| !unit.trim().is_empty()) {
            Some(unit) => metres_per_unit(unit).ok_or_else(|| {
                format!(
                    "its band has the unit {unit:?}, but only metres and feet are supported: write it in \
                     metres"
                )
            })?,
            None => vertical.unwrap_or(1.0),
        };
        let (scale, offset) = (self.scale.unwrap_or(1.0), self.offset.unwrap_or(0.0));
        if !(scale.is_finite() && scale != 0.0 && offset.is_finite()) {
            return Err(format!(
                "its band has the scale {scale} and the offset {offset}, which give no finite values"
            ));
        }
        let (no_data, as_it_is) = (self.no_data, scale == 1.0 && offset == 0.0 && metres == 1.0);
        let reference = &mut raster.reference;
        reference.no_data = no_data.filter(|mark| mark.is_finite());
        for value in &mut raster.values {
            if no_data.is_some_and(|mark| is_no_data(*value, mark)) {
                *value = f64::NAN;
            } else if !value.is_finite() || value.abs() >= NO_DATA_MAGNITUDE {
                reference.huge_values += usize::from(!value.is_nan());
                *value = f64::NAN;
                reference.undeclared_no_data += 1;
            } else if !as_it_is {
                *value = (*value * scale + offset) * metres;
            }
        }
        if !as_it_is {
            // The no-data value is one of the numbers of the file, not of the converted ones.
            reference.no_data = None;
        }
        Ok(())
    }
}

/// Whether a number equals the no-data value in single precision, as most rasters are stored. Numbers beyond [`NO_DATA_MAGNITUDE`] may have
/// lost digits in a text and are compared by sign.
fn is_no_data(value: f64, mark: f64) -> bool {
    value == mark
        || value as f32 == mark as f32
        || value.is_nan() && mark.is_nan()
        || mark.abs() >= NO_DATA_MAGNITUDE
            && value.abs() >= NO_DATA_MAGNITUDE
            && (value < 0.0) == (mark < 0.0)
}

/// Number in a text: with a decimal point, or a word for NaN.
pub(crate) fn parse_number(text: &str) -> Option<f64> {
    let text = text.trim_matches(['\0', ' ', '\n', '\r', '\t']);
    let is_none = ["1.#", "-1.#", "+1.#"].iter().any(|start| text.starts_with(start));
    if is_none { Some(f64::NAN) } else { text.parse().ok() }
}

/// Size of a unit of length by its name (m).
pub(crate) fn metres_per_unit(unit: &str) -> Option<f64> {
    let plain: String = unit.to_lowercase().chars().filter(char::is_ascii_alphanumeric).collect();
    Some(match plain.as_str() {
        "m" | "metre" | "metres" | "meter" | "meters" => 1.0,
        "km" | "kilometre" | "kilometres" | "kilometer" | "kilometers" => 1e3,
        "dm" | "decimetre" | "decimeter" => 0.1,
        "cm" | "centimetre" | "centimetres" | "centimeter" | "centimeters" => 0.01,
        "mm" | "millimetre" | "millimetres" | "millimeter" | "millimeters" => 1e-3,
        "ft" | "foot" | "feet" | "internationalfoot" | "internationalfeet" => FOOT,
        "usft" | "ftus" | "sft" | "footus" | "usfoot" | "usfeet" | "ussurveyfoot" | "ussurveyfeet" => {
            SURVEY_FOOT
        }
        _ => return None,
    })
}

/// Names of other units of length and of angles, in the singular, as symbols and in full.
const OTHER_UNITS: [&str; 19] = [
    "fathom",
    "fath",
    "yard",
    "yd",
    "link",
    "lk",
    "chain",
    "ch",
    "rod",
    "mile",
    "mi",
    "nauticalmile",
    "inch",
    "in",
    "vara",
    "degree",
    "deg",
    "grad",
    "radian",
];

/// Whether a name is that of a unit of length or angle. Abbreviations of two letters count in lower case only: CH is Switzerland.
pub(crate) fn is_length(unit: &str) -> bool {
    let plain: String = unit.to_lowercase().chars().filter(char::is_ascii_alphanumeric).collect();
    let is_other = |other: &&str| plain == *other || plain.strip_suffix('s') == Some(other);
    let is_abbreviation = plain.len() < 3 && plain != unit;
    metres_per_unit(unit).is_some()
        || plain == "inches"
        || !is_abbreviation && OTHER_UNITS.iter().any(is_other)
}

/// Name of the band property in a tag; empty for other tags.
fn tag_meaning(tag: &BytesStart<'_>) -> String {
    let name = match tag.name().as_ref() {
        b"NoDataValue" => "no-data value",
        b"Scale" => "scale",
        b"Offset" => "offset",
        b"UnitType" => "unit",
        b"SRS" => "srs",
        b"Item" if attribute(tag, "sample").is_none_or(|sample| sample == "0") => {
            return match attribute(tag, "role").as_deref() {
                Some("unittype") => "unit".to_owned(),
                Some(role) => role.to_owned(),
                None => String::new(),
            };
        }
        _ => "",
    };
    name.to_owned()
}

/// Text of an attribute of an XML element.
fn attribute(tag: &BytesStart<'_>, name: &str) -> Option<String> {
    let found = tag.attributes().flatten().find(|attribute| attribute.key.as_ref() == name.as_bytes())?;
    Some(found.unescape_value().ok()?.into_owned())
}

/// Band metadata of the `.aux.xml` beside a raster.
pub(crate) fn sidecar_band(file: &Path) -> Result<BandMetadata, String> {
    let name = format!("{}.aux.xml", file.file_name().unwrap_or_default().to_string_lossy());
    let path = file.with_file_name(&name);
    if !path.is_file() {
        return Ok(BandMetadata::default());
    }
    let text = std::fs::read_to_string(&path);
    let text = text.map_err(|error| format!("{name} beside it cannot be read: {error}"))?;
    BandMetadata::from_xml(&text).map_err(|problem| format!("{name} beside it {problem}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_offset_and_unit_are_those_of_the_first_band() {
        let text = r#"<GDALMetadata><Item name="OFFSET" sample="0" role="offset">50</Item>
            <Item name="SCALE" sample="0" role="scale">0.1</Item><Item name="SCALE" sample="1" role="scale">7</Item>
            <Item name="UNITTYPE" sample="0" role="unittype">US survey foot</Item><Item name="AREA">&lt;x</Item></GDALMetadata>"#;
        let band = BandMetadata::from_xml(text).unwrap();
        assert_eq!(
            (band.scale, band.offset, band.unit.as_deref()),
            (Some(0.1), Some(50.0), Some("US survey foot"))
        );
        let beside = r#"<PAMDataset><SRS dataAxisToSRSAxisMapping="1,2">PROJCS["x"]</SRS><PAMRasterBand band="1">
            <NoDataValue le_hex_equiv="00">-32768</NoDataValue><UnitType>ft</UnitType></PAMRasterBand>
            <PAMRasterBand band="2"><Scale>3</Scale></PAMRasterBand></PAMDataset>"#;
        let beside = BandMetadata::from_xml(beside).unwrap();
        assert_eq!(
            (beside.no_data, beside.scale, beside.crs.as_deref()),
            (Some(-32768.0), None, Some("PROJCS[\"x\"]"))
        );
        let both = band.completed_by(beside);
        assert_eq!((both.no_data, both.scale), (Some(-32768.0), Some(0.1)));
        let mut raster =
            Raster::from_function([2, 1], [0.0; 2], [1.0; 2], |x, _| if x > 0.5 { -32768.0 } else { 30.0 });
        both.apply(&mut raster, Some(1.0)).unwrap();
        assert!((raster.values[0] - 53.0 * 1200.0 / 3937.0).abs() < 1e-12 && raster.values[1].is_nan());
        assert!(BandMetadata::from_xml("<a><b></a>").is_err());
        assert!(BandMetadata::from_xml("<Scale>one</Scale>").unwrap_err().contains("\"one\""));
    }

    #[test]
    fn no_data_is_compared_in_single_precision_and_non_length_units_are_refused() {
        assert!(
            is_no_data(-9999.0, -9999.0)
                && is_no_data(f64::from(0.1f32), 0.1)
                && is_no_data(-3.40282e38, f64::from(f32::MIN))
        );
        assert!(
            !is_no_data(3.40282e38, f64::from(f32::MIN))
                && !is_no_data(-9998.0, -9999.0)
                && !is_no_data(0.0, -9999.0)
        );
        let mut raster = Raster::from_function([2, 1], [0.0; 2], [1.0; 2], |x, _| x);
        let band = BandMetadata { unit: Some("degree".to_owned()), ..BandMetadata::default() };
        assert!(band.apply(&mut raster, None).unwrap_err().contains("\"degree\""));
        let band = BandMetadata { scale: Some(0.0), ..BandMetadata::default() };
        assert!(band.apply(&mut raster, None).is_err());
        raster.values[0] = f64::INFINITY;
        BandMetadata::default().apply(&mut raster, None).unwrap();
        assert!(
            raster.values[0].is_nan() && raster.values[1] == 1.0 && raster.reference.undeclared_no_data == 1
        );
        assert_eq!(raster.reference.huge_values, 1);
    }
}
