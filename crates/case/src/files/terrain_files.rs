//! Files of terrain: rasters, meshes and outlines in plan.

#[cfg(feature = "files")]
pub(crate) use colluvium_terrain::{
    CoordinateReferenceSystem, FileError, read_features, read_mesh, read_outlines, read_raster,
    read_reference_system, read_text, sidecar_files,
};

#[cfg(not(feature = "files"))]
pub(crate) use without_files::{
    CoordinateReferenceSystem, FileError, read_features, read_mesh, read_outlines, read_raster,
    read_reference_system, read_text, sidecar_files,
};

use crate::CaseErrorKind;

impl From<FileError> for CaseErrorKind {
    fn from(error: FileError) -> Self {
        Self::File { file: error.file, code: error.code, problem: error.problem }
    }
}

/// Replacement of the readers in a build without them: each refuses its file.
#[cfg(not(feature = "files"))]
mod without_files {
    use std::fmt;
    use std::path::{Path, PathBuf};

    use colluvium_points::surface::FacettedSurface;
    use colluvium_points::{Outline, OutlineFeature, Raster};

    /// Error of a file, in one line.
    #[derive(Clone, Debug, thiserror::Error)]
    #[error("{}: {problem}", file.display())]
    pub(crate) struct FileError {
        pub(crate) file: PathBuf,
        pub(crate) code: &'static str,
        pub(crate) problem: String,
    }

    /// Refuses a file.
    fn refuse<T>(file: &Path) -> Result<T, FileError> {
        let problem =
            CaseErrorKind::coded("needs-other-key", "needs the feature `files` of the crate colluvium-case");
        Err(FileError { file: file.to_owned(), code: "unsupported-format", problem })
    }

    pub(crate) fn read_raster(file: &Path) -> Result<Raster, FileError> {
        refuse(file)
    }

    pub(crate) fn read_mesh(
        file: &Path,
        _placed: &dyn Fn(usize, f64) -> f64,
    ) -> Result<FacettedSurface<3>, FileError> {
        refuse(file)
    }

    pub(crate) fn read_outlines(file: &Path) -> Result<Outline, FileError> {
        refuse(file)
    }

    pub(crate) fn read_features(file: &Path, _attribute: &str) -> Result<Vec<OutlineFeature>, FileError> {
        refuse(file)
    }

    /// Reads a text file in UTF-8.
    pub(crate) fn read_text(file: &Path) -> Result<String, FileError> {
        std::fs::read_to_string(file).map_err(|error| FileError {
            file: file.to_owned(),
            code: "unreadable-file",
            problem: format!("cannot be read: {error}"),
        })
    }

    /// No file is read, so none has a reference system.
    pub(crate) fn read_reference_system(_file: &Path) -> Option<CoordinateReferenceSystem> {
        None
    }

    pub(crate) fn sidecar_files(_file: &Path) -> Vec<PathBuf> {
        Vec::new()
    }

    /// Reference system of a file; there is none.
    #[derive(Clone, Debug, PartialEq)]
    pub(crate) enum CoordinateReferenceSystem {}

    impl CoordinateReferenceSystem {
        pub(crate) fn differs(&self, _other: &Self) -> bool {
            match *self {}
        }

        pub(crate) fn is_comparable(&self, _other: &Self) -> bool {
            match *self {}
        }
    }

    impl fmt::Display for CoordinateReferenceSystem {
        fn fmt(&self, _f: &mut fmt::Formatter<'_>) -> fmt::Result {
            match *self {}
        }
    }
}
