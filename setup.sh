#!/usr/bin/env bash
# Sets up everything that roomseg needs beside Python 3.11: the virtual environment .venv with
# pinned packages, the shared libraries that Blender's Python module loads, and Chromium for tests.
set -euo pipefail
cd "$(dirname "$0")"

fail() { echo "setup: $*" >&2; exit 2; }

python=${PYTHON:-$(command -v python3.11 || echo python3)}
"$python" -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' 2>/dev/null ||
    fail "Python 3.11 not found (set PYTHON=/path/to/python3.11); Blender 5.0's module needs exactly 3.11"

if ! .venv/bin/python -m pip --version >/dev/null 2>&1; then
    rm -rf .venv
    "$python" -m venv .venv >/dev/null ||
        fail "cannot make a virtual environment (on Debian: apt-get install python3.11-venv)"
fi
echo "setup: installing Python packages into .venv (about 530 MB on the first run)"
.venv/bin/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'

# bpy loads X11 and OpenGL libraries although no window is ever opened.
loads() { .venv/bin/python -m render.libraries; }
if ! loads 2>/dev/null && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    packages=$(.venv/bin/python -c 'from render.libraries import DEBIAN_PACKAGES as p; print(*p.values())')
    echo "setup: installing system libraries: $packages"
    # shellcheck disable=SC2086  # a list of packages
    { apt-get update -qq && apt-get install -y -qq --no-install-recommends $packages; } >/dev/null || true
fi
loads || exit 2

# The tests of the browser pages drive Chromium; without it they are left out.
if ! command -v chromium >/dev/null && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    echo "setup: installing chromium for the tests"
    { apt-get update -qq && apt-get install -y -qq --no-install-recommends chromium; } >/dev/null || true
fi
touch .venv/ready
echo "setup: ready; use it with: . .venv/bin/activate"
