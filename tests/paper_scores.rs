//! The paper's objective keeps its bits: stored scores of the project's scenes.

use klieg::cpu::{self, CpuEvaluator};
use klieg::evaluate::Evaluator;
use klieg::gpu::{Context, ContextOptions, GpuEvaluator, PipelineKind};
use klieg::lighting::shading::Shading;
use klieg::lighting::{Light, LightKind};
use klieg::objective::Objective;
use klieg::scene::Scene;
use klieg::scene::view::View;
use klieg_support::gpu::{population, rigs};

/// The driver whose bits are stored; any other has to come close.
const STORED_DRIVER: &str = "llvmpipe Mesa 22.3.6 (LLVM 15.0.6)";

/// Bits of the scores of [`rigs`] in each scene: native, `layered` and `compute` on the stored driver.
const STORED: [(&str, [[u32; 6]; 3]); 3] = [
    (
        "elephant",
        [
            [0x3f26b5fb, 0x3e997c9b, 0x3f20d3a4, 0x3edf90b5, 0x3ee69075, 0x3ed37093],
            [0x3f26b5fc, 0x3e997c9b, 0x3f20d3a4, 0x3edf90b2, 0x3ee69075, 0x3ed37093],
            [0x3f26b5fc, 0x3e997c9b, 0x3f20d3a4, 0x3edf90b4, 0x3ee69075, 0x3ed37092],
        ],
    ),
    (
        "pair",
        [
            [0x3f266bda, 0x3eace4d5, 0x3f1f8553, 0x3edcd603, 0x3ee9bf54, 0x3ec74094],
            [0x3f266bd9, 0x3eace4d6, 0x3f1f8554, 0x3edcd601, 0x3ee9bf53, 0x3ec74094],
            [0x3f266bda, 0x3eace4d5, 0x3f1f8554, 0x3edcd601, 0x3ee9bf54, 0x3ec74094],
        ],
    ),
    (
        "still-life",
        [
            [0x3f164d37, 0x3e919341, 0x3f1787c2, 0x3e9fef63, 0x3f0082ca, 0x3e76823a],
            [0x3f164d38, 0x3e919340, 0x3f1787c2, 0x3e9fef63, 0x3f0082b4, 0x3e76823b],
            [0x3f164d37, 0x3e919340, 0x3f1787c2, 0x3e9fef63, 0x3f0082b4, 0x3e76823a],
        ],
    ),
];

fn open(name: &str) -> (Scene, View) {
    let path = klieg_support::root().join(format!("scenes/{name}.glb"));
    let scene = klieg::scene::load::load(&path).expect("a scene of the project");
    let view = View::new(&scene, scene.cameras[0].clone(), 192, 192).expect("a view");
    (scene, view)
}

/// Six rigs, of one, two and three lights.
fn all_rigs() -> Vec<Vec<Light>> {
    let pairs = [(1, LightKind::POINT), (2, LightKind::DIRECTIONAL), (3, LightKind::POINT)];
    pairs.into_iter().flat_map(|(lights, kind)| rigs(lights as u64, 2, lights, kind)).collect()
}

fn scores(evaluator: &mut dyn Evaluator) -> [u32; 6] {
    let mut scores = all_rigs().into_iter().map(|rig| {
        let mut score = [0.0];
        evaluator.evaluate(&population(&[rig]), &mut score).expect("a score");
        score[0].to_bits()
    });
    std::array::from_fn(|_| scores.next().expect("six rigs"))
}

#[test]
fn scores_of_the_paper_keep_their_bits() {
    let (objective, shading) = (Objective::default(), Shading::default());
    for (name, stored) in STORED {
        let (scene, view) = open(name);
        let maps = cpu::maps(cpu::visibility::draw(&scene, &view), &objective);
        let mut native = CpuEvaluator::new(maps.clone(), &view, objective, shading).expect("maps");
        let pipelines = [PipelineKind::Layered, PipelineKind::Compute];
        let found = [None, Some(pipelines[0]), Some(pipelines[1])].map(|pipeline| {
            let Some(pipeline) = pipeline else { return (scores(&mut native), true) };
            let mut options = ContextOptions::default();
            options.tuning.pipeline = Some(pipeline);
            let context = Context::new(&options).expect("a Vulkan device");
            let mut gpu = GpuEvaluator::with_maps(&context, &maps, &view, objective, shading)
                .expect("an evaluator");
            let info = gpu.device().clone();
            let exact = format!("{} {}", info.name, info.driver).contains(STORED_DRIVER);
            (scores(&mut gpu), exact)
        });
        for ((found, exact), stored) in found.into_iter().zip(stored) {
            if exact {
                assert_eq!(found, stored, "{name}");
            }
            for (found, stored) in found.into_iter().zip(stored) {
                let (found, stored) = (f32::from_bits(found), f32::from_bits(stored));
                assert!((found - stored).abs() < 2e-5, "{name}: {found} {stored}");
            }
        }
    }
}
