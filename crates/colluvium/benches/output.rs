//! Benchmarks of output: time to write and to read back frames, rows of measures, checkpoints, NPZ archives, rasters and the report. The
//! case is a falling column of sand with 22 500 points; frames also with 90 000.
//!
//! `cargo bench -p colluvium --bench output [-- NAME]`, on one thread.

use std::hint::black_box;
use std::path::Path;

use colluvium::case::description::Compression;
use colluvium::case::output::{
    Table, TableFile, WriteOptions, frame_arrays, read_frame, read_npz, write_frame, write_npz,
};
use colluvium::case::{Case, RunOptions, Snapshot, run};
use colluvium::report::{self, ReportOptions};
use criterion::{Criterion, Throughput};

/// Column of the first template with cells of this width (m), after some steps.
fn column(cell: f64, out: Option<&Path>) -> (Case, Snapshot) {
    let text = colluvium::template("column-collapse").expect("a template");
    let mut value: serde_json::Value = serde_json::from_str(text).expect("a case");
    value["methods"]["mpm"]["cell_size"] = cell.into();
    value["stages"][0]["duration"] = (2.0 * cell).into();
    value["output"] = serde_json::json!({ "frames": 0.5 * cell });
    let case = Case::from_json(&value.to_string()).expect("a valid case");
    let solver = colluvium::method("mpm").expect("a method").build(&case).expect("a solver");
    let options =
        RunOptions { method: "mpm".into(), output_folder: out.map(Path::to_owned), ..RunOptions::default() };
    let report = run(&case, solver, &options).expect("a run");
    (case, report.snapshot)
}

fn frames(criterion: &mut Criterion, folder: &Path, snapshot: &Snapshot) {
    let mut group = criterion.benchmark_group(format!("frame of {} points", snapshot.ids.len()));
    group.sample_size(10).throughput(Throughput::Elements(snapshot.ids.len() as u64));
    for compression in [Compression::Fast, Compression::Best, Compression::None] {
        let path = folder.join(format!("{compression:?}.vtu"));
        let written = WriteOptions { compression, ..WriteOptions::default() };
        group.bench_function(format!("write, {compression:?}"), |bencher| {
            bencher.iter(|| write_frame(&path, snapshot, [0.0; 3], written).expect("a file"));
        });
        println!("{} bytes", std::fs::metadata(&path).expect("a file").len());
        group.bench_function(format!("read, {compression:?}"), |bencher| {
            bencher.iter(|| black_box(read_frame(&path, 0.0).expect("a frame")));
        });
    }
    group.finish();
}

fn archives(criterion: &mut Criterion, folder: &Path, snapshot: &Snapshot) {
    let mut group = criterion.benchmark_group("npz");
    group.sample_size(10).throughput(Throughput::Elements(snapshot.ids.len() as u64));
    let path = folder.join("frame.npz");
    group.bench_function("write", |bencher| {
        bencher.iter(|| write_npz(&path, &frame_arrays(snapshot)).expect("a file"));
    });
    group.bench_function("read", |bencher| {
        bencher.iter(|| black_box(read_npz(&path).expect("an archive")));
    });
    group.finish();
}

fn tables(criterion: &mut Criterion, folder: &Path) {
    let columns: Vec<_> = (0..30).map(|k| (format!("column_{k}"), "m".to_owned())).collect();
    let row: Vec<f64> = (0..30).map(|k| (f64::from(k) * 0.37).sin() * 1e-3).collect();
    let path = folder.join("table.csv");
    let mut group = criterion.benchmark_group("1000 rows of 30 measures");
    group.sample_size(10).throughput(Throughput::Elements(1000));
    group.bench_function("write", |bencher| {
        bencher.iter(|| {
            let mut table = TableFile::create(&path, "about", &columns).expect("a file");
            (0..1000).for_each(|_| table.append(std::slice::from_ref(&row)).expect("a row"));
        });
    });
    group.bench_function("read", |bencher| {
        bencher.iter(|| black_box(Table::read(&path).expect("a table")));
    });
    group.finish();
}

fn checkpoint(criterion: &mut Criterion, case: &Case) {
    let mut solver = colluvium::method("mpm").expect("a method").build(case).expect("a solver");
    solver.begin_stage(0, 0.0).expect("a stage");
    let mut group = criterion.benchmark_group("checkpoint");
    group.sample_size(10).throughput(Throughput::Elements(solver.point_count() as u64));
    group.bench_function("write", |bencher| {
        bencher.iter(|| black_box(solver.checkpoint_bytes().expect("bytes")));
    });
    let bytes = solver.checkpoint_bytes().expect("bytes");
    group.bench_function("read", |bencher| {
        bencher.iter(|| solver.restore(&mut bytes.as_slice()).expect("a state"));
    });
    group.finish();
}

fn rasters(criterion: &mut Criterion, folder: &Path) {
    let mut group = criterion.benchmark_group("raster of 500 × 500 cells");
    group.sample_size(10).throughput(Throughput::Elements(250_000));
    let value = |k: usize| 1000.0 + (k % 500) as f64 * 0.3 + (k as f64 * 0.01).sin();
    let raster = colluvium::points::Raster {
        columns: 500,
        rows: 500,
        origin: [0.0; 2],
        spacing: [1.0; 2],
        values: (0..250_000).map(value).collect(),
        reference: colluvium::points::Georeference::default(),
    };
    for ending in ["asc", "tif"] {
        let path = folder.join("raster").with_extension(ending);
        group.bench_function(format!("write {ending}"), |bencher| {
            bencher.iter(|| colluvium_terrain::write_raster(&path, &raster).expect("a file"));
        });
        group.bench_function(format!("read {ending}"), |bencher| {
            bencher.iter(|| black_box(colluvium_terrain::read_raster(&path).expect("a raster")));
        });
    }
    group.finish();
}

fn main() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool of one thread");
    pool.install(|| {
        let mut criterion = Criterion::default().configure_from_args();
        let folder = tempfile::tempdir().expect("a folder");
        let out = folder.path().join("run");
        let (case, snapshot) = column(0.002, Some(&out));
        frames(&mut criterion, folder.path(), &snapshot);
        frames(&mut criterion, folder.path(), &column(0.001, None).1);
        archives(&mut criterion, folder.path(), &snapshot);
        tables(&mut criterion, folder.path());
        checkpoint(&mut criterion, &case);
        rasters(&mut criterion, folder.path());
        let mut group = criterion.benchmark_group("report of 22500 points");
        group.sample_size(10);
        group.bench_function("write", |bencher| {
            bencher.iter(|| report::write(&out, &ReportOptions::default()).expect("a report"));
        });
        group.finish();
        criterion.final_summary();
    });
}
