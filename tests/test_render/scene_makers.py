"""Scenes that our exporter did not make, by Blender in a process of its own (`run`).

Written to FOLDER/scenes; with ``list FILE``, FOLDER/contents.json says what is in a
Blender file; with ``trust FILE``, that file is opened with its scripts allowed to run.
"""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from render.libraries import load_bpy

FLOOR = 0.3
"""Height of the house's floor, m."""
SIZE = (8.0, 5.0)
WALL_X, DOOR = 5.0, (2.0, 3.0)
"""Where the inner wall is, and its gap along y, m."""
WALL_THICKNESS = 0.1
WARDROBE = ((1.2, 3.6), (1.0, 0.6), 30.0)
"""Middle, size (m) and turn (degrees)."""
COLUMN = ((3.0, 1.0), 0.25)
CHAIRS = ((6.5, 1.0, 10.0), (6.5, 3.5, 70.0), (3.4, 3.2, -35.0))
"""Where the chairs stand: x m, y m, degrees."""
LEGS = tuple((x, y) for x in (-0.2, 0.2) for y in (-0.2, 0.2))
LEG = 0.04


def add(bpy: Any, name: str, vertices: Any, faces: Any, home: Any = None) -> Any:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    made = bpy.data.objects.new(name, mesh)
    (home or bpy.context.scene.collection).objects.link(made)
    return made


def box(bpy: Any, name: str, low: Any, high: Any, home: Any = None) -> Any:
    corners = [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1])
               for z in (low[2], high[2])]  # fmt: skip
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return add(bpy, name, corners, faces, home)


def paint(bpy: Any, item: Any, colour: tuple[float, float, float]) -> Any:
    material = bpy.data.materials.new(f"paint of {item.name}")
    if material.node_tree is None:
        material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs[0].default_value = (*colour, 1.0)
    item.data.materials.append(material)
    return material


