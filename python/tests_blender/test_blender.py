"""The add-on, in Blender's Python package: `make test-blender`."""

from __future__ import annotations

import math
import tempfile
import unittest
from pathlib import Path
from typing import Any

import bpy
import klieg_addon
import numpy as np
from PIL import Image

import klieg
import klieg.blender

QUICK: dict[str, Any] = {"device": "cpu", "generations": 12, "population": 10, "coarse": 0}
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def furnish() -> None:
    """Make a scene with an instance, a modifier, a rig and a camera."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("dark")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
    scene.render.resolution_x, scene.render.resolution_y = 160, 120
    scene.view_settings.view_transform = "Standard"
    grey = bpy.data.materials.new("grey")
    grey.use_nodes = True
    shader = grey.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (0.5, 0.4, 0.3, 1)
    shader.inputs["Roughness"].default_value = 0.8

    bpy.ops.mesh.primitive_monkey_add(location=(0, 0, 1))
    monkey = bpy.context.object
    monkey.modifiers.new("smooth", "SUBSURF").render_levels = 1
    bpy.ops.object.shade_smooth()
    bpy.ops.mesh.primitive_plane_add(size=6)
    for made in (monkey, bpy.context.object):
        made.data.materials.append(grey)

    hidden = bpy.data.collections.new("source")
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.4)
    ball = bpy.context.object
    ball.data.materials.append(grey)
    for collection in ball.users_collection:
        collection.objects.unlink(ball)
    hidden.objects.link(ball)
    for x in (-1.6, 1.6):
        empty = bpy.data.objects.new("instance", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", hidden
        empty.location = (x, -0.5, 0.4)
        scene.collection.objects.link(empty)

    bpy.ops.object.armature_add()
    rig = bpy.context.object
    bpy.ops.mesh.primitive_cube_add(size=0.5)
    cube = bpy.context.object
    cube.data.materials.append(grey)
    group = cube.vertex_groups.new(name="Bone")
    group.add(range(8), 1.0, "REPLACE")
    cube.modifiers.new("rig", "ARMATURE").object = rig
    rig.pose.bones["Bone"].location = (0, 0.8, 0)
    rig.location = (0.2, -1.6, 0)

    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    camera.location = (2.5, -6, 3)
    camera.rotation_euler = (math.radians(67), 0, math.radians(22))
    scene.camera = camera
    bpy.context.view_layer.update()


def rendered() -> np.ndarray[Any, Any]:
    """Return what Cycles makes of the scene, sRGB 0..255."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 32
    scene.cycles.use_denoising = False
    scene.cycles.max_bounces = 0
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "picture.png")
        bpy.ops.render.render(write_still=True)
        return np.asarray(Image.open(scene.render.filepath).convert("RGB"), dtype=float)


def ours() -> list[Any]:
    collection = bpy.data.collections.get(klieg.blender.COLLECTION)
    return [] if collection is None else list(collection.objects)


