//! Rasters as other programs write them: the metadata of a file are used, or the file is rejected by name.

use std::path::{Path, PathBuf};

use colluvium_points::Raster;
use colluvium_terrain::{read_raster, read_reference_system};

/// Tag of a TIFF with its values.
#[derive(Clone)]
enum Tag {
    /// Number of the tag, and its values as 16-bit integers.
    Short(u16, Vec<u16>),
    /// Number of the tag, and its values as 32-bit integers.
    Long(u16, Vec<u32>),
    /// Number of the tag, and its values in double precision.
    Double(u16, Vec<f64>),
    /// Number of the tag, and its text.
    Text(u16, String),
}

/// Bytes of numbers in the byte order of a file.
struct Bytes {
    is_big_endian: bool,
    all: Vec<u8>,
}

macro_rules! put {
    ($name:ident, $number:ty) => {
        fn $name(&mut self, value: $number) {
            self.all.extend(if self.is_big_endian { value.to_be_bytes() } else { value.to_le_bytes() });
        }
    };
}

impl Bytes {
    put!(short, u16);
    put!(long, u32);
    put!(double, f64);

    /// Image file directory with its tags, then the image of one strip and the values that do not fit into the directory.
    fn directory(&mut self, tags: &[Tag], image: &[u8], is_last: bool) {
        let mut tags = tags.to_vec();
        let (at, count) = (self.all.len(), tags.len() + 2);
        let mut free = (at + 2 + 12 * count + 4) as u32;
        tags.push(Tag::Long(273, vec![free]));
        tags.push(Tag::Long(279, vec![image.len() as u32]));
        free += image.len() as u32;
        let number = |tag: &Tag| match tag {
            Tag::Short(number, _) | Tag::Long(number, _) | Tag::Double(number, _) | Tag::Text(number, _) => {
                *number
            }
        };
        tags.sort_by_key(number);
        let mut rest = Bytes { is_big_endian: self.is_big_endian, all: Vec::new() };
        self.short(count as u16);
        for tag in &tags {
            let mut value = Bytes { is_big_endian: self.is_big_endian, all: Vec::new() };
            let (kind, length) = match tag {
                Tag::Short(_, all) => {
                    all.iter().for_each(|x| value.short(*x));
                    (3, all.len())
                }
                Tag::Long(_, all) => {
                    all.iter().for_each(|x| value.long(*x));
                    (4, all.len())
                }
                Tag::Double(_, all) => {
                    all.iter().for_each(|x| value.double(*x));
                    (12, all.len())
                }
                Tag::Text(_, text) => {
                    value.all = text.bytes().chain([0]).collect();
                    (2, text.len() + 1)
                }
            };
            self.short(number(tag));
            self.short(kind);
            self.long(length as u32);
            if value.all.len() <= 4 {
                value.all.resize(4, 0);
                self.all.extend(value.all);
            } else {
                self.long(free + rest.all.len() as u32);
                rest.all.extend(value.all);
            }
        }
        let next = free as usize + rest.all.len();
        self.long(if is_last { 0 } else { next as u32 });
        self.all.extend(image);
        self.all.extend(rest.all);
    }
}

/// Grid of 4 by 3 cells of 5 m in UTM zone 32.
fn placed(bits: u16, format: u16) -> Vec<Tag> {
    vec![
        Tag::Short(256, vec![4]),
        Tag::Short(257, vec![3]),
        Tag::Short(258, vec![bits]),
        Tag::Short(259, vec![1]),
        Tag::Short(262, vec![1]),
        Tag::Short(277, vec![1]),
        Tag::Short(278, vec![3]),
        Tag::Short(339, vec![format]),
        Tag::Double(33550, vec![5.0, 5.0, 0.0]),
        Tag::Double(33922, vec![0.0, 0.0, 0.0, 600_000.0, 5_000_015.0, 0.0]),
        keys(&[(3072, 25832), (3076, 9001)]),
    ]
}

