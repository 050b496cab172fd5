use super::*;
use crate::session::config::Settings;
use crate::session::values::{Device, Size};
use rand::RngExt;
use std::path::Path;

const WANTED: Wanted = Wanted { count: 8, slack: SLACK };

fn open(scene: &str) -> (Session, Genome) {
    let mut settings = Settings { device: Device::Cpu, ..Settings::default() };
    settings.view.size = Some(Size([80, 80]));
    settings.search.generations = 30;
    settings.shadows.side = 15;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(scene);
    let genome = settings.genome().unwrap();
    (Session::open(&path, settings).unwrap(), genome)
}

fn least(pictures: &[&Picture]) -> f32 {
    let all: Vec<usize> = (0..pictures.len()).collect();
    crate::design::gallery::least(&all, |a, b| pictures[a].distance(pictures[b]))
}

/// The mean over draws of the least distance of as many of the rigs, drawn blindly from those that are good.
fn blind(session: &mut Session, origin: &Origin, limit: f32) -> f32 {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let rigs: Vec<Rig> = origin.others.iter().map(|one| origin.genome.decode(one)).collect();
    let population = Population::of(rigs.iter().map(Vec::as_slice)).unwrap();
    let qualities = session.evaluator.qualities(&population).unwrap();
    let eye = Eye::new(session).unwrap();
    let good = rigs.iter().zip(&qualities).filter(|(_, quality)| quality.score <= limit);
    let good: Vec<Picture> = good.map(|(rig, _)| eye.see(rig)).collect();
    assert!(good.len() >= 50, "{}", good.len());
    let draws = (0..200).map(|_| {
        let drawn: Vec<&Picture> =
            (0..WANTED.count).map(|_| &good[rng.random_range(0..good.len())]).collect();
        least(&drawn)
    });
    draws.sum::<f32>() / 200.0
}

#[test]
fn a_gallery_is_good_and_twice_as_spread_as_blind_choices() {
    for scene in ["elephant.glb", "still-life.glb"] {
        let (mut session, genome) = open(scene);
        let go_on = &mut |_: &Progress| ControlFlow::Continue(());
        let (outcome, origin) = search(&mut session, &genome, None, go_on).unwrap();
        let gallery = disperse(&mut session, &origin, WANTED, go_on).unwrap();
        let scores: Vec<f32> = gallery.rigs.iter().map(|shown| shown.quality.score).collect();
        assert_eq!(scores.len(), WANTED.count, "{scene}");
        assert!(scores.is_sorted(), "{scene}: {scores:?}");
        let limit = scores[0] + WANTED.slack;
        assert!(scores[WANTED.count - 1] <= limit, "{scene}: {scores:?}");
        // Scores are those of the rigs in whole pictures.
        for shown in &gallery.rigs {
            let quality = session.evaluator.inspect(&shown.rig).unwrap().quality();
            assert!((quality.score - shown.quality.score).abs() < 1e-6);
        }
        let firsts: Vec<_> = gallery.rigs.iter().filter(|shown| shown.first).collect();
        assert_eq!((firsts.len(), &firsts[0].rig), (1, &outcome.rig));
        let pictures: Vec<&Picture> = gallery.rigs.iter().map(|shown| &shown.picture).collect();
        let (chosen, drawn) = (least(&pictures), blind(&mut session, &origin, limit));
        println!("{scene}: {chosen} {drawn} {scores:?}");
        assert!(chosen > 2.0 * drawn, "{scene}: {chosen} {drawn}");
    }
}

#[test]
fn a_search_that_is_recorded_finds_the_same() {
    let (mut session, genome) = open("elephant.glb");
    let go_on = &mut |_: &Progress| ControlFlow::Continue(());
    let plain = crate::session::designer::search(&mut session, &genome, None, go_on).unwrap();
    let (recorded, _) = search(&mut session, &genome, None, go_on).unwrap();
    assert_eq!(plain, recorded);
}

#[test]
fn an_observer_ends_the_dispersion_with_what_there_is() {
    let (mut session, genome) = open("elephant.glb");
    let go_on = &mut |_: &Progress| ControlFlow::Continue(());
    let (_, origin) = search(&mut session, &genome, None, go_on).unwrap();
    let stop = &mut |_: &Progress| ControlFlow::Break(());
    let gallery = disperse(&mut session, &origin, WANTED, stop).unwrap();
    assert!(gallery.stopped && gallery.rigs.len() > 1);
}
