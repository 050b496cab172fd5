"""Materials of Blender as klieg has them: what feeds their Principled BSDF."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

WHITE = (1.0, 1.0, 1.0)

MOST_TEXELS = 1024
"""Most texels of a side of a texture: pictures that lights are searched for have fewer pixels."""


class Materials:
    """The materials of one scene, whose images are read once."""

    def __init__(self) -> None:
        """Begin without any."""
        self._textures: dict[str, NDArray[np.uint8]] = {}

    def fields(self, material: Any, mesh: Any, loops: NDArray[np.int32]) -> dict[str, Any]:
        """Return the fields of `klieg.Mesh` that tell how the corners `loops` of Blender's mesh look.

        Base colour (a colour, an image texture with its UV map and mapping, or a colour attribute), metallic, roughness
        and emission of the Principled BSDF count; what else feeds them is taken for the value that it replaces.
        """
        if material is None:
            return {"base_color": (0.8, 0.8, 0.8), "roughness": 0.5}
        nodes = material.node_tree.nodes if material.use_nodes and material.node_tree else []
        shader = next((node for node in nodes if node.type == "BSDF_PRINCIPLED"), None)
        if shader is None:
            return {"base_color": tuple(material.diffuse_color)[:3], "roughness": material.roughness}
        value = {name: shader.inputs[name].default_value for name in ("Base Color", "Metallic", "Roughness")}
        strength = shader.inputs["Emission Strength"].default_value
        emission = shader.inputs["Emission Color"].default_value
        return {
            "base_color": tuple(value["Base Color"])[:3],
            "metallic": value["Metallic"],
            "roughness": value["Roughness"],
            "emissive": tuple(strength * channel for channel in tuple(emission)[:3]),
            **self._base(_feeding(shader.inputs["Base Color"]), mesh, loops),
        }

    def _base(self, node: Any, mesh: Any, loops: NDArray[np.int32]) -> dict[str, Any]:
        """Return the fields that a node feeding the base colour gives; none where klieg has nothing like it."""
        if node is None:
            return {}
        if node.type in {"VERTEX_COLOR", "ATTRIBUTE"}:
            colors = _colors(mesh, node.layer_name if node.type == "VERTEX_COLOR" else node.attribute_name, loops)
            return {} if colors is None else {"base_color": WHITE, "colors": colors}
        if node.type != "TEX_IMAGE" or node.image is None or node.image.size[0] == 0:
            return {}
        uvs = _coordinates(_feeding(node.inputs["Vector"]), mesh, loops)
        if uvs is None:
            return {}
        return {"base_color": WHITE, "uvs": uvs, "texture": self._texture(node.image)}

    def _texture(self, image: Any) -> NDArray[np.uint8]:
        """Return an image as sRGB, rows from the top."""
        known = self._textures.get(image.name_full)
        if known is None:
            width, height = image.size
            texels = np.empty(width * height * image.channels, dtype=np.float32)
            image.pixels.foreach_get(texels)
            texels = texels.reshape(height, width, image.channels)[::-1]
            step = -(-max(width, height) // MOST_TEXELS)
            color = texels[::step, ::step, :3] if image.channels >= 3 else np.repeat(texels[::step, ::step, :1], 3, -1)
            # Images of bytes are as they are stored, others linear.
            stored = not image.is_float and image.colorspace_settings.name == "sRGB"
            known = _bytes(color if stored else srgb(color))
            self._textures[image.name_full] = known
        return known


def srgb(linear: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the sRGB encoding of linear values (IEC 61966-2-1)."""
    clipped = np.clip(linear, 0, 1)
    encoded: NDArray[np.float32] = np.where(
        clipped <= 0.0031308, 12.92 * clipped, 1.055 * np.maximum(clipped, 1e-9) ** (1 / 2.4) - 0.055
    )
    return encoded


def _bytes(values: NDArray[np.float32]) -> NDArray[np.uint8]:
    return np.ascontiguousarray(np.clip(values * 255 + 0.5, 0, 255).astype(np.uint8))


def _feeding(socket: Any) -> Any:
    """Return the node that feeds a socket, past reroutes; none where nothing does."""
    while socket.is_linked:
        node = socket.links[0].from_node
        if node.type != "REROUTE":
            return node
        socket = node.inputs[0]
    return None


def _coordinates(node: Any, mesh: Any, loops: NDArray[np.int32]) -> NDArray[np.float32] | None:
    """Return texture coordinates of corners, downwards, by the node that gives them; none where no UV map does."""
    mapping = None
    if node is not None and node.type == "MAPPING":
        mapping, node = node, _feeding(node.inputs["Vector"])
    layers = mesh.uv_layers
    layer = next((layer for layer in layers if layer.active_render), None)
    if node is not None and node.type == "UVMAP" and node.uv_map:
        layer = layers.get(node.uv_map)
    elif node is not None and node.type not in {"TEX_COORD", "UVMAP"}:
        layer = None
    if layer is None:
        return None
    uvs = np.empty(2 * len(mesh.loops), dtype=np.float32)
    layer.uv.foreach_get("vector", uvs)
    placed = uvs.reshape(-1, 2)[loops]
    if mapping is not None:
        scale, turn, move = (np.array(mapping.inputs[name].default_value) for name in ("Scale", "Rotation", "Location"))
        cos, sin = np.cos(turn[2]), np.sin(turn[2])
        placed = (placed * scale[:2]) @ np.array([[cos, sin], [-sin, cos]]) + move[:2]
    placed[:, 1] = 1 - placed[:, 1]
    return placed.astype(np.float32)


def _colors(mesh: Any, name: str, loops: NDArray[np.int32]) -> NDArray[np.float32] | None:
    """Return a colour attribute at corners, sRGB; none where the mesh has no such one."""
    attributes = mesh.color_attributes
    attribute = attributes.get(name) if name else attributes.active_color
    if attribute is None:
        return None
    values = np.empty(4 * len(attribute.data), dtype=np.float32)
    attribute.data.foreach_get("color", values)
    colors = srgb(values.reshape(-1, 4)[:, :3])
    if attribute.domain == "POINT":
        vertices = np.empty(len(mesh.loops), dtype=np.int32)
        mesh.loops.foreach_get("vertex_index", vertices)
        return colors[vertices[loops]]
    return colors[loops]
