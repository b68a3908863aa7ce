//! Prints rows and stores them in a file, to compare two runs.

use std::path::PathBuf;

use serde_json::{Map, Value, json};
use wgdenoise::measure::median;
use wgdenoise::wgpu::AdapterInfo;

/// The rows of this run and of the last one on the same adapter.
pub(crate) struct Record {
    path: PathBuf,
    before: Map<String, Value>,
    rows: Map<String, Value>,
}

impl Record {
    /// Opens the record of an adapter: this file, or one in the target folder.
    pub(crate) fn open(path: Option<PathBuf>, adapter: &AdapterInfo) -> Self {
        let is_plain = |c: char| if c.is_alphanumeric() { c } else { '_' };
        let name: String = adapter.name.chars().map(is_plain).collect();
        let in_target =
            || PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("frame-{name}.json"));
        let path = path.unwrap_or_else(in_target);
        let text = std::fs::read_to_string(&path).unwrap_or_default();
        let before = serde_json::from_str(&text).unwrap_or_default();
        Self { path, before, rows: Map::new() }
    }

    /// Prints and keeps a row of at least one time; times are sorted, shortest first.
    pub(crate) fn row(&mut self, name: &str, seconds: &[f64], flop: f64) {
        let median = median(seconds);
        let [fastest, slowest] = [seconds[0], seconds[seconds.len() - 1]];
        let before = self.before.get(name).and_then(|row| row["median_seconds"].as_f64());
        let ratio = before.map(|before| format!(", {:.2} of the run before", median / before));
        println!(
            "{name}: median {:.3} ms ({:.3} to {:.3}), {:.1} GFLOP/s{}",
            median * 1e3,
            fastest * 1e3,
            slowest * 1e3,
            flop / median / 1e9,
            ratio.unwrap_or_default()
        );
        let row = json!({ "median_seconds": median, "seconds": seconds, "flop": flop });
        self.rows.insert(name.into(), row);
    }

    /// Saves the rows for the next run.
    pub(crate) fn save(self) {
        let mut all = self.before;
        all.extend(self.rows);
        let text = serde_json::to_string_pretty(&Value::Object(all)).expect("it is plain data");
        match std::fs::write(&self.path, text) {
            Ok(()) => println!("kept in {}", self.path.display()),
            Err(error) => println!("{}: not kept: {error}", self.path.display()),
        }
    }
}
