"""What MkDocs adds to the pages of this folder: the files beside it, and every command's options.

Links are written for the repository: ``../examples/own_robot.py`` from a page here, ``docs/cli.md``
from the README. The site has the same files, those from outside of this folder below its root, so
that links only lose what leads out of, or into, this folder. A page that would load anything from
elsewhere ends the build.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import click
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files
    from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parent.parent
OUTSIDE = ("CHANGELOG.md", "CONTRIBUTING.md", "LICENSE", "CITATION.cff", "benchmarks/README.md")
"""Files of the repository that pages lead to, beside the examples."""

WIDTH = 86
"""Characters of a line of code."""

UP = re.compile(r"(\]\()\.\./(?:docs/)?")
DOWN = re.compile(r"(\]\()docs/")
LOADED = re.compile(
    r"<(?:script|img|iframe|source|video)\b[^>]*?\bsrc=[\"']?(?:https?:)?//[^\s\"'>]+"
    r"|<link\b[^>]*\bhref=[\"']?(?:https?:)?//[^\s\"'>]+"
    r"|url\([\"']?(?:https?:)?//[^\s\"')]+"
)


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the README as first page, the files from outside of this folder, and the options."""
    paths = [ROOT / name for name in OUTSIDE]
    for path in [*paths, *sorted((ROOT / "examples").iterdir())]:
        name = path.relative_to(ROOT).as_posix()
        files.append(File.generated(config, name, abs_src_path=str(path)))
    files.append(File.generated(config, "index.md", abs_src_path=str(ROOT / "README.md")))
    files.append(File.generated(config, "options.md", content=options_page()))
    return files


def on_page_markdown(markdown: str, page: Page, **_: object) -> str:
    """Turn links of the repository into links of the site."""
    if page.file.src_uri == "index.md":
        return DOWN.sub(r"\1", markdown)
    if "/" in page.file.src_uri:  # of benchmarks or examples
        return UP.sub(r"\1../", markdown)
    return UP.sub(r"\1", DOWN.sub(r"\1", markdown))


def on_post_page(output: str, page: Page, **_: object) -> str:
    """Refuse a page that loads something from elsewhere."""
    if found := LOADED.search(output):
        raise PluginError(f"{page.file.src_uri}: loads {found[0]!r}; expected files of the site")
    return output


def options_page() -> str:
    """``roomseg COMMAND --help`` of every command."""
    from roomseg.cli.main import cli

    parts = ["# All options", "What `roomseg COMMAND --help` prints."]
    with click.Context(cli, info_name="roomseg", **cli.context_settings) as context:
        for name in cli.list_commands(context):
            command = cli.get_command(context, name)
            assert command is not None
            with click.Context(command, context, name, terminal_width=WIDTH) as inner:
                parts.append(f"## roomseg {name}\n\n```text\n{command.get_help(inner)}\n```")
    return "\n\n".join(parts) + "\n"