/// Keys of a projected system whose pixels are areas.
fn keys(more: &[(u16, u16)]) -> Tag {
    let all: Vec<(u16, u16)> = [(1024, 1), (1025, 1)].iter().chain(more).copied().collect();
    let mut directory = vec![1, 1, 0, all.len() as u16];
    directory.extend(all.iter().flat_map(|(key, value)| [*key, 0, 1, *value]));
    Tag::Short(34735, directory)
}

fn without(tags: Vec<Tag>, number: u16) -> Vec<Tag> {
    tags.into_iter().filter(|tag| !matches!(tag, Tag::Short(n, _) if *n == number)).collect()
}

fn file(folder: &Path, name: &str, is_big_endian: bool, images: &[(Vec<Tag>, Vec<u8>)]) -> PathBuf {
    let mut bytes = Bytes { is_big_endian, all: if is_big_endian { b"MM" } else { b"II" }.to_vec() };
    bytes.short(42);
    bytes.long(8);
    for (number, (tags, image)) in images.iter().enumerate() {
        bytes.directory(tags, image, number + 1 == images.len());
    }
    let path = folder.join(name);
    std::fs::write(&path, bytes.all).unwrap();
    path
}

/// Image of the numbers 0 to 11, row by row from the north.
fn counted<const N: usize>(of: impl Fn(u8) -> [u8; N]) -> Vec<u8> {
    (0..12).flat_map(of).collect()
}

fn read(path: &Path) -> Raster {
    read_raster(path).unwrap()
}

#[test]
fn numbers_of_all_kinds_and_orders_of_bytes_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, big: bool, bits, format, image: Vec<u8>| {
        file(folder.path(), name, big, &[(placed(bits, format), image)])
    };
    let all = [
        file("u8.tif", false, 8, 1, counted(|x| [x])),
        file("i16.tif", true, 16, 2, counted(|x| i16::from(x).to_be_bytes())),
        file("u16.tif", false, 16, 1, counted(|x| u16::from(x).to_le_bytes())),
        file("f32.tif", true, 32, 3, counted(|x| f32::from(x).to_be_bytes())),
        file("f64.tif", false, 64, 3, counted(|x| f64::from(x).to_le_bytes())),
        file("i64.tif", false, 64, 2, counted(|x| i64::from(x).to_le_bytes())),
    ];
    for path in all {
        let raster = read(&path);
        assert_eq!((raster.origin, raster.spacing), ([600_002.5, 5_000_002.5], [5.0; 2]), "{path:?}");
        assert_eq!((raster.value(0, 2), raster.value(3, 2), raster.value(0, 0)), (0.0, 3.0, 8.0), "{path:?}");
        assert_eq!((raster.reference.epsg, raster.reference.undeclared_no_data), (Some(25832), 0));
    }
}

#[test]
fn palette_rasters_are_read_and_bit_or_multiband_rasters_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for big in [false, true] {
        let mut tags = without(placed(8, 1), 262);
        tags.extend([Tag::Short(262, vec![3]), Tag::Short(320, vec![0; 768])]);
        let path = file(folder.path(), "palette.tif", big, &[(tags, counted(|x| [x]))]);
        assert_eq!(read(&path).value(3, 2), 3.0);
    }
    let mut bands = without(placed(8, 1), 277);
    bands.push(Tag::Short(277, vec![2]));
    let path = file(folder.path(), "bands.tif", false, &[(bands, vec![0; 24])]);
    assert!(read_raster(&path).unwrap_err().problem.contains("several bands"));
    let path = file(folder.path(), "bits.tif", false, &[(placed(1, 1), vec![0; 3])]);
    assert!(read_raster(&path).unwrap_err().problem.contains("1 bits per number"));
}