def build_house(bpy: Any) -> None:
    """Two rooms under a pitched roof; walls are single planes, chairs are instances."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    width, depth = SIZE
    top = FLOOR + 2.2
    ring = [(0, 0), (width, 0), (width, depth), (0, depth)]
    floor = add(bpy, "floor", [(x, y, FLOOR) for x, y in ring], [(0, 1, 2, 3)])
    paint(bpy, floor, (0.4, 0.25, 0.12))
    for k, (corner, b) in enumerate(zip(ring, ring[1:] + ring[:1], strict=True)):
        # A crack of 1 mm at every corner: nothing here is watertight.
        a = (corner[0] + 1e-3 * (b[0] > corner[0]) - 1e-3 * (b[0] < corner[0]), corner[1])
        if k == 2:
            # The sun and the sky come in through a hole above 1.8 m.
            corners = [(*a, FLOOR), (*b, FLOOR), (*b, FLOOR + 1.2), (*a, FLOOR + 1.2)]
        else:
            corners = [(*a, FLOOR), (*b, FLOOR), (*b, top), (*a, top)]
        paint(bpy, add(bpy, f"wall {k}", corners, [(0, 1, 2, 3)]), (0.7, 0.7, 0.6))
    ridge = top + 1.0
    for y in (0.0, depth):
        roof = [(0, y, top), (width, y, top), (width, depth / 2, ridge), (0, depth / 2, ridge)]
        paint(bpy, add(bpy, f"roof {y:g}", roof, [(0, 1, 2, 3)]), (0.6, 0.5, 0.4))
    for x in (0.0, width):
        add(bpy, f"gable {x:g}", [(x, 0, top), (x, depth, top), (x, depth / 2, ridge)], [(0, 1, 2)])
    for k, (a, b) in enumerate(((0.0, DOOR[0]), (DOOR[1], depth))):
        corners = [(WALL_X, a, FLOOR), (WALL_X, b, FLOOR), (WALL_X, b, top), (WALL_X, a, top)]
        inner = add(bpy, f"inner wall {k}", corners, [(0, 1, 2, 3)])
        solid = inner.modifiers.new("thick", "SOLIDIFY")
        solid.thickness, solid.offset = WALL_THICKNESS, 0.0
        paint(bpy, inner, (0.3, 0.5, 0.6))
    (x, y), (w, d), turn = WARDROBE
    wardrobe = box(bpy, "wardrobe", (-w / 2, -d / 2, 0), (w / 2, d / 2, 2.0))
    wardrobe.location, wardrobe.rotation_euler = (x, y, FLOOR), (0, 0, math.radians(turn))
    paint(bpy, wardrobe, (0.2, 0.1, 0.05))
    (x, y), radius = COLUMN
    bpy.ops.mesh.primitive_cylinder_add(
        radius=radius, depth=3.0, location=(x, y, FLOOR + 1.5), vertices=48
    )
    bpy.context.object.name = "column"
    add_chairs(bpy)
    add_lights(bpy)


def add_chairs(bpy: Any) -> None:
    chair = bpy.data.collections.new("chair")
    box(bpy, "seat", (-0.22, -0.22, 0.42), (0.22, 0.22, 0.46), chair)
    box(bpy, "back", (-0.22, 0.2, 0.46), (0.22, 0.22, 0.9), chair)
    for k, (x, y) in enumerate(LEGS):
        h = LEG / 2
        box(bpy, f"leg {k}", (x - h, y - h, 0), (x + h, y + h, 0.42), chair)
    for k, (x, y, turn) in enumerate(CHAIRS):
        place = bpy.data.objects.new(f"chair {k}", None)
        place.instance_type, place.instance_collection = "COLLECTION", chair
        place.location, place.rotation_euler = (x, y, FLOOR), (0, 0, math.radians(turn))
        bpy.context.scene.collection.objects.link(place)


def add_lights(bpy: Any) -> None:
    for k, x in enumerate((2.5, 6.5)):
        light = bpy.data.objects.new(f"bulb {k}", bpy.data.lights.new("bulb", "POINT"))
        light.data.energy, light.location = 60.0, (x, 2.5, FLOOR + 2.1)
        bpy.context.scene.collection.objects.link(light)


def build_workshop(bpy: Any) -> None:
    """What is no mesh of its own: copies by nodes, mirrored and sheared boxes, a curve."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene.collection
    add(bpy, "floor", [(0, 0, 0), (8, 0, 0), (8, 6, 0), (0, 6, 0)], [(0, 1, 2, 3)])
    cube = box(bpy, "cube", (-0.1, -0.1, 0), (0.1, 0.1, 0.5))
    cube.hide_render = cube.hide_viewport = True
    points = add(bpy, "points", [(1, 1, 0), (2, 1, 0), (3, 1, 0)], [(0, 1, 2)])
    group = bpy.data.node_groups.new("copies", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    start, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    copies = group.nodes.new("GeometryNodeInstanceOnPoints")
    source = group.nodes.new("GeometryNodeObjectInfo")
    source.inputs["Object"].default_value = cube
    group.links.new(start.outputs[0], copies.inputs["Points"])
    group.links.new(source.outputs["Geometry"], copies.inputs["Instance"])
    group.links.new(copies.outputs[0], end.inputs[0])
    points.modifiers.new("copies", "NODES").node_group = group
    stretch = bpy.data.objects.new("stretch", None)
    stretch.scale, stretch.location = (2, 1, 1), (5, 4, 0)
    scene.objects.link(stretch)
    sheared = box(bpy, "sheared", (-0.2, -0.2, 0), (0.2, 0.2, 1))
    sheared.parent, sheared.rotation_euler = stretch, (0, 0, math.radians(45))
    mirrored = box(bpy, "mirrored", (0, 0, 0), (0.5, 0.3, 1))
    mirrored.scale, mirrored.location = (-1, 1, 1), (7.5, 1, 0)
    cable = bpy.data.curves.new("cable", "CURVE")
    cable.dimensions, cable.bevel_depth = "3D", 0.02
    line = cable.splines.new("POLY")
    line.points.add(1)
    line.points[0].co, line.points[1].co = (2, 3, 0.03, 1), (3, 3, 0.03, 1)
    scene.objects.link(bpy.data.objects.new("cable", cable))


def add_oddities(bpy: Any, folder: Path) -> None:
    """What an importer cannot use: hidden, without a surface, missing, outside."""
    hidden = box(bpy, "hidden", (6, 2, FLOOR), (7, 3, FLOOR + 1))
    hidden.hide_render = True
    scene = bpy.context.scene.collection
    line = bpy.data.curves.new("line", "CURVE")
    line.splines.new("POLY").points.add(1)
    scene.objects.link(bpy.data.objects.new("line", line))
    scene.objects.link(bpy.data.objects.new("nothing", None))
    scene.objects.link(bpy.data.objects.new("smoke", bpy.data.volumes.new("smoke")))
    for name, file in (("gone", "gone.png"), ("outside", "../secret.png")):
        image = bpy.data.images.new(name, 4, 4)
        image.source, image.filepath = "FILE", str(folder / file)
        tree = bpy.data.materials[f"paint of {'floor' if name == 'gone' else 'wardrobe'}"].node_tree
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image = image
        tree.links.new(node.outputs[0], tree.nodes["Principled BSDF"].inputs[0])

    (folder / "tiles.1001.png").write_bytes(b"a picture")
    (folder / "tiles.1002.png").symlink_to(folder.parent / "secret.png")
    tiles = bpy.data.images.new("tiles", 4, 4)
    tiles.source, tiles.filepath = "TILED", str(folder / "tiles.<UDIM>.png")
    tiles.tiles.new(1002)
    tree.nodes.new("ShaderNodeTexImage").image = tiles


def add_scripts(bpy: Any, marker: Path) -> None:
    """Three ways to run a script when a file is opened, evaluated or rendered."""
    code = f"open({str(marker)!r}, 'a').write('x')"
    startup = bpy.data.texts.new("startup.py")
    startup.write(
        f"import bpy\n{code}\n"
        f"def ran(*_):\n    {code}\n"
        "bpy.app.handlers.load_post.append(ran)\n"
        "bpy.app.handlers.depsgraph_update_post.append(ran)\n"
        "bpy.app.handlers.render_pre.append(ran)\n"
    )
    startup.use_module = True
    bad = f"[{code}, 0.0][1]"
    for item in list(bpy.data.objects)[:4]:
        curve = item.driver_add("location", 2)
        curve.driver.type, curve.driver.expression = "SCRIPTED", bad
    material = bpy.data.materials["paint of floor"]
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Roughness"].driver_add("default_value").driver.expression = bad
    node = material.node_tree.nodes.new("ShaderNodeScript")
    node.script = startup


def add_readers(bpy: Any, pipe: str) -> None:
    """What makes Blender read ``pipe`` as soon as the scene is evaluated; and a second scene."""
    cache = bpy.data.objects["wall 0"].modifiers.new("cache", "MESH_CACHE")
    cache.cache_format, cache.filepath = "PC2", pipe
    group = bpy.data.node_groups.new("reader", "GeometryNodeTree")
    group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    reader, end = group.nodes.new("GeometryNodeImportOBJ"), group.nodes.new("NodeGroupOutput")
    reader.inputs[0].default_value = pipe
    group.links.new(reader.outputs[0], end.inputs[0])
    table = add(bpy, "reader", [(0, 0, 9)], [])
    table.modifiers.new("reader", "NODES").node_group = group
    image = bpy.data.images.new("noise", 4, 4)
    image.source, image.filepath = "FILE", pipe
    texture = bpy.data.textures.new("noise", "IMAGE")
    texture.image = image
    bpy.data.objects["floor"].modifiers.new("noise", "DISPLACE").texture = texture
    volume = bpy.data.volumes.new("smoke")
    volume.filepath = pipe
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("smoke", volume))
    bpy.data.scenes.new("a second")


