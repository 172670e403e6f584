#!/usr/bin/env bash
# Sets up everything that roomseg needs beside Python 3.11: the virtual environment .venv with
# pinned packages, and the shared libraries that Blender's Python module loads.
set -euo pipefail
cd "$(dirname "$0")"

fail() { echo "setup: $*" >&2; exit 2; }

python=${PYTHON:-python3.11}
command -v "$python" >/dev/null || python=python3
"$python" -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' 2>/dev/null ||
    fail "Python 3.11 not found (set PYTHON=/path/to/python3.11); Blender 5.0's module needs exactly 3.11"

# soname → Debian/Ubuntu package
libraries="libX11.so.6:libx11-6 libXrender.so.1:libxrender1 libXfixes.so.3:libxfixes3 libXi.so.6:libxi6
libxkbcommon.so.0:libxkbcommon0 libSM.so.6:libsm6 libICE.so.6:libice6 libGL.so.1:libgl1"
missing_packages() {
    local known
    known=$( (ldconfig -p || /sbin/ldconfig -p) 2>/dev/null)
    for pair in $libraries; do
        grep -q "${pair%%:*}" <<<"$known" || printf '%s ' "${pair##*:}"
    done
}
missing=$(missing_packages)
if [ -n "$missing" ] && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    echo "setup: installing system libraries: $missing"
    # shellcheck disable=SC2086  # a list of packages
    { apt-get update -qq && apt-get install -y -qq --no-install-recommends $missing; } >/dev/null || true
    missing=$(missing_packages)
fi
[ -z "$missing" ] || fail "system libraries missing: sudo apt-get install --no-install-recommends $missing"

[ -x .venv/bin/python ] || "$python" -m venv .venv
echo "setup: installing Python packages into .venv (about 400 MB on the first run)"
.venv/bin/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
touch .venv/ready
