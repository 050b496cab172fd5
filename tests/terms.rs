//! The terms of objectives: their formulas by hand, and the table of the shaders.

use klieg::lighting::direction;
use klieg::objective::maps::{PixelCounts, Shape, ViewStatistics};
use klieg::objective::terms::TERMS;
use klieg::objective::{
    Example, HISTOGRAM_BINS, Irradiance, MeanTarget, Objective, Statistics, Term, Terms, terms,
};
use std::path::Path;

fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance, "{a} is not {b}");
}

fn picture(change: impl FnOnce(&mut Statistics)) -> Statistics {
    let mut picture = Statistics::default();
    picture.histogram[0] = 1;
    change(&mut picture);
    picture
}

/// A view with edges, surfaces, detail and normals whose covariances are 0.2399, 0 and 0.0399: with the
/// ridge, the precision is 1/0.24, 0 and 1/0.04.
fn view() -> ViewStatistics {
    ViewStatistics {
        counts: PixelCounts { surface: 90, edge: 10 },
        normal_detail: 0.2,
        shape: Shape {
            normal_covariance: [0.2399, 0.0, 0.0399],
            detail_weight: 3.0,
            base_luminance: 0.5,
            ..Shape::default()
        },
    }
}

fn flat() -> ViewStatistics {
    ViewStatistics { counts: PixelCounts { surface: 90, edge: 0 }, ..ViewStatistics::default() }
}

fn relief(variance: f32, covariance: [f32; 2]) -> Statistics {
    picture(|p| p.irradiance = Irradiance { mean: 0.5, variance, covariance })
}

fn key(elevation: f32, azimuth: f32) -> Statistics {
    let key = direction(elevation.to_radians(), azimuth.to_radians()).to_array();
    picture(|p| p.key = key)
}

/// Pictures of views, and what each term makes of them: by hand.
fn by_hand() -> Vec<(&'static str, Statistics, ViewStatistics, f32)> {
    let even = picture(|p| p.histogram = [3; HISTOGRAM_BINS]);
    let halves = picture(|p| (p.histogram[0], p.histogram[9]) = (5, 5));
    vec![
        ("edge", picture(|p| p.edge_contrast = 0.75), view(), 0.25),
        ("edge", picture(|p| p.edge_contrast = 0.75), flat(), 0.0),
        ("mean", picture(|p| p.mean = 0.5), view(), 0.0),
        ("mean", picture(|p| p.mean = 0.2), view(), 0.6),
        ("mean", picture(|p| p.mean = 1.0), view(), 1.0),
        ("grad", picture(|p| p.gradient = 0.05), view(), 0.75),
        ("grad", picture(|p| p.gradient = 0.3), view(), 0.0),
        ("grad", picture(|p| p.gradient = 0.05), flat(), 0.0),
        // An even spread over 0..1 has the variance 1/12.
        ("var", picture(|p| p.variance = 1.0 / 12.0), view(), 0.0),
        ("var", picture(|p| p.variance = 1.0 / 48.0), view(), 0.5),
        ("var", picture(|p| p.variance = 0.25), view(), 0.0),
        ("hist", even, view(), 0.0),
        ("hist", picture(|_| ()), view(), 1.0),
        // Two of 32 equal shares: one bit of five.
        ("hist", halves, view(), 0.8),
        ("detail", picture(|p| p.detail = 0.3), view(), 0.7),
        ("detail", picture(|p| p.detail = 0.3), flat(), 0.0),
        ("range", picture(|p| p.variance = 0.01), view(), 0.5),
        ("range", picture(|p| p.variance = 0.09), view(), 0.0),
        ("burnt", picture(|p| p.burnt = 0.005), view(), 0.0),
        ("burnt", picture(|p| p.burnt = 0.015), view(), 0.1),
        ("burnt", picture(|p| p.burnt = 0.5), view(), 1.0),
        ("unlit", picture(|_| ()), view(), 0.0),
        ("unlit", picture(|p| p.unlit = 0.05), view(), 0.2),
        ("unlit", picture(|p| p.unlit = 0.4), view(), 1.0),
        // R² = 0.06²/0.24/0.1 = 0.15, and 0.02²/0.04/0.1 = 0.1: a quarter and a sixth of 0.6.
        ("relief", relief(0.1, [0.06, 0.0]), view(), 0.75),
        ("relief", relief(0.1, [0.0, -0.02]), view(), 5.0 / 6.0),
        ("relief", relief(0.1, [0.06, 0.02]), view(), 1.0 - 0.25 / 0.6),
        ("relief", relief(0.0, [0.0, 0.0]), view(), 1.0),
        ("relief", relief(0.02, [0.06, 0.0]), view(), 0.0),
        ("relief", relief(0.1, [0.06, 0.0]), flat(), 0.0),
        ("direction", key(30.0, 35.0), view(), 0.0),
        ("direction", key(30.0, -35.0), view(), 0.0),
        ("direction", key(44.0, 35.0), view(), 0.0),
        // 45° off, half way from 15° to 75°.
        ("direction", key(75.0, 35.0), view(), 0.5),
        ("direction", key(-60.0, 35.0), view(), 1.0),
        ("direction", picture(|_| ()), view(), 0.0),
        ("target", picture(|_| ()), view(), 0.0),
        ("target", picture(|p| p.residual = 0.01), view(), 0.125 / 0.35),
        ("target", picture(|p| p.residual = 1.0), view(), 1.0),
        ("outline", picture(|_| ()), view(), 0.0),
        ("outline", picture(|p| p.outline = 0.35), view(), 0.35),
        ("outline", picture(|p| p.outline = 1.0), view(), 1.0),
        ("entropy", picture(|p| p.entropy = 32f32.ln()), view(), 0.0),
        // Two of 32 equal shares, as of the histogram.
        ("entropy", picture(|p| p.entropy = 2f32.ln()), view(), 0.8),
        ("entropy", picture(|p| p.entropy = 2f32.ln()), flat(), 0.0),
        ("example", counted(&[(0, 50), (8, 50)], 0.1), view(), 0.0),
        // Half of the pixels eight bins too low: an eighth of the range, half of what makes it 1; half of the gradient.
        ("example", counted(&[(0, 100)], 0.05), view(), 0.5),
        ("example", counted(&[(31, 100)], 0.1), view(), 0.75),
        // 0.2 is aimed at, of which 0.3 is the largest distance.
        ("spread", picture(|p| p.variance = 0.04), view(), 0.0),
        ("spread", picture(|p| p.variance = 0.0025), view(), 0.5),
        ("spread", picture(|p| p.variance = 0.25), view(), 1.0),
    ]
}

