//! Reference profiles of a comparison: measured ones, or those of a closed form.

use std::path::{Path, PathBuf};

use crate::case::{ColumnFile, ColumnRow, Quantity};
use crate::compare::CompareError;
use crate::compare::key_figures::interpolated;

/// Name of the file of reference profiles beside a case.
const SIDECAR_FILE: &str = "reference.csv";

/// Curve of position and height (m).
type ProfileCurve = Vec<(f64, f64)>;

/// Reference heights of the surface of the flowing mass at one or several times.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReferenceProfiles {
    /// Times (s; the end where the file has none) and profiles, by time and position.
    pub profiles: Vec<(Option<f64>, ProfileCurve)>,
}

impl ReferenceProfiles {
    /// Reads a CSV file with the columns `position` and `height` (m), and `time` (s) for several profiles; a unit in brackets after a name
    /// is applied. Lines that begin with `#` are comments.
    ///
    /// # Errors
    /// When the file cannot be read, lacks a column, or has a number that is not finite.
    pub fn read(path: &Path) -> Result<Self, CompareError> {
        Self::profiles_of(path)?
            .ok_or_else(|| reference_error(path, "has no columns position and height (m)"))
    }

    /// Reads the profiles of a file; `None` where it lacks their columns.
    fn profiles_of(path: &Path) -> Result<Option<Self>, CompareError> {
        let wrong = |problem: String| reference_error(path, &problem);
        let table = ColumnFile::read(path).map_err(|error| wrong(error.to_string()))?;
        let named = |name: &str, quantity| {
            let at = table.headings()?.iter().position(|head| ColumnFile::name(head) == name)?;
            Some((at, quantity))
        };
        let (Some(position), Some(height)) =
            (named("position", Quantity::Length), named("height", Quantity::Length))
        else {
            return Ok(None);
        };
        let column = |(at, quantity)| column_values(&table, at, quantity).map_err(wrong);
        let (position, height) = (column(position)?, column(height)?);
        let times = named("time", Quantity::Time).map(column).transpose()?;
        let mut profiles: Vec<(Option<f64>, ProfileCurve)> = Vec::new();
        for (row, place) in position.into_iter().zip(height).enumerate() {
            let time = times.as_ref().map(|times| times[row]);
            match profiles.iter_mut().find(|(known, _)| *known == time) {
                Some((_, curve)) => curve.push(place),
                None => profiles.push((time, vec![place])),
            }
        }
        if profiles.is_empty() {
            return Err(reference_error(path, "has no rows"));
        }
        profiles.iter_mut().for_each(|(_, curve)| curve.sort_by(|a, b| a.0.total_cmp(&b.0)));
        profiles.sort_by(|a, b| a.0.partial_cmp(&b.0).unwrap_or(std::cmp::Ordering::Equal));
        Ok(Some(Self { profiles }))
    }

    /// Profiles in the file `reference.csv` of the folder of a case, with the path of that file; `None` where the file is missing or has no
    /// profiles.
    ///
    /// # Errors
    /// As [`Self::read`], except for missing columns.
    pub fn read_sidecar(case: &Path) -> Result<Option<(PathBuf, Self)>, CompareError> {
        let file = case.with_file_name(SIDECAR_FILE);
        if !file.is_file() {
            return Ok(None);
        }
        let found = Self::profiles_of(&file)?;
        Ok(found.map(|found| (file, found)))
    }

    /// Reference profiles in the named file, or else in the file beside the case; empty without a file.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_for_case(
        case: &Path,
        named: Option<&Path>,
        tell: impl FnOnce(&Path),
    ) -> Result<Self, CompareError> {
        if let Some(file) = named {
            return Self::read(file);
        }
        let found = Self::read_sidecar(case)?;
        Ok(found
            .map(|(file, found)| {
                tell(&file);
                found
            })
            .unwrap_or_default())
    }

    /// Times of `frames` (s, ascending) that are nearest to the times of the reference profiles.
    pub(super) fn times(&self, frames: &[f64]) -> Vec<f64> {
        self.profiles.iter().filter_map(|(time, _)| nearest_time(frames, *time)).collect()
    }

    /// Reference profile whose nearest frame is the one at `time` (s).
    pub(super) fn nearest_profile(&self, time: f64, frames: &[f64]) -> Option<&ProfileCurve> {
        let here = |(own, _): &&(Option<f64>, ProfileCurve)| nearest_time(frames, *own) == Some(time);
        self.profiles.iter().find(here).map(|(_, curve)| curve)
    }
}

