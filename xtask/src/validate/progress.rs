//! Progress of a validation, and the estimated remaining time.

use std::sync::Mutex;
use std::time::Instant;

/// Counts benchmarks and compares their times with the expected ones.
pub struct ValidationProgress {
    number: usize,
    workers: usize,
    start: Instant,
    count: Mutex<ProgressCount>,
}

/// Numbers and times of the benchmarks that are finished and of those that remain.
struct ProgressCount {
    done_count: usize,
    /// Time of the finished benchmarks and their expected time (s).
    elapsed: f64,
    expected_time: f64,
    /// Expected time of the others, each on one core (s).
    remaining: f64,
}

impl ValidationProgress {
    /// Builds the progress of benchmarks from their expected times on one core (s) and the number of simultaneous ones.
    pub fn new(seconds: impl Iterator<Item = u32>, workers: usize) -> Self {
        let seconds: Vec<f64> = seconds.map(f64::from).collect();
        let count = ProgressCount {
            done_count: 0,
            elapsed: 0.0,
            expected_time: 0.0,
            remaining: seconds.iter().sum(),
        };
        Self { number: seconds.len(), workers, start: Instant::now(), count: Mutex::new(count) }
    }

    /// Text on the work ahead, in a line.
    pub fn header_text(&self) -> String {
        let left = self.count.lock().expect("nothing panics while it counts").remaining;
        format!("{} at a time, about {}", self.workers, duration(left / self.workers as f64))
    }

    /// Counts a finished benchmark; returns a text with its number and the estimated remaining time.
    pub fn finished_text(&self, expected: u32, took: f64) -> String {
        let mut count = self.count.lock().expect("nothing panics while it counts");
        count.done_count += 1;
        count.elapsed += took;
        count.expected_time += f64::from(expected);
        count.remaining -= f64::from(expected);
        let elapsed = duration(self.start.elapsed().as_secs_f64());
        let rest = match self.number - count.done_count {
            0 => "none left".to_owned(),
            _ => format!("about {} left", duration(count.remaining_time() / self.workers as f64)),
        };
        format!("{} of {} after {elapsed}, {rest}", count.done_count, self.number)
    }
}

impl ProgressCount {
    /// Estimated remaining time on one core (s), at the speed of the finished benchmarks.
    fn remaining_time(&self) -> f64 {
        self.remaining * self.elapsed / self.expected_time.max(1.0)
    }
}

/// Text of a duration, rounded.
fn duration(seconds: f64) -> String {
    match seconds.round() as u64 {
        seconds @ 0..120 => format!("{seconds} s"),
        seconds @ 120..7200 => format!("{} min", (seconds + 30) / 60),
        seconds => format!("{:.1} h", seconds as f64 / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_machine_of_half_the_speed_doubles_the_remaining_time() {
        let progress = ValidationProgress::new([10, 30, 60].into_iter(), 1);
        assert_eq!(progress.header_text(), "1 at a time, about 100 s");
        let line = progress.finished_text(30, 60.0);
        assert!(line.starts_with("1 of 3 after ") && line.ends_with("about 2 min left"), "{line}");
        assert!(progress.finished_text(10, 20.0).ends_with("about 2 min left"));
        assert!(progress.finished_text(60, 1.0).ends_with("none left"));
    }

    #[test]
    fn durations_are_printed_in_seconds_minutes_or_hours() {
        assert_eq!([3.4, 119.0, 150.0, 9000.0].map(duration), ["3 s", "119 s", "3 min", "2.5 h"]);
    }
}
