//! Tests of the data of an animation and of its playback in a browser.

use base64::Engine;
use colluvium_case::{Field, FieldData, Snapshot};
use serde_json::Value;

use super::*;
use crate::MovingSurface;

/// Points on a circle that grows, with its radius as a value.
fn frame(time: f64, count: usize) -> Snapshot {
    let angle = |i: usize| i as f64 / count as f64 * std::f64::consts::TAU;
    let radius = 1.0 + time;
    let place = |i: usize| [radius * angle(i).cos(), radius * angle(i).sin(), 0.1 * angle(i)];
    let field = |name: &str, unit, values: Vec<f64>| Field {
        name: name.into(),
        unit,
        data: FieldData::Scalar(values),
    };
    let mut pressure: Vec<f64> = (0..count).map(|i| radius * angle(i)).collect();
    pressure[0] = f64::NAN;
    Snapshot {
        time,
        step: 0,
        ids: (0..count as u64).collect(),
        bodies: (0..count as u32).map(|i| i % 2).collect(),
        positions: (0..count).map(place).collect(),
        extents: vec![[0.1, 0.2, 0.1]; count],
        fields: vec![field("pressure", "Pa", pressure), field("depth", "m", vec![2.0; count])],
    }
}

fn frames(number: usize, count: usize) -> Vec<Snapshot> {
    (0..number).map(|k| frame(0.1 * k as f64, count)).collect()
}

fn panel<'a>(name: &str, frames: &'a [Snapshot]) -> Panel<'a> {
    Panel { name: name.into(), frames: frames.iter().collect(), frame_count: frames.len() }
}

fn view() -> View {
    let names = vec!["sand".to_owned(), "</script><b>".to_owned()];
    let classes = vec![PointClasses { name: "body".into(), names, of_body: vec![0, 1] }];
    View { axes: vec![0, 1], vertical_axis: 1, classes, bytes: DEFAULT_BYTES, ..View::default() }
}

fn bytes(value: &Value) -> Vec<u8> {
    base64::engine::general_purpose::STANDARD.decode(value.as_str().unwrap()).unwrap()
}

fn decode_words(value: &Value) -> Vec<u32> {
    bytes(value).as_chunks().0.iter().map(|pair| u32::from(u16::from_le_bytes(*pair))).collect()
}

#[test]
fn packed_numbers_are_recovered_within_half_a_quantisation_step() {
    for scale in [
        QuantisedRange::with_16_bits(-3.0, 7.0),
        QuantisedRange::coarse(1e5, 1.001e5),
        QuantisedRange::with_16_bits(1e-9, 2e-9),
    ] {
        for k in 0..=1000 {
            let value = scale.low + (scale.high - scale.low) * f64::from(k) / 1000.0;
            let back = scale.decode(scale.quantise(value));
            // Round-off of the numbers themselves beside the half step.
            let bound = 0.5 * scale.step() * (1.0 + 1e-6) + 4.0 * f64::EPSILON * value.abs();
            assert!((back - value).abs() <= bound, "{value} came back as {back}");
        }
        assert_eq!(scale.decode(scale.quantise(scale.high + 1.0)), scale.decode(scale.steps));
        assert!(scale.decode(scale.quantise(f64::NAN)).is_nan());
    }
}

