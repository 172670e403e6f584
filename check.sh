#!/usr/bin/env bash
# Everything that must hold before a change lands: lint, types, tests, and a wheel that builds.
set -euo pipefail
cd "$(dirname "$0")"
export PATH="$PWD/.venv/bin:$PATH"

ruff format --check .
ruff check .
mypy
wheels=$(mktemp -d)
trap 'rm -rf "$wheels"' EXIT
python -m build --wheel --no-isolation --outdir "$wheels" >/dev/null
pytest -q -n 2 "$@"
