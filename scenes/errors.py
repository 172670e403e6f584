"""The error that every bad apartment ends in."""

__all__ = ["SceneError"]


class SceneError(Exception):
    """Bad apartment; the message is one line: file, field, value, what would be right."""
