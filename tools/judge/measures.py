"""What can be said of a rendered picture: how much of the shape it shows, and how much is lost.

Pictures are height x width x 3, linear sRGB; masks are height x width, boolean. Normals are unit vectors in
the camera's axes: right, up, towards the viewer.
"""

from dataclasses import dataclass

import numpy as np

# Thresholds of klieg's documentation (docs/METHOD.md), of encoded values in 0..1.
BURNT = 0.985
EDGE_CONTRAST = 0.06
EDGE_DEPTH = 0.02
# Encoded luminance below which a pixel counts as black.
CRUSHED = 0.04
# Share of its own colour below which a pixel counts as not lit.
UNLIT = 0.05
# Least albedo that a picture is divided by.
LEAST_ALBEDO = 0.02
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


@dataclass
class Surface:
    """What a camera sees of a scene, whatever the lights."""

    mask: np.ndarray
    """The object's pixels."""
    normal: np.ndarray
    albedo: np.ndarray
    """Linear sRGB."""
    depth: np.ndarray
    """Along the view axis, in radii of the scene."""


def encode(linear):
    """The sRGB transfer function, of values clipped to 0..1."""
    linear = np.clip(linear, 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def decode(encoded):
    """The inverse of `encode`."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def sobel(values, mask):
    """Both derivatives of values (height x width x channels), per pixel; a tap outside the mask or the picture
    takes the centre's value."""
    padded = np.pad(values, ((1, 1), (1, 1), (0, 0)))
    inside = np.pad(mask, 1)
    height, width = mask.shape
    across, down = np.zeros_like(values), np.zeros_like(values)
    for y in (-1, 0, 1):
        for x in (-1, 0, 1):
            window = (slice(1 + y, 1 + y + height), slice(1 + x, 1 + x + width))
            tap = np.where(inside[window][..., None], padded[window], values)
            across += x * (2 - abs(y)) / 8 * tap
            down += y * (2 - abs(x)) / 8 * tap
    return across, down


def length(derivatives):
    """Frobenius length of a Sobel pair."""
    return np.sqrt(sum((part**2).sum(axis=-1) for part in derivatives))


def edges(surface):
    """Pixels of the object's outlines, inner ones included, as klieg's EDGE."""
    depth = np.where(surface.mask, surface.depth, surface.depth[surface.mask].max() + 1)
    everywhere = np.ones_like(surface.mask)
    slope = length(sobel(depth[..., None], everywhere))
    padded = np.pad(depth, 1, mode="edge")
    height, width = depth.shape
    box = sum(padded[y : y + height, x : x + width] for y in range(3) for x in range(3))
    laplace = np.abs(box - 9 * depth) / 8
    return surface.mask & (slope > EDGE_DEPTH) & (laplace > EDGE_DEPTH)


def visible_detail(gradient, normal_gradient, where):
    """Share of the shape's detail that the picture shows: `1 - F_detail`; 1 where there is none."""
    weight = np.minimum(normal_gradient, 0.5)[where]
    seen = np.minimum(1, gradient[where] / np.maximum(0.35 * normal_gradient[where], 0.004))
    return float((weight * seen).sum() / weight.sum()) if weight.sum() > 0 else 1.0


def told_tilt(shading, normal):
    """R2 of the best linear guess of the shading from the normals' x and y (samples x 1, samples x 3): how much
    of it tells left from right and up from down."""
    tilt = normal[:, :2] - normal[:, :2].mean(axis=0)
    shading = shading - shading.mean()
    covariance = tilt.T @ tilt / len(shading)
    if np.trace(covariance) < 1e-4:
        return 0.0
    shared = tilt.T @ shading / len(shading)
    explained = shared @ np.linalg.pinv(covariance, rcond=1e-4) @ shared
    return float(np.clip(explained / max(shading.var(), 1e-5), 0.0, 1.0))


def measure(picture, surface):
    """All measures of a picture, by name."""
    mask = surface.mask
    luminance = np.clip(picture, 0.0, 1.0) @ LUMINANCE
    albedo = surface.albedo @ LUMINANCE
    brightness = encode(luminance)
    shading = encode(luminance / np.maximum(albedo, LEAST_ALBEDO))
    outline = edges(surface)
    gradient = length(sobel(brightness[..., None], mask))
    normal_gradient = length(sobel(surface.normal, mask))

    def share(where):
        return float(where[mask].mean())

    found = {
        "crushed": share(brightness < CRUSHED),
        "burnt": share((encode(picture) >= BURNT).any(axis=-1)),
        "unlit": share(luminance < UNLIT * albedo),
        "mean": float(brightness[mask].mean()),
        "spread": float(brightness[mask].std()),
        "detail": visible_detail(gradient, normal_gradient, mask & ~outline),
        "outline": float(np.minimum(1, gradient[outline] / EDGE_CONTRAST).mean()) if outline.any() else 1.0,
        "tilt": told_tilt(shading[mask], surface.normal[mask]),
    }
    found["legibility"] = legibility(found)
    return found


def legibility(found):
    """How well a picture shows a shape; no term of klieg's objective. Higher is better, at most 2.5."""
    return found["detail"] + 0.5 * found["outline"] + found["tilt"] - found["burnt"] - found["crushed"]


def difference(picture, other, mask):
    """Mean difference of two pictures' encoded channels over the mask."""
    return float(np.abs(encode(picture) - encode(other))[mask].mean())