#[test]
fn the_page_has_places_widths_and_values_of_every_frame() {
    let states = frames(5, 40);
    let data = Animation::from_panels(&[panel("a", &states)], &view()).unwrap().data;
    let low: Vec<f64> = serde_json::from_value(data["low"].clone()).unwrap();
    let high: Vec<f64> = serde_json::from_value(data["high"].clone()).unwrap();
    let names: Vec<&str> =
        data["fields"].as_array().unwrap().iter().map(|f| f["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["pressure", "body"], "the depth is the same everywhere");
    let field = &data["fields"][0];
    let scale = QuantisedRange::coarse(field["low"].as_f64().unwrap(), field["high"].as_f64().unwrap());
    for (frame, state) in data["panels"][0]["frames"].as_array().unwrap().iter().zip(&states) {
        let places = decode_words(&frame["x"]);
        let values = bytes(&frame["v"][0]);
        for (i, at) in state.positions.iter().enumerate() {
            for c in 0..2 {
                let scale = QuantisedRange::with_16_bits(low[c], high[c]);
                let back = scale.decode(places[2 * i + c]);
                assert!((back - at[c]).abs() <= 0.5001 * scale.step(), "{back} for {}", at[c]);
            }
            let value = state.scalars("pressure").unwrap()[i];
            let back = scale.decode(u32::from(values[i]));
            assert_eq!(back.is_nan(), value.is_nan());
            assert!(value.is_nan() || (back - value).abs() <= 0.5001 * scale.step(), "{back} for {value}");
        }
        assert_eq!(bytes(&frame["v"][1])[..4], [0, 1, 0, 1]);
    }
    // Widths that do not change are stored once.
    let width = QuantisedRange::with_16_bits(0.0, data["largest"].as_f64().unwrap());
    let widths = decode_words(&data["panels"][0]["frames"][0]["w"]);
    assert!((width.decode(widths[0]) - 0.1).abs() <= width.step() && width.decode(widths[1]) == 0.2);
    assert!(data["panels"][0]["frames"][1]["w"].is_null());
    assert_eq!(data["thinned"], "");
}

#[test]
fn omitted_points_and_frames_are_stated_and_the_choice_of_points_is_constant() {
    let states = frames(200, 3000);
    let small = View { bytes: 200_000, ..view() };
    let animation = Animation::from_panels(&[panel("a", &states)], &small).unwrap();
    assert!(animation.omission_note.starts_with("24 of 200 frames, one of "), "{}", animation.omission_note);
    let element = animation.element();
    assert!(element.len() < 400_000, "{} bytes", element.len());
    let counts: Vec<u64> = animation.data["panels"][0]["frames"]
        .as_array()
        .unwrap()
        .iter()
        .map(|f| f["n"].as_u64().unwrap())
        .collect();
    assert_eq!(counts.len(), 24);
    assert!(counts.iter().all(|n| *n == counts[0] && *n > 300), "{counts:?}");
    let times: Vec<f64> = serde_json::from_value(animation.data["times"].clone()).unwrap();
    assert_eq!((times[0], times[23]), (0.0, states[199].time));
    // A caller that left out frames gives their number.
    let some = Panel { frame_count: 999, ..panel("a", &states[..3]) };
    assert_eq!(Animation::from_panels(&[some], &view()).unwrap().omission_note, "3 of 999 frames");
}

#[test]
fn runs_side_by_side_have_one_time_and_one_scale() {
    let (many, few) = (frames(9, 10), frames(3, 10));
    let animation = Animation::from_panels(&[panel("a", &many), panel("b", &few)], &view()).unwrap();
    assert_eq!(animation.data["times"].as_array().unwrap().len(), 9);
    // The run that ends earlier stays at its last frame.
    assert_eq!(animation.data["panels"][1]["at"], serde_json::json!([0, 1, 2, 2, 2, 2, 2, 2, 2]));
    let high = animation.data["fields"][0]["high"].as_f64().unwrap();
    assert!(high > 10.0, "{high}: of the run that grows farther, whose last circle has 1.8 × 0.9 × 2π");
}

#[test]
fn names_are_escaped_and_single_or_empty_frames_give_no_animation() {
    let states = frames(2, 4);
    let element = Animation::from_panels(&[panel("</script>", &states)], &view()).unwrap().element();
    assert_eq!(element.matches("</script>").count(), 1, "{element}");
    assert!(Animation::from_panels(&[panel("a", &states[..1])], &view()).is_none());
    assert!(Animation::from_panels(&[], &view()).is_none());
    let empty = frames(2, 1).into_iter().map(|f| Snapshot {
        positions: vec![],
        extents: vec![],
        ids: vec![],
        bodies: vec![],
        fields: vec![],
        ..f
    });
    let empty: Vec<Snapshot> = empty.collect();
    assert!(Animation::from_panels(&[panel("a", &empty)], &view()).is_none());
}

/// Script that turns the page's players through their frames and puts the result into the page's title.
const DRIVER: &str = r#"
window.problems = [];
window.addEventListener("error", (event) => window.problems.push(event.message));
window.addEventListener("load", () => {
  const said = Array.from(document.querySelectorAll(".player")).map((root) => {
    const canvas = root.querySelector("canvas"), slider = root.querySelector("input[type=range]");
    const late = canvas.toDataURL();
    slider.value = 0;
    slider.dispatchEvent(new Event("input"));
    const early = canvas.toDataURL();
    root.dispatchEvent(new KeyboardEvent("keydown", { key: "End" }));
    const again = canvas.toDataURL();
    const frames = root.player.data.times.length;
    return [late !== early, again === late, root.dataset.frame === String(frames - 1)].join(",");
  });
  const result = document.createElement("pre");
  result.textContent = "RESULT " + JSON.stringify({ said, problems: window.problems });
  document.body.append(result);
});
"#;

/// Opens a page in chromium: its elements as text, and the output of its console.
fn open_in_chromium(page: &str) -> Option<(String, String)> {
    let program = ["chromium", "/usr/bin/chromium", "chromium-browser", "google-chrome"].into_iter();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("page.html");
    std::fs::write(&file, page).unwrap();
    let profile = format!("--user-data-dir={}", folder.path().join("profile").display());
    let flags = [
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--disable-background-networking",
        "--disable-sync",
        "--no-first-run",
        "--disable-dev-shm-usage",
        "--enable-logging=stderr",
        "--dump-dom",
        "--timeout=30000",
    ];
    let run =
        |name: &str| std::process::Command::new(name).args(flags).arg(&profile).arg(&file).output().ok();
    let output = program.into_iter().find_map(run)?;
    Some((
        String::from_utf8_lossy(&output.stdout).into_owned(),
        String::from_utf8_lossy(&output.stderr).into_owned(),
    ))
}

#[test]
fn animations_in_two_and_three_dimensions_play_in_a_browser_without_error() {
    let states = frames(6, 50);
    let (other, mut flow) = (frames(3, 20), frames(4, 20));
    for frame in &mut flow {
        let bed = FieldData::Scalar(vec![0.0; 20]);
        frame.fields.push(Field { name: "bed".into(), unit: "m", data: bed });
    }
    let faces = vec![[0, 1, 2, 3]];
    let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let motion = serde_json::from_value(serde_json::json!({ "velocity": [0.1, 0, 0] })).unwrap();
    let ground = RigidGeometry {
        shells: vec![MovingSurface { corners, faces, reference_point: [0.0; 3], motion }],
        ..RigidGeometry::default()
    };
    let solid = View { axes: vec![0, 1, 2], vertical_axis: 2, ground, ..view() };
    let elements = [
        Animation::from_panels(&[panel("a", &states), panel("b", &other)], &view()),
        Animation::from_panels(&[panel("a", &states)], &solid),
        Animation::from_panels(&[panel("flow", &flow)], &view()),
        Animation::from_panels(&[panel("flow", &flow)], &solid),
    ];
    let elements: String = elements.map(|one| one.unwrap().element()).concat();
    let page = format!(
        "<!doctype html><meta charset=\"utf-8\"><title>players</title><style>{STYLE}</style><script>{DRIVER}</script>\
         <body>{elements}<script>{SCRIPT}</script></body>"
    );
    let Some((dom, console)) = open_in_chromium(&page) else {
        eprintln!("skipped: there is no chromium");
        return;
    };
    let line = dom.rsplit("<pre>RESULT ").next().filter(|line| line.starts_with('{'));
    let line = line.unwrap_or_else(|| panic!("the page did not run: {console:.3000}"));
    let result: Value = serde_json::from_str(line.split("</pre>").next().unwrap()).unwrap();
    assert_eq!(result["problems"], serde_json::json!([]));
    assert_eq!(result["said"], serde_json::json!(vec!["true,true,true"; 4]), "{console:.3000}");
    assert!(!console.contains("CONSOLE"), "{console:.3000}");
}
