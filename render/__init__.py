"""Fisheye images of every map node by Blender Cycles (§3.1)."""
