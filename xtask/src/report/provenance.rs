//! Machine, compiler, commit and date of a report.

use std::process::Command;

/// Provenance of a report.
pub struct Provenance {
    /// Processor, cores and system.
    pub machine: String,
    /// Version of the compiler.
    pub rustc: String,
    /// Commit, with a mark where the working tree has changes.
    pub commit: String,
    /// Date and time.
    pub date: String,
}

/// Output of a command; empty where it fails.
fn output(program: &str, arguments: &[&str]) -> String {
    let result = Command::new(program).args(arguments).current_dir(crate::root()).output();
    result.map(|o| String::from_utf8_lossy(&o.stdout).trim().to_owned()).unwrap_or_default()
}

/// Returns the provenance of this report.
pub fn provenance() -> Provenance {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model =
        info.lines().find_map(|line| line.strip_prefix("model name")).unwrap_or(": unknown processor");
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    Provenance {
        machine: format!(
            "{}, {cores} cores, {}",
            model.trim_start_matches([' ', '\t', ':']),
            std::env::consts::OS
        ),
        rustc: output("rustc", &["--version"]),
        commit: output("git", &["describe", "--always", "--dirty"]),
        date: output("date", &["-u", "+%Y-%m-%d %H:%M UTC"]),
    }
}