#[test]
fn scale_offset_and_units_of_bands_and_heights_are_applied() {
    let folder = tempfile::tempdir().unwrap();
    let image = || counted(|x| i16::from(x).to_le_bytes());
    let with = |name: &str, tags: &[Tag]| {
        let tags = placed(16, 2).into_iter().chain(tags.to_vec()).collect();
        file(folder.path(), name, false, &[(tags, image())])
    };
    let item = |role: &str, value: &str| format!(r#"<Item name="x" sample="0" role="{role}">{value}</Item>"#);
    let metadata =
        |items: &[String]| Tag::Text(42112, format!("<GDALMetadata>{}</GDALMetadata>\n", items.concat()));
    let scaled = read(&with(
        "scaled.tif",
        &[metadata(&[item("offset", "50"), item("scale", "0.1")]), Tag::Text(42113, "3".to_owned())],
    ));
    // The no-data value is a number of the file, before scale and offset.
    assert!((scaled.value(1, 2) - 50.1).abs() < 1e-12 && scaled.value(3, 2).is_nan());
    let feet = read(&with("feet.tif", &[metadata(&[item("unittype", "ft")])]));
    assert!((feet.value(3, 0) - 11.0 * 0.3048).abs() < 1e-12);
    let degrees = read_raster(&with("degrees.tif", &[metadata(&[item("unittype", "degree")])])).unwrap_err();
    assert!(degrees.problem.contains("the unit \"degree\""), "{degrees}");
    let heights = |name: &str, more: &[(u16, u16)]| {
        let system = [&[(3072, 26910)], more].concat();
        let mut tags = without(placed(16, 2), 34735);
        tags.push(keys(&system));
        read_raster(&file(folder.path(), name, false, &[(tags, image())]))
    };
    // NAVD88 height (ftUS) by its code, and by the unit of the heights.
    for more in [&[(4096, 6360)][..], &[(4099, 9003)]] {
        let raster = heights("heights.tif", more).unwrap();
        assert!((raster.value(3, 0) - 11.0 * 1200.0 / 3937.0).abs() < 1e-12, "{more:?}");
    }
    assert_eq!(heights("metres.tif", &[(4096, 5703)]).unwrap().value(3, 0), 11.0);
    assert!(heights("depths.tif", &[(4096, 5715)]).unwrap_err().problem.contains("depths"));
    assert!(heights("plan.tif", &[(3076, 9003)]).unwrap_err().problem.contains("9003"));
}

#[test]
fn masked_pixels_have_no_data() {
    let folder = tempfile::tempdir().unwrap();
    let image = || counted(|x| f32::from(x).to_le_bytes());
    // Mask of bits: all but the second pixel of the first row and the last of the last.
    let mut mask = without(without(placed(1, 1), 262), 339);
    mask.extend([Tag::Long(254, vec![4]), Tag::Short(262, vec![4])]);
    let bits = vec![0b1011_0000, 0b1111_0000, 0b1110_0000];
    let path = file(folder.path(), "mask.tif", false, &[(placed(32, 3), image()), (mask, bits)]);
    let hidden = |raster: &Raster| {
        assert!(raster.value(1, 2).is_nan() && raster.value(3, 0).is_nan());
        assert_eq!(raster.values.iter().filter(|value| value.is_finite()).count(), 10);
        assert_eq!(raster.reference.undeclared_no_data, 0);
    };
    hidden(&read(&path));
    // Mask of bytes in a sidecar file.
    let path =
        file(folder.path(), "beside.tif", true, &[(placed(32, 3), counted(|x| f32::from(x).to_be_bytes()))]);
    assert_eq!(read(&path).value(1, 2), 1.0);
    let bytes = (0..12).map(|k| if k == 1 || k == 11 { 0 } else { 255 }).collect();
    file(folder.path(), "beside.tif.msk", true, &[(placed(8, 1), bytes)]);
    hidden(&read(&path));
}

#[test]
fn no_data_and_units_of_a_sidecar_file_apply_to_a_raster() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.asc");
    std::fs::write(&path, "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 5\n1 2\n-32768 4\n").unwrap();
    let about = "<PAMDataset><PAMRasterBand band=\"1\"><NoDataValue>-32768</NoDataValue><UnitType>ft</UnitType></PAMRasterBand></PAMDataset>";
    std::fs::write(folder.path().join("a.asc.aux.xml"), about).unwrap();
    let raster = read(&path);
    assert!(raster.value(0, 0).is_nan() && (raster.value(1, 0) - 4.0 * 0.3048).abs() < 1e-12);
    std::fs::write(folder.path().join("a.asc.aux.xml"), "<a></b>").unwrap();
    let error = read_raster(&path).unwrap_err();
    assert!(error.problem.contains("a.asc.aux.xml beside it cannot be read"), "{error}");
}