/// The default with an example: half of it black, half at a quarter of the range.
fn objective() -> Objective {
    let mut histogram = [0.0; HISTOGRAM_BINS];
    (histogram[0], histogram[8]) = (0.5, 0.5);
    Objective { example: Some(Example { histogram, gradient: 0.1 }), ..Objective::default() }
}

/// A picture of `view()` with these numbers of pixels in bins of the histogram.
fn counted(counts: &[(usize, u32)], gradient: f32) -> Statistics {
    let mut picture = Statistics { gradient, ..Statistics::default() };
    counts.iter().for_each(|&(bin, count)| picture.histogram[bin] = count);
    picture
}

/// Cases in which a formula is off, in words.
fn wrong(
    cases: &[(&str, Statistics, ViewStatistics, f32)],
    formula: Option<Formula>,
) -> Vec<String> {
    let check = |(name, picture, view, expected): &(&str, Statistics, ViewStatistics, f32)| {
        let formula = formula.unwrap_or(Term::named(name).expect("a term").formula);
        let found = formula(picture, view, &objective());
        let off = (found - expected).abs();
        (off.is_nan() || off > 1e-5).then(|| format!("{name}: {found}, not {expected}"))
    };
    cases.iter().filter_map(check).collect()
}

type Formula = fn(&Statistics, &ViewStatistics, &Objective) -> f32;

#[test]
fn every_formula_gives_what_a_hand_computes() {
    let cases = by_hand();
    assert_eq!(wrong(&cases, None), [""; 0]);
    for term in TERMS {
        let own: Vec<_> = cases.iter().copied().filter(|case| case.0 == term.name).collect();
        assert!(own.len() >= 2, "too few cases of {}", term.name);
        for other in TERMS.iter().filter(|other| **other != *term) {
            assert!(!wrong(&own, Some(other.formula)).is_empty(), "{} {}", term.name, other.name);
        }
    }
}

#[test]
fn the_target_of_the_mean_is_the_objectives() {
    let formula = Term::named("mean").expect("a term").formula;
    let judged = |mean_target| {
        let objective = Objective { mean_target, ..Objective::default() };
        f64::from(formula(&picture(|p| p.mean = 0.625), &view(), &objective))
    };
    // Of 0.75, the largest distance there can be.
    close(judged(MeanTarget::Value(0.25)), 0.5, 1e-6);
    // A stop above 0.5, 0.214 linear, is 0.428, encoded as 0.6858; two more end
    // at 0.9. Four below is 0.0134, encoded as 0.1198.
    let moved = |mean_stops: f32, mean: f32| {
        let objective = Objective { mean_stops, ..Objective::default() };
        f64::from(formula(&picture(|p| p.mean = mean), &view(), &objective))
    };
    for (stops, mean) in [(1.0, 0.6858), (3.0, 0.9), (-4.0, 0.1198)] {
        close(moved(stops, mean), 0.0, 2e-4);
    }
    // Half of the view's base luminance 0.5 is encoded as 0.5371.
    close(judged(MeanTarget::Scene), (0.625 - 0.5371) / 0.5371, 1e-3);
}

