use super::*;
use crate::design::profile::{NATURAL, PAPER};
use crate::objective::terms::TERMS;
use crate::session::values::Size;

/// The TOML blocks of the reference, of those that begin with `fence`.
fn documented(fence: &str) -> String {
    let page = include_str!("../../../docs/CONFIGURATION.md");
    let fence = format!("```{fence}\n");
    let blocks = page.split(&fence).skip(1);
    blocks.filter_map(|block| block.split("```").next()).collect()
}

fn parse(text: &str) -> Settings {
    parsed(text, None, profile::DEFAULT).unwrap()
}

fn parsed(
    text: &str,
    asked: Option<&'static Profile>,
    usual: &'static Profile,
) -> Result<Settings, toml::de::Error> {
    Settings::parse(text, toml::Table::new(), asked, usual)
}

/// All keys of a table, dotted.
fn keys(table: &toml::Table, prefix: &str, out: &mut Vec<String>) {
    for (key, value) in table {
        let name = format!("{prefix}{key}");
        match value {
            toml::Value::Table(inner) => keys(inner, &format!("{name}."), out),
            _ => out.push(name),
        }
    }
}

#[test]
fn the_documented_defaults_are_the_paper_s_and_complete() {
    let text = documented("toml");
    let settings = parse(&text);
    assert_eq!(settings, Settings::of(&PAPER));
    settings.check().unwrap();
    let (mut written, mut all) = (Vec::new(), Vec::new());
    keys(&toml::from_str(&text).unwrap(), "", &mut written);
    keys(&toml::Table::try_from(&settings).unwrap(), "", &mut all);
    written.sort();
    all.sort();
    assert_eq!(written, all);
}

#[test]
fn the_documented_profile_natural_is_all_that_differs_from_the_paper_s() {
    let text = documented("toml natural");
    let natural = parse(&text);
    assert_eq!(natural, Settings::of(&NATURAL));
    assert_eq!(parse("profile = \"natural\""), natural);
    natural.check().unwrap();
    // Without its first line the block still says everything, over the paper's.
    let rest = text.replace("profile = \"natural\"\n", "");
    let over = parsed(&rest, None, &PAPER).unwrap();
    assert_eq!(over, Settings { profile: ProfileName(&PAPER), ..natural });
}

#[test]
fn a_file_starts_from_the_profile_that_it_names_or_is_asked_for() {
    let text = "profile = \"natural\"\nseed = 7\n[objective]\nedge_contrast = 0.1\n\
                [shading]\nambient = 0.5\n[lights]\nkind = \"spot\"\n";
    let mut natural = Settings::of(&NATURAL);
    natural.seed = 7;
    natural.objective.edge_contrast = 0.1;
    natural.shading.ambient = 0.5;
    natural.lights.kind = LightKind::SPOT;
    assert_eq!(parse(text), natural);
    assert_eq!(parsed(text, None, &PAPER).unwrap(), natural);
    let paper = parsed(text, Some(&PAPER), &NATURAL).unwrap();
    assert_eq!((paper.profile, paper.seed), (ProfileName(&PAPER), 7));
    assert_eq!(paper.objective.weights, Objective::default().weights);
    assert_eq!(paper.objective.edge_contrast, 0.1);
    assert_eq!(parsed("", None, &NATURAL).unwrap(), Settings::of(&NATURAL));
    // Weights and boxes that are given are taken whole.
    let text = "[objective.weights]\nedge = 1\n[lights.boxes.fill]\nelevation = [0, 1]\n\
                azimuth = [0, 1]\ndiffuse = [0, 1]\ndistance = [1, 2]\n";
    let given = parsed(text, None, &NATURAL).unwrap();
    assert!(given.objective.weights.names().eq(["edge"]));
    assert!(!given.lights.boxes.fill.share_of_key);
    assert_eq!(given.lights.boxes.rim, natural.lights.boxes.rim);
    assert_eq!(given.objective.mean_target, natural.objective.mean_target);
    let fault = parsed("seed = 1\nprofile = \"film\"", None, &PAPER).unwrap_err();
    let fault = fault.to_string();
    assert!(fault.contains("line 2") && fault.contains("paper, natural"), "{fault}");
}

#[test]
fn only_a_colour_that_is_given_counts_as_background() {
    let judged = |text: &str| parse(text).objective.background;
    assert_eq!(judged("[picture]\nsamples = 4"), None);
    assert_eq!(judged("[picture]\nbackground = \"transparent\""), None);
    let white = judged("[picture]\nbackground = \"#ffffff\"").unwrap();
    assert!((white - 1.0).abs() < 1e-6, "{white}");
    let default = judged("[picture]\nbackground = \"#3a3c42\"").unwrap();
    assert!((0.2..0.3).contains(&default), "{default}");
    let fault = parsed("[objective]\nbackground = 0.5", None, &PAPER).unwrap_err();
    assert!(fault.to_string().contains("background"), "{fault}");
}

