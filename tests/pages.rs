//! Pages that klieg writes, in a real browser.

#[path = "support/browser.rs"]
mod browser;
mod common;
#[path = "support/npm.rs"]
mod npm;

use common::Folder;
use std::path::PathBuf;

/// The sheet of a design, and that with something put in at its end.
struct Sheet {
    place: Folder,
    text: String,
}

impl Sheet {
    fn new() -> Self {
        let place = Folder::new();
        place.design("out", &[]).assert().success();
        let text = std::fs::read_to_string(place.path("out/report.html")).unwrap();
        Self { place, text }
    }

    fn with(&self, name: &str, fault: &str) -> PathBuf {
        let (before, after) = self.text.split_once("</main>").unwrap();
        let path = self.place.path(name);
        std::fs::write(&path, format!("{before}{fault}</main>{after}")).unwrap();
        path
    }
}

#[test]
fn the_sheet_of_a_design_is_sound_at_every_width_and_in_both_schemes() {
    let sheet = Sheet::new();
    let report = browser::check(&sheet.place.path("out/report.html"));
    assert_eq!(report.faults(), [""; 0]);
    assert_eq!(report.pictures, 2);
    let layouts: Vec<_> =
        report.layouts.iter().map(|layout| (layout.scheme.as_str(), layout.width)).collect();
    assert_eq!(layouts, [("light", 390), ("light", 1280), ("dark", 390), ("dark", 1280)]);
    let background = |index: usize| &report.layouts[index].background;
    assert_eq!(background(0), background(1));
    assert_ne!(background(0), background(2));
}

#[test]
fn planted_faults_are_found() {
    let sheet = Sheet::new();
    let check = |name: &str, fault: &str| browser::check(&sheet.with(name, fault));

    let report = check("picture.html", "<img src=\"missing.png\">");
    assert!(report.broken.len() == 1 && report.broken[0].ends_with("/missing.png"), "{report:?}");
    assert!(report.requests[0].ends_with("/missing.png"), "{report:?}");
    let broken = "<svg><image href=\"data:image/png;base64,iVBORw0KGgo=\"/></svg>";
    let report = check("svg.html", broken);
    assert_eq!(report.broken, ["data:image/png;base64,iVBORw0KGgo="]);
    assert_eq!((report.pictures, report.requests.len()), (3, 0));

    let scripts = "<script>console.error('planted')</script><script>throw Error('thrown')</script>";
    let report = check("script.html", scripts);
    assert_eq!(report.errors.len(), 2, "{report:?}");
    assert!(report.errors[0] == "planted" && report.errors[1].contains("thrown"), "{report:?}");
    assert_eq!(report.faults().len(), 2);

    let report = check("wide.html", "<div style=\"width: 600px\">wide</div>");
    let scrolls: Vec<_> = report.layouts.iter().map(|layout| layout.scrolls).collect();
    assert_eq!(scrolls, [true, false, true, false]);
    assert_eq!(report.faults().len(), 2);

    let style = "<link rel=\"stylesheet\" href=\"https://example.org/style.css\">";
    let report = check("network.html", style);
    assert_eq!(report.requests, ["https://example.org/style.css"]);
}

#[test]
fn values_are_read_as_they_are_shown() {
    let sheet = Sheet::new();
    let values = "<b data-value=\"best.score\"> 0.2478 </b><i data-value=\"runs\">1<u>0</u></i>";
    let report = browser::check(&sheet.with("values.html", values));
    let expected = [("best.score", "0.2478"), ("runs", "10")];
    assert_eq!(report.values, expected.map(|(name, text)| (name.to_string(), text.to_string())));
    assert_eq!(report.faults(), [""; 0]);
}