class LightsInBlender(unittest.TestCase):
    def setUp(self) -> None:
        furnish()

    def test_the_evaluated_scene_is_what_klieg_sees(self) -> None:
        scene, view = klieg.blender.look(bpy.context, keep_lights=False)
        maps = klieg.Evaluator(scene, view, device="cpu").maps()
        bpy.context.scene.render.film_transparent = True
        sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
        bpy.context.scene.collection.objects.link(sun)
        scene_render = bpy.context.scene.render
        scene_render.image_settings.color_mode = "RGBA"
        with tempfile.TemporaryDirectory() as folder:
            scene_render.engine = "CYCLES"
            bpy.context.scene.cycles.samples = 8
            scene_render.filepath = str(Path(folder) / "mask.png")
            bpy.ops.render.render(write_still=True)
            alpha = np.asarray(Image.open(scene_render.filepath))[..., 3]
        same = (alpha > 127) == (maps["code"] > 0)
        self.assertGreater(same.mean(), 0.99)

    def test_materials_count_triangle_by_triangle_with_their_textures_and_attributes(self) -> None:
        for old in list(bpy.data.objects):
            if old.type == "MESH" or old.instance_type == "COLLECTION":
                bpy.data.objects.remove(old)
        # Two squares side by side: on the left a texture of four colours, on the right an attribute, above a plain one.
        image = bpy.data.images.new("four", 32, 32)
        four = np.array([[[0.8, 0.1, 0.1, 1], [0.1, 0.8, 0.1, 1]], [[0.1, 0.1, 0.8, 1], [0.8, 0.8, 0.1, 1]]])
        image.pixels.foreach_set(four.repeat(16, 0).repeat(16, 1).astype(np.float32).ravel())
        points = [(x, 0, z) for z in (0, 2, 3) for x in (-2, 0, 2)]
        mesh = bpy.data.meshes.new("squares")
        mesh.from_pydata(points, [], [(0, 1, 4, 3), (1, 2, 5, 4), (3, 4, 7, 6), (4, 5, 8, 7)])
        uvs = mesh.uv_layers.new(name="map").uv
        for loop, place in zip(range(4), [(0, 0), (1, 0), (1, 1), (0, 1)], strict=True):
            uvs[loop].vector = place
        painted = mesh.color_attributes.new("painted", "FLOAT_COLOR", "CORNER")
        for corner in painted.data:
            corner.color = (0.05, 0.5, 0.9, 1)
        for number, kind in enumerate(["TEX_IMAGE", "VERTEX_COLOR", None]):
            material = bpy.data.materials.new(f"material {number}")
            material.use_nodes = True
            tree = material.node_tree
            shader = tree.nodes["Principled BSDF"]
            shader.inputs["Roughness"].default_value = 1
            shader.inputs["Base Color"].default_value = (0.9, 0.4, 0.1, 1)
            if kind == "TEX_IMAGE":
                node = tree.nodes.new("ShaderNodeTexImage")
                node.image, node.interpolation = image, "Closest"
                tree.links.new(node.outputs["Color"], shader.inputs["Base Color"])
            elif kind == "VERTEX_COLOR":
                node = tree.nodes.new("ShaderNodeVertexColor")
                node.layer_name = "painted"
                tree.links.new(node.outputs["Color"], shader.inputs["Base Color"])
            mesh.materials.append(material)
        for polygon, slot in zip(mesh.polygons, (0, 1, 2, 2), strict=True):
            polygon.material_index = slot
        bpy.context.scene.collection.objects.link(bpy.data.objects.new("squares", mesh))
        camera = bpy.context.scene.camera
        camera.location, camera.rotation_euler = (0, -6, 1.5), (math.radians(90), 0, 0)
        bpy.context.view_layer.update()
        result = klieg.blender.light(bpy.context, lights=["key"], brdf="gltf", shadows=False, **QUICK)
        found = result.picture(samples=16)[..., :3].astype(float)
        expected = rendered()
        for x, y in [(25, 97), (62, 97), (25, 60), (62, 60), (117, 78), (45, 22), (117, 22)]:
            patch = (slice(y - 3, y + 4), slice(x - 3, x + 4))
            klieg_color, cycles_color = (picture[patch].mean((0, 1)) for picture in (found, expected))
            self.assertLess(np.abs(klieg_color - cycles_color).max(), 16, (x, y, klieg_color, cycles_color))
        self.assertGreater(np.ptp([found[y, x] for x, y in [(25, 97), (62, 97), (117, 78)]], axis=0).min(), 40)

    def test_cycles_shows_what_klieg_shows(self) -> None:
        result = klieg.blender.light(bpy.context, **QUICK)
        self.assertLess(result.score, result.headlight_score)
        self.assertEqual([held.data.type for held in ours()], ["POINT", "POINT"])
        picture, mine = rendered(), result.picture(samples=4)[..., :3].astype(float)
        objects = klieg.Evaluator(result.scene, result.view, device="cpu").maps()["code"] > 0
        difference = (picture[objects] - mine[objects]) @ LUMINANCE
        self.assertLess(abs(difference.mean()), 8)
        self.assertLess(np.abs(difference).mean(), 12)

    def test_new_lights_take_the_place_of_old_ones(self) -> None:
        for count in (2, 3):
            klieg.blender.light(bpy.context, lights=count, **QUICK)
            self.assertEqual(len(ours()), count)

    def test_locked_lights_are_kept_and_others_hidden(self) -> None:
        lamps = {}
        for name, power in (("locked", 400.0), ("free", 300.0)):
            lamp = bpy.data.objects.new(name, bpy.data.lights.new(name, "POINT"))
            lamp.location, lamp.data.energy = (3, -3, 4), power
            bpy.context.scene.collection.objects.link(lamp)
            lamps[name] = lamp
        lamps["locked"].lock_location = (True, True, True)
        bpy.context.view_layer.update()
        result = klieg.blender.light(bpy.context, **QUICK)
        kept = [held for held in result.lights if held.role == "scene"]
        self.assertEqual(len(kept), 1)
        self.assertTrue(np.allclose(kept[0].position, (3, -3, 4), atol=1e-3))
        self.assertAlmostEqual(klieg.blender.power("point", kept[0].intensity), 400, delta=0.1)
        self.assertEqual([lamps[name].hide_render for name in ("locked", "free")], [False, True])
        again = klieg.blender.light(bpy.context, keep_lights=True, **QUICK)
        self.assertEqual(len([held for held in again.lights if held.role == "scene"]), 1)

    def test_spots_and_suns(self) -> None:
        for kind, name in (("spot", "SPOT"), ("directional", "SUN")):
            result = klieg.blender.light(bpy.context, kind=kind, lights=1, **QUICK)
            lamp = ours()[0]
            self.assertEqual(lamp.data.type, name)
            axis = -np.array(lamp.matrix_world)[:3, 2]
            self.assertTrue(np.allclose(axis, result.lights[0].axis, atol=1e-4))

    def test_a_scene_without_camera_or_surfaces_is_refused(self) -> None:
        camera, bpy.context.scene.camera = bpy.context.scene.camera, None
        with self.assertRaisesRegex(klieg.InputError, "no active camera"):
            klieg.blender.light(bpy.context, **QUICK)
        bpy.ops.wm.read_factory_settings(use_empty=True)
        with self.assertRaisesRegex(klieg.InputError, "no surfaces"):
            klieg.blender.light(bpy.context, **QUICK)
        del camera

    def test_the_operator_and_its_undo(self) -> None:
        klieg_addon.register()
        try:
            settings = bpy.context.scene.klieg
            settings.generations, settings.roles = 3, "key,fill,rim"
            bpy.context.preferences.edit.use_global_undo = True
            bpy.ops.ed.undo_push(message="before")
            self.assertEqual(bpy.ops.klieg.light_view(), {"FINISHED"})
            self.assertEqual(len(ours()), 3)
            bpy.ops.ed.undo_push(message="lit")
            bpy.ops.ed.undo()
            self.assertEqual(len(ours()), 0)
        finally:
            klieg_addon.unregister()


if __name__ == "__main__":
    unittest.main()