#[test]
fn the_preferred_direction_is_30_up_and_35_to_the_side() {
    let expected = direction(30f32.to_radians(), 35f32.to_radians());
    assert!(terms::direction::PREFERRED.abs_diff_eq(expected, 1e-6));
    assert!(!terms::direction::PREFERRED.abs_diff_eq(-expected, 1e-6));
}

#[test]
fn only_what_terms_of_some_weight_need_is_measured() {
    let mut objective = Objective {
        weights: Terms::named([("mean", 1.0)]).expect("a term"),
        ..Objective::default()
    };
    for term in TERMS {
        objective.weights.set(term, f32::from(u8::from(term.name == "mean"))).expect("room");
    }
    assert!(objective.needs().names().next().is_none());
    let free: Vec<_> = objective.measured().names().collect();
    assert_eq!(free, ["edge", "mean", "grad", "var", "hist", "range", "direction", "spread"]);
    objective.weights.set(Term::named("unlit").expect("a term"), 0.5).expect("room");
    assert!(objective.measured().names().any(|name| name == "relief"), "both need irradiance");
    let quality = objective.quality(&picture(|p| (p.mean, p.unlit) = (0.5, 0.05)), &view());
    close(quality.score.into(), 0.5 * 0.2, 1e-6);
    assert_eq!(quality.terms.names().count(), 10);
}

#[test]
fn the_outline_counts_only_before_a_given_background() {
    let weights = Terms::named([("mean", 0.5), ("outline", 0.25)]).expect("terms");
    let unknown = Objective { weights, ..Objective::default() };
    let white = Objective { background: Some(1.0), ..unknown };
    let seen = picture(|p| (p.mean, p.outline) = (0.5, 0.8));
    assert!(unknown.needs().names().next().is_none() && unknown.measured().names().eq(["mean"]));
    assert_eq!(unknown.quality(&seen, &view()).score, 0.0);
    assert!(white.needs().names().eq(["background"]));
    close(white.quality(&seen, &view()).score.into(), 0.25 * 0.8, 1e-6);
    let alone = |background| {
        let weights = Terms::named([("outline", 1.0)]).expect("a term");
        Objective { weights, background, ..Objective::default() }.check()
    };
    let fault = alone(None).expect_err("nothing counts").to_string();
    assert!(fault.contains("need a background"), "{fault}");
    assert!(
        alone(Some(0.0)).is_ok() && alone(Some(1.5)).is_err() && alone(Some(f32::NAN)).is_err()
    );
}

/// How the shaders' terms differ from [`TERMS`], in words.
fn differences(table: &str, files: &[String]) -> Vec<String> {
    let own: Vec<_> = TERMS.iter().map(|term| term.name).collect();
    let after = |start: &str, end: char| {
        let parts = table.split(start).skip(1).filter_map(|rest| rest.split_once(end));
        parts.map(|(name, _)| name.to_owned()).collect::<Vec<_>>()
    };
    let indices: Vec<_> = (0..own.len()).map(|index| index.to_string()).collect();
    let mut sorted = own.clone();
    sorted.sort_unstable();
    let mut found = Vec::new();
    let mut compare = |what: &str, there: Vec<String>, expected: &[&str]| {
        if there != expected {
            found.push(format!("{what}: {there:?}, not {expected:?}"));
        }
    };
    compare("includes", after("#include \"terms/", '.'), &own);
    compare("functions", after("term_", '('), &own);
    let numbers = after("    TERM(", ',');
    compare("indices", numbers, &indices.iter().map(String::as_str).collect::<Vec<_>>());
    compare("files", files.to_vec(), &sorted);
    found
}

/// The file names of a folder without their endings.
fn stems(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("a file"));
    let stem = |path: &Path| path.file_stem().expect("a name").to_string_lossy().into_owned();
    let mut stems: Vec<_> = entries.map(|entry| stem(&entry.path())).collect();
    stems.sort();
    stems
}

#[test]
fn shaders_and_host_have_the_same_terms_in_the_same_order() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let include = root.join("shaders/include");
    let table = std::fs::read_to_string(include.join("terms.glsl")).expect("the table");
    let files = stems(&include.join("terms"));
    assert_eq!(differences(&table, &files), [""; 0]);
    let mut hosts = stems(&root.join("src/objective/terms"));
    hosts.retain(|name| name != "mod");
    assert_eq!(files, hosts);
    for name in &files {
        let source = std::fs::read_to_string(include.join("terms").join(format!("{name}.glsl")));
        let source = source.expect("a file of the folder");
        assert!(source.contains(&format!("float term_{name}(")), "{name}");
        assert!(source.contains(&format!("src/objective/terms/{name}.rs")), "{name}");
    }
    for (from, to) in [
        ("#include \"terms/mean.glsl\"\n", ""),
        ("term_grad(", "term_var("),
        ("    TERM(3, ", "    TERM(2, "),
    ] {
        assert!(table.contains(from), "{from}");
        assert_eq!(differences(&table.replacen(from, to, 1), &files).len(), 1, "{from}");
    }
    assert_eq!(differences(&table, &files[1..]).len(), 1);
}
