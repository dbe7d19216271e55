//! Foreign shared libraries: permission to load them, and protection against libraries that end the program.

use std::cell::Cell;
use std::collections::HashMap;
use std::error::Error;
use std::ffi::c_int;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, Once, OnceLock, PoisonError};

use libloading::Library;

use crate::MaterialError;
use crate::Warning;

/// Environment variable that allows the loading of libraries if its value is `1`.
const PERMISSION_VARIABLE: &str = "COLLUVIUM_ALLOW_LIBRARY";

/// Whether the program has allowed the loading of libraries.
static LOADING_ALLOWED: AtomicBool = AtomicBool::new(false);

/// Allows materials to load shared libraries, for the whole process. Without it, a case that names a library is rejected as foreign code.
/// The environment variable `COLLUVIUM_ALLOW_LIBRARY=1` is equivalent.
pub fn allow_libraries() {
    LOADING_ALLOWED.store(true, Ordering::Relaxed);
}

/// Whether libraries may be loaded, by the program or by the environment variable.
fn is_loading_allowed() -> bool {
    LOADING_ALLOWED.load(Ordering::Relaxed)
        || std::env::var_os(PERMISSION_VARIABLE).is_some_and(|value| value == "1")
}

/// Library and the common lock of its routines.
pub(crate) type LoadedLibrary = (Arc<Library>, Arc<Mutex<()>>);

/// Libraries in use by path. Each is opened once, so that its materials share its lock.
fn libraries() -> &'static Mutex<HashMap<PathBuf, LoadedLibrary>> {
    /// Libraries that are loaded, by path.
    static LOADED_LIBRARIES: OnceLock<Mutex<HashMap<PathBuf, LoadedLibrary>>> = OnceLock::new();
    LOADED_LIBRARIES.get_or_init(Mutex::default)
}

/// Text of a loading error, with the message of the system's loader.
pub(crate) fn load_error(error: &libloading::Error) -> String {
    let source = error.source().map(ToString::to_string);
    source.unwrap_or_else(|| error.to_string())
}

/// Opens a library, if that is allowed.
///
/// # Errors
/// When it is not allowed, is no regular file or cannot be loaded.
#[allow(unsafe_code, reason = "code of another language can be loaded in no other way")]
pub(crate) fn open(path: &Path) -> Result<LoadedLibrary, MaterialError> {
    let fail = |problem: String| {
        MaterialError::incompatible_options("library", format!("{}: {problem}", path.display()))
    };
    if !is_loading_allowed() {
        return Err(fail(format!(
            "is code that would run with your rights; if you trust it, allow it with --allow-library or {PERMISSION_VARIABLE}=1"
        )));
    }
    let file = path.canonicalize().map_err(|error| fail(error.to_string()))?;
    if !file.is_file() {
        return Err(fail("is not a regular file".to_owned()));
    }
    let mut open = libraries().lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(opened) = open.get(&file) {
        return Ok(opened.clone());
    }
    // SAFETY: initialisers of the library run here; the user has allowed that.
    let library = call_guarded(|| unsafe { Library::new(&file) });
    let library = library.map_err(|error| fail(format!("cannot be loaded: {}", load_error(&error))))?;
    let opened: LoadedLibrary = (Arc::new(library), Arc::default());
    open.insert(file, opened.clone());
    Ok(opened)
}

thread_local! {
    /// Whether this thread is executing a function of a library.
    static IS_INSIDE_LIBRARY: Cell<bool> = const { Cell::new(false) };
}

/// Runs code of a library. If it ends the program (`exit` of C, `STOP` of Fortran), the exit status is not success.
pub(crate) fn call_guarded<R>(call: impl FnOnce() -> R) -> R {
    watch_exit();
    let before = IS_INSIDE_LIBRARY.replace(true);
    let result = call();
    IS_INSIDE_LIBRARY.set(before);
    result
}

/// Registers a handler that reports an end of the program from inside a library.
#[allow(unsafe_code, reason = "an exit of foreign code is seen in no other way")]
fn watch_exit() {
    unsafe extern "C" {
        /// Registers a function of the C library to be called at the end of the process.
        fn atexit(callback: extern "C" fn()) -> c_int;
        /// Ends the process without calling the registered functions.
        fn _exit(status: c_int) -> !;
    }

    extern "C" fn at_exit() {
        if IS_INSIDE_LIBRARY.try_with(Cell::get).unwrap_or(false) {
            let ended = Warning::new("umat", "the library of a umat ended the program");
            let _ = writeln!(std::io::stderr(), "{}", ended.line("error"));
            // SAFETY: ends the process at once; no resources are left to release.
            unsafe { _exit(1) }
        }
    }

    /// Guard by which the exit handler is registered once.
    static EXIT_WATCH: Once = Once::new();
    EXIT_WATCH.call_once(|| {
        // SAFETY: the callback has no arguments, returns, and lives as long as the program. If its registration fails, an
        // exit behaves as without it.
        let _ = unsafe { atexit(at_exit) };
    });
}
