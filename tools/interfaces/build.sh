#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
#
#   tools/interfaces/build.sh [VENV] [FOLDER ...]
#
# Generate the interfaces without wheels into the virtual environment VENV (default .venv): our own
# fpnet_msgs, and the parts of tf2_msgs, bond and nav2_msgs that the nodes use. They are compatible
# with all other Jazzy nodes: names, fields and type hashes equal those of the released packages.
# Needs a C++ compiler; requirements-interfaces.txt provides the generators and CMake.
set -euo pipefail
cd "$(dirname "$0")/../.."

VENV=$(realpath -s "${1:-.venv}")
FOLDERS=("${@:2}")
[ ${#FOLDERS[@]} -gt 0 ] || FOLDERS=(tools/interfaces/*/ interfaces/*/)
readonly VENV FOLDERS
export PATH=$VENV/bin:$PATH AMENT_PREFIX_PATH=$VENV CMAKE_PREFIX_PATH=$VENV
unset PYTHONPATH

# The wheels refer to the include folders of the interpreter that they were built with.
python - "$VENV" <<'PATHS'
from pathlib import Path
import re
import sys
import sysconfig

import numpy

folders = {
    r'/opt/python/cp\d+-cp\d+/include/python[\d.]+': sysconfig.get_path('include'),
    r'/opt/python/cp\d+-cp\d+/lib/python[\d.]+/site-packages/numpy/_core/include': (
        numpy.get_include()
    ),
}
for path in Path(sys.argv[1], 'share').glob('*/cmake/*.cmake'):
    old = new = path.read_text(encoding='utf-8')
    for pattern, folder in folders.items():
        new = re.sub(pattern, folder, new)
    if new != old:
        path.write_text(new, encoding='utf-8')
PATHS

# Importing rclpy re-executes Python with the wheels' libraries on this path; child processes too.
LD_LIBRARY_PATH=$(python -c 'import os, rclpy; print(os.environ["LD_LIBRARY_PATH"])')
export LD_LIBRARY_PATH

build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT

generate() {
    cmake -S "$1" -B "$build/$2" -G Ninja -DCMAKE_INSTALL_PREFIX="$VENV" \
        -DCMAKE_BUILD_TYPE=Release -DBUILD_TESTING=OFF -DPython3_EXECUTABLE="$VENV/bin/python" \
        -DPYTHON_EXECUTABLE="$VENV/bin/python"
    cmake --build "$build/$2"
    cmake --install "$build/$2"
}

for folder in "${FOLDERS[@]}"; do
    name=$(basename "$folder")
    generate "$folder" "$name" >"$build/$name.log" 2>&1 || { tail -n 30 "$build/$name.log" >&2; exit 1; }
    python -c "import $name"
done