#[test]
fn world_and_prj_files_give_an_image_its_position_and_reference_system() {
    let folder = tempfile::tempdir().unwrap();
    let beside = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let mut tags = without(placed(64, 3), 34735);
    tags.retain(|tag| !matches!(tag, Tag::Double(33550 | 33922, _)));
    let path = file(folder.path(), "a.tif", false, &[(tags, counted(|n| f64::from(n).to_le_bytes()))]);
    assert!(read_raster(&path).unwrap_err().problem.contains("nor a world file .tfw"));
    beside("a.tfw", "5\n0\n0\n-5\n600002.5\n5000012.5\n");
    let raster = read(&path);
    assert_eq!(
        (raster.origin, raster.value(0, 2), raster.value(3, 0)),
        ([600_002.5, 5_000_002.5], 0.0, 11.0)
    );
    let system = |unit: &str| {
        format!(
            r#"PROJCS["a",GEOGCS["b",UNIT["degree",0.0174532925199433]],{unit},AUTHORITY["EPSG","25832"]]"#
        )
    };
    beside("a.prj", &system(r#"UNIT["metre",1]"#));
    assert_eq!(read(&path).reference.epsg, Some(25832));
    assert!(read_reference_system(&path).unwrap().to_string().contains("25832"));
    beside("a.prj", &system(r#"UNIT["foot",0.3048]"#));
    assert!(read_raster(&path).unwrap_err().problem.contains("foot"));
}

#[test]
fn texts_of_grids_are_read_as_programs_write_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.asc");
    let write = |bytes: &[u8]| std::fs::write(&path, bytes).unwrap();
    let head = "NCOLS 3\r\nNROWS 2\r\nXLLCORNER 10\r\nYLLCORNER 20\r\nCELLSIZE 2\r\n";
    let text = format!("# laser, Höhe\r\n{head}1 2\t-9999\r\n# a remark\r\n nan 5 1.#INF\r\n");
    let of = |raster: &Raster| {
        let numbers: Vec<f64> = raster.values.iter().copied().filter(|value| value.is_finite()).collect();
        (raster.origin, numbers, raster.reference.undeclared_no_data)
    };
    let right = ([11.0, 21.0], vec![5.0, 1.0, 2.0], 2);
    write(text.as_bytes());
    assert_eq!(of(&read(&path)), right);
    write(&[&[0xef, 0xbb, 0xbf], text.as_bytes()].concat());
    assert_eq!(of(&read(&path)), right, "UTF-8 with a mark of byte order");
    write(&text.chars().map(|c| c as u8).collect::<Vec<u8>>());
    assert_eq!(of(&read(&path)), right, "Latin-1");
    let pairs: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    write(&[&[0xff, 0xfe], &pairs[..]].concat());
    assert_eq!(of(&read(&path)), right, "UTF-16");
    // No-data values that have lost digits, or are stored in single precision.
    let marked = |mark: &str, value: &str| {
        write(format!("{head}NODATA_value {mark}\r\n1 2 {value}\r\n3 4 5\r\n").as_bytes());
        read(&path).value(2, 1).is_nan()
    };
    assert!(marked("-3.4028234663852886e+38", "-3.40282e+38") && marked("-9999.1", "-9999.10009765625"));
    assert!(marked("nan", "NaN") && !marked("-9999", "-9998.9") && !marked("0", "-9999"));
    write(format!("{head}1,5 2 3\r\n4 5 6\r\n").as_bytes());
    assert!(read_raster(&path).unwrap_err().problem.contains("decimal point"));
    write(b"DSAA\n2 2\n0 1\n0 1\n0 1\n1 2 3 4\n");
    assert!(read_raster(&path).unwrap_err().problem.contains("Surfer"));
    write(b"\0\0\0\0");
    assert!(read_raster(&path).unwrap_err().problem.contains("not text"));
}
