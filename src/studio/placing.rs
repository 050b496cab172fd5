//! What is under the pointer, and lights that are put where something of them falls there.

use super::answers::Answer;
use super::convert::{chosen, rig};
use super::hall::Hall;
use super::messages::{Light, Pick, Place, What};
use super::stage::Sight;
use super::worker::Worker;
use crate::Result;
use crate::cpu::visibility;
use crate::lighting::mirrored;
use crate::objective::maps::Surface;
use crate::scene::view::View;
use glam::Vec3;

/// How far a rim's light grazes above the surface, radians.
const GRAZING: f32 = 0.17;

/// A place of the surface, light frame.
#[derive(Debug, Clone, Copy)]
struct Spot {
    code: u32,
    position: Vec3,
    normal: Vec3,
    to_viewer: Vec3,
}

impl Spot {
    /// What of a surface is under a pixel.
    fn of(surface: &Surface, view: &View, [x, y]: [f32; 2]) -> Option<Self> {
        let inside = |at: f32, count: u32| (0.0..count as f32).contains(&at).then_some(at as usize);
        let column = inside(x, surface.width)?;
        let at = inside(y, surface.height)? * surface.width as usize + column;
        let (code, position) = (surface.code[at], Vec3::from(surface.position[at]));
        let normal = Vec3::from(surface.normal[at]);
        let to_viewer = view.towards_viewer(position);
        (code != 0).then_some(Self { code, position, normal, to_viewer })
    }

    /// The way to a light of which `what` falls here.
    fn towards(&self, what: What) -> Vec3 {
        let Self { normal: n, to_viewer: v, .. } = *self;
        let facing = n.dot(v).clamp(0.0, 1.0);
        match what {
            What::Shading => n,
            What::Highlight => mirrored(n, v).normalize_or(n),
            What::Rim => {
                // Between the way from the viewer and the surface's outward side, so that n·l = sin(grazing).
                let outward = (n - facing * v).normalize_or(Vec3::Y);
                let angle = std::f32::consts::FRAC_PI_2 + GRAZING - facing.acos();
                (outward * angle.sin() - v * angle.cos()).normalize_or(-v)
            }
        }
    }
}

impl Worker {
    /// What of the scene is under a pixel.
    fn spot(&mut self, hall: &Hall, sight: &Sight, pixel: [f32; 2]) -> Result<Option<Spot>> {
        if let Some(stage) = self.whole_of(sight) {
            let view = stage.view.clone();
            return Ok(Spot::of(&stage.maps()?.surface, &view, pixel));
        }
        let view = sight.view(&hall.held)?;
        Ok(Spot::of(&visibility::draw(&hall.held.scene, &view), &view, pixel))
    }

    /// Tells what is under a pixel.
    pub(super) fn pick(&mut self, pick: &Pick) -> Result<()> {
        let hall = self.hall()?;
        let sight = Sight { camera: pick.camera.clone(), size: pick.size };
        let spot = self.spot(&hall, &sight, pick.pixel)?;
        let scene = &hall.held.scene;
        let instance = spot.and_then(|spot| scene.polygon(spot.code));
        self.send(Answer::Picked {
            id: pick.id,
            name: instance.map(|(instance, _)| scene.instances[instance].name.clone()),
            normal: spot.map(|spot| spot.normal.to_array()),
            position: spot.map(|spot| spot.position.to_array()),
        })
    }

    /// Puts a light where something of it falls on a pixel.
    pub(super) fn place(&mut self, place: &Place) -> Result<()> {
        let hall = self.hall()?;
        let Place { id, light, what, pixel, .. } = *place;
        let lights = rig(&place.lights)?;
        let chosen = chosen(&lights, light)?;
        let sight = Sight { camera: place.camera.clone(), size: place.size };
        let Some(spot) = self.spot(&hall, &sight, pixel)? else {
            return self.send(Answer::Missed { id });
        };
        let put = chosen.seen_from(spot.position, spot.towards(what));
        let locked = place.lights[light as usize].locked;
        self.send(Answer::Placed { id, light, lit: Light { locked, ..Light::of(&put) } })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lighting::{self, LightKind};

    fn spot(normal: Vec3) -> Spot {
        let position = Vec3::new(0.3, -0.2, 0.4);
        Spot { code: 1, position, normal: normal.normalize(), to_viewer: Vec3::Z }
    }

    #[test]
    fn lights_stand_where_what_is_wanted_falls_on_the_place() {
        for kind in [LightKind::POINT, LightKind::DIRECTIONAL] {
            let light = lighting::Light { kind, distance: 2.5, ..Default::default() };
            for normal in [Vec3::new(0.5, 0.3, 0.8), Vec3::new(-0.9, 0.1, 0.2)] {
                let spot = spot(normal);
                let way = |what| {
                    let put = light.seen_from(spot.position, spot.towards(what));
                    match put.reach() {
                        Some(reach) => (put.direction() * reach - spot.position).normalize(),
                        None => put.direction(),
                    }
                };
                assert!(way(What::Shading).abs_diff_eq(spot.normal, 1e-4));
                let half = (way(What::Highlight) + spot.to_viewer).normalize();
                assert!(half.abs_diff_eq(spot.normal, 1e-4), "{half}");
                let rim = way(What::Rim);
                assert!((rim.dot(spot.normal) - GRAZING.sin()).abs() < 1e-4 && rim.z < 0.2);
            }
        }
    }

    #[test]
    fn nothing_is_under_the_background() {
        let surface = Surface {
            width: 2,
            height: 1,
            code: vec![0, 7],
            position: vec![[0.0; 3]; 2],
            normal: vec![[0.0, 0.0, 1.0]; 2],
            ..Surface::default()
        };
        let scene = crate::scene::load::load(
            &std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/pair.glb"),
        );
        let scene = scene.unwrap();
        let camera = crate::scene::framing::frame(&scene, &Default::default(), 2.0).unwrap();
        let view = View::new(&scene, camera, 2, 1).unwrap();
        let found = |x, y| Spot::of(&surface, &view, [x, y]).map(|spot| spot.code);
        assert_eq!((found(0.5, 0.5), found(1.5, 0.5)), (None, Some(7)));
        for outside in [[-0.5, 0.5], [2.0, 0.5], [1.5, 1.0], [f32::NAN, 0.5]] {
            assert_eq!(found(outside[0], outside[1]), None);
        }
    }
}
