"""Sine, cosine and arctangent of `scenes.trigonometry`, as machine code."""

from __future__ import annotations

from scenes import trigonometry
from simulator.compiled import compiled

__all__ = ["arctangent", "sine_cosine"]

sine_cosine = compiled(trigonometry.sine_cosine)
arctangent = compiled(trigonometry.arctangent)