/// Numbers of a column, in SI units.
fn column_values(table: &ColumnFile, at: usize, quantity: Quantity) -> Result<Vec<f64>, String> {
    let factor = ColumnFile::factor(&table.headings().unwrap_or_default()[at], quantity)
        .map_err(|error| error.to_string())?;
    let number = |row: Result<ColumnRow, String>| {
        let ColumnRow { line, cells } = row?;
        let found = table.number(&cells[at]).map(|value| value * factor);
        found.ok_or_else(|| format!("line {line}: {:?} is not a finite number", &cells[at]))
    };
    table.rows().map(number).collect()
}

/// Error of a file of reference profiles.
fn reference_error(path: &Path, problem: &str) -> CompareError {
    CompareError::Reference { path: path.to_owned(), problem: problem.into() }
}

/// Time of a frame nearest to a given one (s); that of the last frame where none is given.
fn nearest_time(frames: &[f64], time: Option<f64>) -> Option<f64> {
    let Some(time) = time else { return frames.last().copied() };
    frames.iter().copied().min_by(|a, b| (a - time).abs().total_cmp(&(b - time).abs()))
}

/// Root mean square difference of a profile from a reference at the positions of the reference, relative to the reference.
pub(super) fn distance_to(reference: &[(f64, f64)], profile: &[(f64, f64)]) -> f64 {
    let sum: f64 = reference.iter().map(|(x, height)| (interpolated(profile, *x) - height).powi(2)).sum();
    let size: f64 = reference.iter().map(|(_, height)| height * height).sum();
    (sum / size).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profiles_are_sorted_by_time_and_found_at_the_frame_nearest_to_theirs() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("reference.csv");
        std::fs::write(&path, "# measured\ntime,position,height\n0.9,2,1\n0.9,1,3\n0.4,0,5\n").unwrap();
        let reference = ReferenceProfiles::read(&path).unwrap();
        assert_eq!(reference.profiles[0], (Some(0.4), vec![(0.0, 5.0)]));
        assert_eq!(reference.profiles[1].1, [(1.0, 3.0), (2.0, 1.0)]);
        let frames = [0.0, 0.5, 1.0];
        assert_eq!(reference.times(&frames), [0.5, 1.0]);
        assert!(
            reference.nearest_profile(0.0, &frames).is_none()
                && reference.nearest_profile(1.0, &frames).is_some()
        );
        std::fs::write(&path, "time (min);position (mm);height (cm)\n0,5;2000;62,5\n").unwrap();
        assert_eq!(ReferenceProfiles::read(&path).unwrap().profiles, [(Some(30.0), vec![(2.0, 0.625)])]);
        std::fs::write(&path, "position,height\n0,nan\n").unwrap();
        assert!(
            ReferenceProfiles::read(&path)
                .unwrap_err()
                .to_string()
                .contains("line 2: \"nan\" is not a finite")
        );
        std::fs::write(&path, "x,height\n0,1\n").unwrap();
        let error = ReferenceProfiles::read(&path).unwrap_err().to_string();
        assert!(error.contains("reference.csv: has no columns position and height"), "{error}");
    }

    #[test]
    fn profile_files_beside_a_case_are_read_and_other_tables_ignored() {
        let folder = tempfile::tempdir().unwrap();
        let case = folder.path().join("case.json");
        let file = folder.path().join(SIDECAR_FILE);
        assert_eq!(ReferenceProfiles::read_sidecar(&case).unwrap(), None);
        std::fs::write(&file, "viscosity,front (m)\n0.1,0.4\n").unwrap();
        assert_eq!(ReferenceProfiles::read_sidecar(&case).unwrap(), None);
        std::fs::write(&file, "position,height\n0,2\n1,1\n").unwrap();
        let mut reported = None;
        let found =
            ReferenceProfiles::read_for_case(&case, None, |file| reported = Some(file.to_owned())).unwrap();
        assert_eq!(found.profiles, [(None, vec![(0.0, 2.0), (1.0, 1.0)])]);
        assert_eq!(reported, Some(file));
    }

    #[test]
    fn points_on_the_reference_profile_have_zero_distance_to_it() {
        let line = |k: i32| (f64::from(k), 2.0 * f64::from(k));
        let profile: Vec<_> = (0..5).map(line).collect();
        assert!(distance_to(&[(0.5, 1.0), (2.5, 5.0)], &profile) < 1e-15);
        assert!((distance_to(&[(1.0, 1.0), (2.0, 2.0)], &profile) - 1.0).abs() < 1e-15);
    }
}
