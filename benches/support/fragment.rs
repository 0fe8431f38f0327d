//! What one bench writes down, for the summary to gather.

use std::path::{Path, PathBuf};
use std::{env, fs, io};

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// What one bench found.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(crate) struct Fragment {
    pub(crate) name: String,
    #[serde(default)]
    pub(crate) figures: Vec<Figure>,
    #[serde(default)]
    pub(crate) peers: Vec<Peer>,
    #[serde(default)]
    pub(crate) curves: Vec<Curve>,
}

/// One figure, with the target that it is held to if there is one.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Figure {
    /// The row of the targets in `docs/performance.md`.
    #[serde(default)]
    pub(crate) row: Option<u8>,
    pub(crate) name: String,
    pub(crate) value: f64,
    pub(crate) unit: String,
    /// A number is an upper limit; words are for the reader.
    #[serde(default)]
    pub(crate) target: Value,
    #[serde(default)]
    pub(crate) met: Option<bool>,
}

/// What a figure is held to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Target {
    /// Nothing: it is context.
    None,
    /// At most this.
    AtMost(f64),
}

impl Figure {
    pub(crate) fn new(row: u8, name: &str, value: f64, unit: &str, target: Target) -> Self {
        let (target, met) = match target {
            Target::None => (Value::Null, None),
            Target::AtMost(limit) => (limit.into(), Some(value <= limit)),
        };
        Self { row: Some(row), name: name.into(), value, unit: unit.into(), target, met }
    }
}

/// One entrant of a contest.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Peer {
    #[serde(default)]
    pub(crate) contest: String,
    pub(crate) name: String,
    pub(crate) p5_ns: f64,
    pub(crate) median_ns: f64,
}

/// One picture of some series over the same axes.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Curve {
    /// The name of the picture's file, without `.svg`.
    pub(crate) slug: String,
    pub(crate) title: String,
    pub(crate) x: String,
    pub(crate) y: String,
    #[serde(default)]
    pub(crate) log_x: bool,
    #[serde(default)]
    pub(crate) log_y: bool,
    pub(crate) series: Vec<Series>,
}

/// One line of a curve.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Series {
    pub(crate) name: String,
    pub(crate) points: Vec<(f64, f64)>,
}

impl Curve {
    pub(crate) fn new(slug: &str, title: &str, x: &str, y: &str) -> Self {
        let [slug, title, x, y] = [slug, title, x, y].map(str::to_owned);
        Self { slug, title, x, y, ..Self::default() }
    }

    /// With a logarithmic x axis.
    pub(crate) fn log_x(self) -> Self {
        Self { log_x: true, ..self }
    }

    /// With a logarithmic y axis.
    pub(crate) fn log_y(self) -> Self {
        Self { log_y: true, ..self }
    }

    pub(crate) fn with(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }
}

impl Series {
    pub(crate) fn new(name: &str, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), points }
    }
}

impl Fragment {
    pub(crate) fn new(name: &str) -> Self {
        Self { name: name.into(), ..Self::default() }
    }

    /// Writes it as `<directory>/<name>.json`.
    pub(crate) fn write(&self, directory: &Path) -> io::Result<PathBuf> {
        fs::create_dir_all(directory)?;
        let path = directory.join(&self.name).with_extension("json");
        fs::write(&path, serde_json::to_string_pretty(self)?)?;
        Ok(path)
    }

    /// What the bench of this name wrote; `None` if it has not.
    pub(crate) fn read(directory: &Path, name: &str) -> io::Result<Option<Self>> {
        let path = directory.join(name).with_extension("json");
        if !path.exists() {
            return Ok(None);
        }
        let text = fs::read_to_string(&path)?;
        let fragment = serde_json::from_str(&text);
        fragment.map(Some).map_err(|e| io::Error::other(format!("{}: {e}", path.display())))
    }
}

/// Where fragments are written: `bench` in Cargo's target directory.
pub(crate) fn directory() -> PathBuf {
    let target = env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into());
    PathBuf::from(target).join("bench")
}
