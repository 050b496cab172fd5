//! Pages in a real browser: headless Chromium, driven by `tests/browser/check.mjs`.

use crate::npm;
use serde::Deserialize;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What the browser says of a page.
#[derive(Debug, Deserialize)]
pub struct Report {
    /// Errors of the console, and exceptions of scripts.
    pub errors: Vec<String>,
    /// Addresses other than the page itself that it asked for; data URIs do not count.
    pub requests: Vec<String>,
    /// Number of pictures, `img` and SVG `image`.
    pub pictures: usize,
    /// Sources of those that did not load, shortened.
    pub broken: Vec<String>,
    /// The page at 390 and 1280 pixels, in light and dark.
    pub layouts: Vec<Layout>,
    /// The attribute and the text of every element that carries `data-value`, in order.
    pub values: Vec<(String, String)>,
}

/// A page at one width, in one colour scheme.
#[derive(Debug, Deserialize)]
pub struct Layout {
    /// `light` or `dark`.
    pub scheme: String,
    /// The window's width, pixels.
    pub width: u32,
    /// The content's width, pixels.
    pub content: u32,
    /// Whether there is more content than fits the width.
    pub scrolls: bool,
    /// The body's background, as CSS has it.
    pub background: String,
}

impl Report {
    /// Everything that is wrong with the page as one that stands alone, in words.
    pub fn faults(&self) -> Vec<String> {
        let wide = self.layouts.iter().filter(|layout| layout.scrolls).map(|layout| {
            let Layout { scheme, width, content, .. } = layout;
            format!("scrolls at {width} pixels ({scheme}): {content}")
        });
        let errors = self.errors.iter().map(|error| format!("error: {error}"));
        let requests = self.requests.iter().map(|address| format!("asks for {address}"));
        let broken = self.broken.iter().map(|source| format!("picture not loaded: {source}"));
        errors.chain(requests).chain(broken).chain(wide).collect()
    }
}

/// Opens a page from disk. Panics where Chromium or Node.js is missing.
pub fn check(page: &Path) -> Report {
    let page = page.canonicalize().unwrap_or_else(|error| panic!("{}: {error}", page.display()));
    let printed = npm::run("browser", "check.mjs", &[&chromium(), &page]);
    serde_json::from_slice(&printed).expect("the browser's report")
}

/// The program: `CHROMIUM`, or the first of the usual names that starts.
pub fn chromium() -> PathBuf {
    let starts = |program: &OsStr| {
        let mut command = Command::new(program);
        command.arg("--version").stdout(Stdio::null()).stderr(Stdio::null());
        command.status().is_ok_and(|status| status.success())
    };
    if let Some(program) = std::env::var_os("CHROMIUM").filter(|value| !value.is_empty()) {
        assert!(starts(&program), "CHROMIUM is set, but {program:?} does not start");
        return program.into();
    }
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let folders: Vec<PathBuf> = std::env::split_paths(&folders).collect();
    let mut programs = names.iter().flat_map(|name| folders.iter().map(move |f| f.join(name)));
    programs.find(|program| starts(program.as_os_str())).unwrap_or_else(|| {
        panic!("no Chromium: none of {names:?} starts; install one, or set CHROMIUM to another")
    })
}
