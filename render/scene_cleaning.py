"""Opening a Blender file of any origin without running anything that is in it.

The scene is appended to an empty file, not opened: Blender evaluates what it opens at
once, with all that reads other files, but what is appended only when it is shown. Until
then everything that could run is taken out: texts, animation with its drivers, script
nodes; and everything that would read other files. Images are packed if they lie in the
scene's own folder and left out otherwise. What is left out is said.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from render.scene_files import is_inside
from scenes.errors import SceneError

__all__ = ["all_data", "first_line", "open_blend", "remove_scripts", "settle_images"]

READING_MODIFIERS = {"MESH_CACHE", "MESH_SEQUENCE_CACHE", "FLUID", "OCEAN", "DYNAMIC_PAINT"}
"""Modifiers that read files of their own."""
GREY = 0.5


def open_blend(bpy: Any, path: Path) -> tuple[Any, list[str]]:
    """Append the scene of a Blender file, which is neither shown nor evaluated yet.

    Parameters
    ----------
    bpy : module
    path : Path
        Absolute; passed by `render.scene_files.inspect_scene`.

    Returns
    -------
    scene : bpy.types.Scene
        Of several, the one with the most objects.
    notes : list of str
        A line for each other one, and for each text.

    Raises
    ------
    SceneError
        If Blender cannot read it, or it takes data from other files.
    """
    try:
        with bpy.data.libraries.load(str(path), link=False) as (there, here):
            here.scenes = there.scenes
            texts = list(there.texts)
    except (OSError, RuntimeError) as error:
        raise SceneError(f"{path}: Blender cannot read it: {first_line(error)}") from None
    for library in list(bpy.data.libraries):
        if library.filepath != str(path):
            raise SceneError(
                f"{path}: links data of {library.filepath!r}; expected all in one file"
            )
        bpy.data.libraries.remove(library)
    scenes = [scene for scene in here.scenes if scene is not None]
    if not scenes:
        raise SceneError(f"{path}: no scene in it; expected one")
    chosen = max(scenes, key=lambda scene: len(scene.objects))
    notes = [f"text {name!r}: scripts are never run; left out" for name in texts]
    others = [scene.name for scene in scenes if scene != chosen]
    return chosen, notes + [f"scene {name!r}: not the largest one; left out" for name in others]


def first_line(error: Exception) -> str:
    """What Blender says of an error, in one line, without the paths of its own modules."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    said = [line for line in lines if not line.startswith(("Location:", "File ", "Traceback"))]
    return (said or ["no reason given"])[0].removeprefix("Error: ")


def all_data(bpy: Any) -> Iterator[tuple[str, Any]]:
    """Every data-block of the file, and the node trees inside of them, with what to call it."""
    for prop in bpy.data.bl_rna.properties:
        if prop.type == "COLLECTION":
            for block in getattr(bpy.data, prop.identifier):
                label = f"{block.id_type.lower()} {block.name!r}"
                yield label, block
                tree = getattr(block, "node_tree", None)
                if tree is not None:
                    yield label, tree


def remove_scripts(bpy: Any) -> list[str]:
    """Take out what could run or read files; returns what that was, one line each."""
    notes: list[str] = []
    bpy.data.batch_remove(list(bpy.data.texts))
    for label, block in list(all_data(bpy)):
        notes.extend(_stop(label, block))
        if hasattr(block, "nodes"):
            notes.extend(_remove_nodes(label, block))
    for item in bpy.data.objects:
        notes.extend(_remove_modifiers(item))
    for scene in [scene for scene in bpy.data.scenes if scene.rigidbody_world is not None]:
        scene.rigidbody_world.point_cache.use_external = False
    data = bpy.data
    for group in (data.cache_files, data.sounds, data.movieclips, data.volumes):
        notes.extend(f"{block.id_type.lower()} {block.name!r}: left out" for block in group)
        bpy.data.batch_remove(list(group))
    fonts = [font for font in bpy.data.fonts if font.filepath != "<builtin>"]
    for font in [font for font in fonts if font.packed_file is None]:
        notes.append(f"font {font.name!r}: not in the file; left out")
        bpy.data.fonts.remove(font)
    return notes


def _stop(label: str, block: Any) -> Iterator[str]:
    """Clear animation and drivers; the values of the file stay."""
    data = getattr(block, "animation_data", None)
    if data is None:
        return
    if len(data.drivers):
        yield f"{label}: its drivers are not run; left out"
    elif data.action is not None or len(data.nla_tracks):
        yield f"{label}: animated; taken as it was saved"
    block.animation_data_clear()


def _remove_nodes(label: str, tree: Any) -> Iterator[str]:
    """Remove nodes that run code or read files, but for images."""
    for node in list(tree.nodes):
        reads = node.bl_idname in ("ShaderNodeScript", "ShaderNodeTexIES")
        if reads or node.bl_idname.startswith("GeometryNodeImport"):
            yield f"{label}: node {node.name!r} runs code or reads a file; left out"
            tree.nodes.remove(node)


def _remove_modifiers(item: Any) -> Iterator[str]:
    for modifier in list(item.modifiers):
        if modifier.type in READING_MODIFIERS or getattr(modifier, "is_external", False):
            yield f"object {item.name!r}: modifier {modifier.name!r} reads a file; left out"
            item.modifiers.remove(modifier)
        elif modifier.type == "NODES":
            modifier.bake_directory = ""
            for bake in modifier.bakes:
                bake.directory = ""
    for owner in (*item.modifiers, *item.particle_systems):
        if hasattr(owner, "point_cache"):
            owner.point_cache.use_external = False


def settle_images(bpy: Any, folder: Path | None) -> list[str]:
    """Pack every image that is in ``folder``, and make the others plain grey.

    Parameters
    ----------
    bpy : module
    folder : Path or None
        None: nothing is read.

    Returns
    -------
    list of str
        A line for each image that was left out.
    """
    notes = []
    for image in [block for block in bpy.data.images if block.users]:
        if image.packed_file or len(image.packed_files) or image.source in ("GENERATED", "VIEWER"):
            continue
        problem = _pack(bpy, image, folder)
        if problem:
            notes.append(f"image {image.name!r}: {problem}; plain grey instead")
            image.user_remap(_grey_image(bpy))
    return notes


def _pack(bpy: Any, image: Any, folder: Path | None) -> str | None:
    """Pack one image; why that is not possible otherwise."""
    path = bpy.path.abspath(image.filepath)
    if image.source not in ("FILE", "TILED"):
        return f"a {image.source.lower()} cannot be packed"
    files = [Path(path.replace("<UDIM>", str(tile.number))) for tile in image.tiles]
    if folder is None or not all(is_inside(folder, file) for file in files):
        return f"{image.filepath!r} is outside of the scene's folder"
    if not all(file.is_file() for file in files):
        return f"{image.filepath!r} is missing"
    try:
        image.pack()
    except RuntimeError as error:
        return first_line(error)
    return None


def _grey_image(bpy: Any) -> Any:
    image = bpy.data.images.get("left out")
    if image is None:
        image = bpy.data.images.new("left out", 1, 1)
        image.generated_color = (GREY, GREY, GREY, 1.0)
    return image
