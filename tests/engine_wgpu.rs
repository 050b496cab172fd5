//! The example of an engine on wgpu, run as it stands: it fails by itself where klieg's scores differ
//! from the native evaluator's or the validation layer speaks, and leaves what it compared.

use assert_cmd::Command;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::{env, fs};

/// Largest difference of a score from the native evaluator's.
const TOLERANCE: f32 = 1e-4;

/// cargo builds a package's examples for its tests, in a folder beside them.
fn example() -> PathBuf {
    let test = env::current_exe().unwrap();
    let name = format!("engine_wgpu{}", env::consts::EXE_SUFFIX);
    let program = test.ancestors().nth(2).unwrap().join("examples").join(name);
    assert!(program.exists(), "`cargo build --example engine_wgpu` makes {}", program.display());
    program
}

/// `scores.csv`: klieg's and the native score of every rig, by level.
fn scores(folder: &Path) -> BTreeMap<String, Vec<[f32; 2]>> {
    let text = fs::read_to_string(folder.join("scores.csv")).unwrap();
    let mut levels = BTreeMap::<_, Vec<_>>::new();
    for line in text.lines().skip(1) {
        let fields: Vec<_> = line.split(',').collect();
        let pair = [1, 2].map(|column| fields[column].parse().unwrap());
        levels.entry(fields[0].to_owned()).or_default().push(pair);
    }
    levels
}

fn agree(pairs: impl IntoIterator<Item = [f32; 2]>) -> bool {
    pairs.into_iter().all(|[klieg, native]| (klieg - native).abs() <= TOLERANCE)
}

#[test]
fn an_engine_on_wgpu_has_its_lights_designed() {
    let folder = tempfile::tempdir().unwrap();
    let run = Command::new(example()).arg(folder.path()).assert().success();
    let said = String::from_utf8_lossy(&run.get_output().stdout).into_owned();

    let levels = scores(folder.path());
    assert_eq!(levels.keys().collect::<Vec<_>>(), ["pictures", "surface"], "{said}");
    for (level, pairs) in &levels {
        assert!(pairs.len() > 20, "{level}: {}", pairs.len());
        assert!(agree(pairs.iter().copied()), "{level}: {pairs:?}");
        // The comparison can fail: another rig's score is not near enough.
        let (first, others) = (pairs[0], &pairs[1..]);
        assert!(!agree(others.iter().map(|other| [first[0], other[1]])), "{level}: {pairs:?}");

        let picture = |when| {
            let file = folder.path().join(format!("{level}-{when}.png"));
            image::open(file).unwrap().into_rgb8()
        };
        let (before, after) = (picture("before"), picture("after"));
        assert_eq!((before.dimensions(), after.dimensions()), ((254, 190), (254, 190)));
        assert_ne!(before, after, "{level}");
    }
}
