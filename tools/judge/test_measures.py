"""The measures on pictures whose values are known."""

import unittest

import numpy as np

import measures


def ball(size=96):
    """A white ball that fills most of the picture."""
    y, x = np.mgrid[size - 1 : -1 : -1, 0:size] / (size - 1) * 2.2 - 1.1
    inside = 1 - x**2 - y**2
    mask = inside > 0.02
    z = np.sqrt(np.maximum(inside, 0))
    normal = np.where(mask[..., None], np.stack([x, y, z], axis=-1), 0)
    normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-9)
    return measures.Surface(mask, normal, np.ones((size, size, 3)), 2 - z)


def lit(surface, direction):
    """A matt surface under a directional light."""
    direction = np.array(direction) / np.linalg.norm(direction)
    shading = np.maximum(surface.normal @ direction, 0)
    return (shading[..., None] * surface.albedo) * surface.mask[..., None]


class Measures(unittest.TestCase):
    def test_the_transfer_function_has_an_inverse(self):
        values = np.linspace(0, 1, 101)
        np.testing.assert_allclose(measures.decode(measures.encode(values)), values, atol=1e-9)

    def test_sobel_takes_the_centre_outside_the_mask(self):
        ramp = np.tile(np.arange(5.0) / 4, (5, 1))[..., None]
        across, down = measures.sobel(ramp, np.ones((5, 5), bool))
        inner = (slice(1, 4), slice(1, 4))
        np.testing.assert_allclose(across[inner], 0.25, atol=1e-12)
        np.testing.assert_allclose(down[inner], 0, atol=1e-12)
        np.testing.assert_allclose(across[2, 0], 0.125, atol=1e-12)
        alone = np.zeros((5, 5), bool)
        alone[2, 2] = True
        self.assertEqual(measures.length(measures.sobel(ramp, alone))[2, 2], 0)

    def test_light_from_the_side_tells_the_tilt_and_a_headlight_does_not(self):
        surface = ball()
        side = measures.measure(lit(surface, [1, 1, 1.5]), surface)
        head = measures.measure(lit(surface, [0, 0, 1]), surface)
        self.assertGreater(side["tilt"], 0.6)
        self.assertLess(head["tilt"], 0.01)
        self.assertGreater(side["detail"], 0.6)

    def test_a_texture_does_not_hide_the_tilt(self):
        surface = ball()
        plain = measures.measure(lit(surface, [1, 1, 1.5]), surface)
        surface.albedo[::2] *= 0.3
        painted = measures.measure(lit(surface, [1, 1, 1.5]), surface)
        self.assertAlmostEqual(plain["tilt"], painted["tilt"], delta=0.01)

    def test_black_and_white_places_are_counted(self):
        surface = ball()
        picture = np.full_like(surface.albedo, 0.2)
        found = measures.measure(picture, surface)
        self.assertEqual([found[key] for key in ("crushed", "burnt", "unlit")], [0, 0, 0])
        rows = np.flatnonzero(surface.mask.any(axis=1))
        top = rows[: len(rows) // 2]
        share = surface.mask[top].sum() / surface.mask.sum()
        picture[top] = [1.5, 0.2, 0.2]
        self.assertAlmostEqual(measures.measure(picture, surface)["burnt"], share)
        picture[top] = 0.002
        found = measures.measure(picture, surface)
        self.assertAlmostEqual(found["crushed"], share)
        self.assertAlmostEqual(found["unlit"], share)

    def test_a_flat_picture_shows_nothing(self):
        surface = ball()
        found = measures.measure(np.full_like(surface.albedo, 0.2), surface)
        self.assertLess(found["detail"] + found["tilt"], 1e-6)

    def test_outlines_are_where_the_depth_jumps(self):
        surface = ball()
        far = measures.Surface(surface.mask, surface.normal, surface.albedo, np.full_like(surface.depth, 2.0))
        outline = measures.edges(far)
        self.assertTrue(outline.any() and not (outline & ~far.mask).any())
        self.assertFalse(outline[48, 48])
        far.depth[:, 48:] += 0.3
        self.assertTrue(measures.edges(far)[48, 47:49].all())


if __name__ == "__main__":
    unittest.main()
