#!/usr/bin/env bash
# Everything that must hold before a change lands: lint, types, the site, a wheel that works, tests.
set -euo pipefail
cd "$(dirname "$0")"
export PATH="$PWD/.venv/bin:$PATH"
export NO_MKDOCS_2_WARNING=1  # an advertisement

ruff format --check .
ruff check .
mypy
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
mkdocs build --strict --site-dir "$scratch/site"  # with --quiet, warnings would not count
python -m build --wheel --no-isolation --outdir "$scratch" >/dev/null
pytest -q -n 2 "$@"
./check_wheel.sh "$scratch"/*.whl "$scratch/installed"
