"""Quietening a bake: OpenImageDenoise over the atlas, and texels that nobody lit.

Blender gives no access to OpenImageDenoise but through a render. The atlas is
therefore rendered: a plate that glows with it fills the view of a camera without
perspective, one pixel per texel. What guides the denoiser is each chart's normal and a
colour of its own, so that light does not run from one chart into its neighbour.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from render.blender import add_layer, empty_scene, float_image
from render.charts import Atlas
from render.cycles import Frames, configure
from render.nodes import add_node
from render.presets import Preset

__all__ = ["continued", "denoise"]

SCATTER = 4
"""How far from the nearest texel another one is taken for it."""
TRIES = 8
DARKEST = 1e-6
"""Charts are not brightened from below that, W/m²/sr."""
Picture = NDArray[np.float32]


def continued(
    picture: Picture,
    covered: NDArray[np.bool_],
    boxes: NDArray[np.int32],
    generator: np.random.Generator | None = None,
) -> Picture:
    """The picture with every chart's uncovered texels set to the nearest covered one.

    Parameters
    ----------
    picture : array, shape (rows, columns, 3)
    covered : array, shape (rows, columns)
    boxes : array, shape (c, 4)
        First row, first column, rows, columns of every chart; a chart without a
        covered texel becomes black.
    generator : numpy.random.Generator, optional
        Take any texel near the nearest one: noise goes on as noise. Streaks would
        look like something that is there, and the denoiser would keep them.
    """
    made = np.zeros_like(picture)
    for row, column, rows, columns in boxes.tolist():
        window = np.s_[row : row + rows, column : column + columns]
        inside = covered[window]
        if inside.all():
            made[window] = picture[window]
        elif inside.any():
            near = ndimage.distance_transform_edt(
                ~inside, return_distances=False, return_indices=True
            )
            if generator is not None:
                near = _scattered(near, inside, generator)
            made[window] = picture[window][tuple(near)]
    return made


def _scattered(
    near: NDArray[np.int32], inside: NDArray[np.bool_], generator: np.random.Generator
) -> NDArray[np.int32]:
    """Texels (2, rows, columns) about those in ``near``, where they are inside, too."""
    found = near.copy()
    limit = np.array(inside.shape)[:, None, None] - 1
    for _ in range(TRIES):
        steps = generator.integers(-SCATTER, SCATTER + 1, near.shape)
        other = np.clip(near + steps, 0, limit)
        better = ~inside & inside[tuple(other)]
        found[:, better] = other[:, better]
    return found


def denoise(bpy: Any, picture: Picture, atlas: Atlas, threads: int | None = None) -> Picture:
    """The picture (rows, columns, 3), denoised; the Blender scene is lost.

    Every chart is brought to the same mean brightness for it: a window's reveal would
    otherwise shine into the charts beside it, which are a thousandth as bright.
    """
    scene = empty_scene(bpy)
    level = _levels(picture, atlas)
    _add_plate(bpy, scene, picture / level, *_guides(atlas))
    _add_camera(bpy, scene, atlas.shape)
    configure(scene, Preset("plate", samples=1, max_bounces=0), threads)
    scene.cycles.denoising_prefilter = "FAST"
    pixels = Frames(bpy, scene).render()
    return np.ascontiguousarray(pixels[::-1, :, :3]) * level


def _levels(picture: Picture, atlas: Atlas) -> Picture:
    """Mean of the chart of every texel, (rows, columns, 1); never 0."""
    level = np.full((*atlas.shape, 1), max(float(picture.mean()), DARKEST), dtype=np.float32)
    for row, column, rows, columns in atlas.boxes.tolist():
        window = np.s_[row : row + rows, column : column + columns]
        level[window] = max(float(picture[window].mean()), DARKEST)
    return level


def _guides(atlas: Atlas) -> tuple[Picture, Picture]:
    """A colour for every chart, all over its box, and its normal (rows, columns, 3)."""
    colours = np.random.default_rng(0).uniform(0.1, 1.0, (len(atlas.boxes), 3))
    colour = np.zeros((*atlas.shape, 3), dtype=np.float32)
    normal = np.zeros_like(colour)
    for chart, (row, column, rows, columns) in enumerate(atlas.boxes.tolist()):
        window = np.s_[row : row + rows, column : column + columns]
        colour[window], normal[window] = colours[chart], atlas.normals[chart]
    return colour, normal


def _add_plate(bpy: Any, scene: Any, picture: Picture, colour: Picture, normal: Picture) -> None:
    """The unit square in z = 0 that glows with ``picture``; no light falls on its colour."""
    mesh = bpy.data.meshes.new("plate")
    corners = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)]
    mesh.from_pydata(corners, [], [(0, 1, 2, 3)])
    add_layer(mesh, "plate", np.array([c[:2] for c in corners]))
    material = bpy.data.materials.new("plate")
    if material.node_tree is None:
        material.use_nodes = True
    material.cycles.emission_sampling = "NONE"
    tree = material.node_tree
    tree.nodes.clear()
    shown = [_texel(bpy, tree, *item) for item in (("light", picture), ("chart", colour))]
    bent = add_node(tree, "ShaderNodeBsdfDiffuse", Color=shown[1])
    tree.links.new(_texel(bpy, tree, "normal", normal), bent.inputs["Normal"])
    glow = add_node(tree, "ShaderNodeEmission", Color=shown[0])
    both = tree.nodes.new("ShaderNodeAddShader")
    tree.links.new(glow.outputs[0], both.inputs[0])
    tree.links.new(bent.outputs[0], both.inputs[1])
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(both.outputs[0], output.inputs["Surface"])
    mesh.materials.append(material)
    scene.collection.objects.link(bpy.data.objects.new("plate", mesh))


def _texel(bpy: Any, tree: Any, name: str, values: Picture) -> Any:
    """Socket of the texel under each pixel."""
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = float_image(bpy, name, values)
    node.interpolation = "Closest"
    return node.outputs["Color"]


def _add_camera(bpy: Any, scene: Any, shape: tuple[int, int]) -> None:
    """A camera without perspective that sees the unit square as ``shape`` pixels."""
    rows, columns = shape
    data = bpy.data.cameras.new("camera")
    data.type = "ORTHO"
    data.ortho_scale = 1.0
    made = bpy.data.objects.new("camera", data)
    made.location = (0.5, 0.5, 1.0)
    scene.collection.objects.link(made)
    scene.camera = made
    scene.render.resolution_x, scene.render.resolution_y = columns, rows
    scene.render.resolution_percentage = 100
    # Pixels are square: the plate, not the camera, takes the picture's proportions.
    longer = max(rows, columns)
    plate = scene.objects["plate"]
    plate.scale = (columns / longer, rows / longer, 1.0)
    made.location = (0.5 * columns / longer, 0.5 * rows / longer, 1.0)
