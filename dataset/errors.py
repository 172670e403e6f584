"""The one exception family of this project.

Every error that a user can cause derives from `RoomsegError`; its message is
one line that names the file, the field, the value and what would be right. The
command line catches this family in one place and exits with code 2.
"""

__all__ = ["FormatError", "RoomsegError"]


class RoomsegError(Exception):
    """Bad input; the message is one clear line for the user."""


class FormatError(RoomsegError):
    """A map file or a map's array is not what the format says."""
