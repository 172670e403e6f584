#!/usr/bin/env bash
# Uses a wheel from an empty folder: ./check_wheel.sh WHEEL FOLDER
# What it depends on comes from the environment that is active; nothing comes from this repository.
set -euo pipefail
source=$(dirname "$(realpath "$0")")
wheel=$(realpath "$1")
mkdir -p "$2/work"
folder=$(realpath "$2")
: >"$folder/log"
export PYTHONPATH="$folder/packages"

fail() { echo "check_wheel: $*" >&2; cat "$folder/log" >&2; exit 1; }
run() { python -P -m roomseg.cli "$@" >"$folder/log" 2>&1 || fail "roomseg $*"; }

python -m pip install --quiet --no-deps --no-index --disable-pip-version-check --no-compile \
    --target "$folder/packages" "$wheel"
# The same sources have the same machine code; without it the first run would compile for a while.
for package in simulator scenes; do
    mkdir -p "$folder/packages/$package/__pycache__"
    cp "$source/$package/__pycache__/"*.nb[ic] "$folder/packages/$package/__pycache__/" 2>/dev/null || true
done

cd "$folder/work"
python -P -c 'import simulator, sys; sys.exit(not simulator.__file__.startswith(sys.argv[1]))' "$folder" ||
    fail "the packages of $wheel are not the ones that are imported"
# Everything that is no module: reference places, templates.
for file in $(cd "$source" && find dataset render roomseg scenes simulator -type f ! -name "*.py" ! -path "*/__pycache__/*"); do
    [ -e "$folder/packages/$file" ] || fail "$file: not in the wheel"
done
[ -n "$(find "$folder/packages" -path '*/licenses/LICENSE')" ] || fail "LICENSE: not in the wheel"

run --help
run generate --seed 3 --rooms 2 -o home.json
run view home.json -o home.svg
run simulate home.json -o maps
map=$(echo maps/*.h5)
run validate "$map"
run segment "$map"
run view "$map" --show run --show rooms -o map.png
run view "$map" -o map.html
run export "$map" -o graph.json
run inspect sim1
ls -1 home.json home.svg "$map" map.png map.html graph.json >"$folder/log"