def save(bpy: Any, path: Path) -> None:
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=True)


def make_all(bpy: Any, folder: Path) -> None:
    inner = folder / "scenes"
    inner.mkdir()
    build_house(bpy)
    save(bpy, inner / "house.blend")
    bpy.ops.wm.obj_export(filepath=str(inner / "house.obj"), global_scale=1000.0)
    bpy.ops.wm.usd_export(filepath=str(inner / "house.usdc"))
    bpy.ops.wm.usd_export(filepath=str(inner / "house.usda"))
    bpy.ops.export_scene.gltf(
        filepath=str(inner / "house.gltf"), export_format="GLTF_SEPARATE", export_apply=True
    )
    add_oddities(bpy, inner)
    save(bpy, inner / "odd.blend")
    build_workshop(bpy)
    save(bpy, inner / "workshop.blend")
    build_house(bpy)
    add_scripts(bpy, folder / "marker")
    save(bpy, inner / "evil.blend")
    build_house(bpy)
    add_readers(bpy, str(folder / "pipe"))
    save(bpy, inner / "nosy.blend")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(str(inner / "house.blend"), link=True) as (there, here):
        here.objects = there.objects[:2]
    for item in here.objects:
        bpy.context.scene.collection.objects.link(item)
    save(bpy, inner / "linking.blend")


def contents(bpy: Any, path: Path) -> dict[str, Any]:
    """What a Blender file holds."""
    bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False, use_scripts=False)
    scene = bpy.context.scene
    camera = scene.camera
    return {
        "collections": {c.name: sorted(o.name for o in c.objects) for c in bpy.data.collections},
        "objects": sorted(item.name for item in scene.objects),
        "origins": {o.name: [*o.location, o.rotation_euler[2]] for o in scene.objects},
        "texts": [text.name for text in bpy.data.texts],
        "drivers": sum(
            len(item.animation_data.drivers) for item in bpy.data.objects if item.animation_data
        ),
        "nodes": sorted(
            {n.bl_idname for m in bpy.data.materials if m.node_tree for n in m.node_tree.nodes}
        ),
        "unpacked": [i.name for i in bpy.data.images if i.source == "FILE" and not i.packed_file],
        "camera": None if camera is None else [camera.data.panorama_type, *camera.location],
        "energy": {light.name: light.energy for light in bpy.data.lights},
    }


def run(*arguments: object) -> None:
    """Run this module in a new process."""
    root = str(Path(__file__).parents[2])
    done = subprocess.run(
        [sys.executable, __file__, *map(str, arguments)],
        env={**os.environ, "PYTHONPATH": root},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]


def read_contents(folder: Path, path: Path) -> dict[str, Any]:
    """What Blender finds in a file; see `contents`."""
    run(folder, "list", path)
    found: dict[str, Any] = json.loads((folder / "contents.json").read_text())
    return found


def main() -> None:
    bpy, folder = load_bpy(), Path(sys.argv[1])
    if len(sys.argv) == 2:
        make_all(bpy, folder)
    elif sys.argv[2] == "trust":
        bpy.ops.wm.open_mainfile(filepath=sys.argv[3], load_ui=False, use_scripts=True)
    else:
        (folder / "contents.json").write_text(json.dumps(contents(bpy, Path(sys.argv[3]))))
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main()