#[test]
fn the_documented_view_keys_are_known() {
    // A comment of the form `# key = value` is a key that is absent by default.
    let uncomment = |line: &str| {
        let key = line.strip_prefix("# ").filter(|rest| rest.split(' ').nth(1) == Some("="));
        format!("{}\n", key.unwrap_or(line))
    };
    let text = documented("toml");
    let lines = text.lines().filter(|line| !line.starts_with("# camera"));
    let text: String = lines.map(uncomment).collect();
    let settings = parse(&text);
    assert!(settings.view.framed() && settings.view.size == Some(Size([512, 512])));
    settings.check().unwrap();
}

#[test]
fn faults_name_file_line_and_key() {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), "seed = 1\n[search]\npopulatoin = 3\n").unwrap();
    let fault = Settings::read(file.path(), None, profile::DEFAULT).unwrap_err();
    let text = fault.to_string();
    assert!(fault.is_input());
    assert!(text.contains(&file.path().display().to_string()), "{text}");
    assert!(text.contains("line 3") && text.contains("populatoin"), "{text}");
}

#[test]
fn weights_are_those_of_any_terms() {
    let read = |text: &str| parsed(text, None, &PAPER).map(|settings| settings.objective);
    let objective = read("[objective.weights]\nrelief = 0.5\nedge = 0\nmean = 0.25").unwrap();
    let weights: Vec<_> = objective.weights.iter().map(|(t, w)| (t.name, w)).collect();
    assert_eq!(weights, [("edge", 0.0), ("mean", 0.25), ("relief", 0.5)]);
    let all: String = TERMS.iter().map(|term| format!("{} = 0.1\n", term.name)).collect();
    let objective = read(&format!("[objective.weights]\n{all}")).unwrap();
    assert!(objective.weights.names().eq(TERMS.iter().map(|term| term.name)));
    let fault = read("[objective]\n[objective.weights]\nedge = 1\nreleif = 1\n").unwrap_err();
    let fault = fault.to_string();
    for said in ["line 2", "no term 'releif'", "relief, direction, target"] {
        assert!(fault.contains(said), "{fault}");
    }
    assert!(read("[objective.weights]\nedge = true").is_err());
}

#[test]
fn values_out_of_range_are_refused() {
    for text in [
        "[objective]\nmean_target = nan",
        "[objective]\nmean_target = -1",
        "[objective]\nedge_contrast = 0.0",
        "[objective.weights]\nedge = -1.0\nmean = 1.0\ngrad = 1.0\nvar = 1.0\nhist = 1.0",
        "[objective.weights]\nedge = 0.0\nmean = 0.0\ngrad = 0.0\nvar = 0.0\nhist = 0.0",
        "[objective.weights]\ntarget = 1.0",
        "[objective.weights]",
        "[shading]\nambient = inf",
        "[view]\nfov = 180.0",
        "[view]\ncamera = 0\nfov = 35.0",
        "[search]\npopulation = 1",
        "[greedy]\nstarts = 0",
        "[greedy]\nstarts = 1025",
    ] {
        let settings = parse(text);
        assert!(settings.check().is_err(), "{text}");
    }
    for text in ["[view]\nsize = \"0x5\"", "[lights]\nroles = 17", "device = true"] {
        assert!(toml::from_str::<Settings>(text).is_err(), "{text}");
    }
}

#[test]
fn intensities_are_one_or_two() {
    let mut lights = LightSettings::default();
    let two = lights.boxes.fill.specular;
    lights.set_intensities(true);
    assert_eq!(lights.boxes.fill.specular, None);
    lights.set_intensities(false);
    assert_eq!(lights.boxes.fill.specular, two);
}

#[test]
fn tables_stand_in_the_place_of_what_a_file_says() {
    let over = toml::toml! { search.generations = 7 };
    let file = "seed = 3\n[search]\ngenerations = 5\npopulation = 8";
    let settings = Settings::parse(file, over, None, &NATURAL).unwrap();
    let GeneticSettings { generations, population, .. } = settings.search;
    assert_eq!((settings.seed, generations, population), (3, 7, 8));
    let over = toml::toml! { search.generation = 7 };
    let fault = Settings::parse(file, over, None, &NATURAL).unwrap_err().to_string();
    assert!(fault.contains("generation"), "{fault}");
}

#[test]
fn lights_that_are_neither_a_number_nor_roles_are_told() {
    let fault = parsed("[lights]\nroles = [\"back\"]", None, &NATURAL).unwrap_err().to_string();
    assert!(fault.contains("line 2") && fault.contains("a list of roles"), "{fault}");
}
