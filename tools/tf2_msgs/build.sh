#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
#
# Generate tf2_msgs, which has no wheel, into the virtual environment VENV (default .venv).
# The result talks to every other Jazzy node: name, fields and type hash are tf2_msgs' own.
# Needs a C++ compiler; requirements-tf2.txt brings the generators and CMake.
set -euo pipefail
cd "$(dirname "$0")/../.."

VENV=$(realpath "${1:-.venv}")
readonly VENV SOURCE=$PWD/tools/tf2_msgs
export PATH=$VENV/bin:$PATH AMENT_PREFIX_PATH=$VENV CMAKE_PREFIX_PATH=$VENV
unset PYTHONPATH

# The wheels name the include folders of the interpreter that they were built with.
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

# Importing rclpy re-executes Python with the wheels' libraries on this path; so do its children.
LD_LIBRARY_PATH=$(python -c 'import os, rclpy; print(os.environ["LD_LIBRARY_PATH"])')
export LD_LIBRARY_PATH

build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
{
    cmake -S "$SOURCE" -B "$build" -G Ninja -DCMAKE_INSTALL_PREFIX="$VENV" \
        -DCMAKE_BUILD_TYPE=Release -DBUILD_TESTING=OFF -DPython3_EXECUTABLE="$VENV/bin/python" \
        -DPYTHON_EXECUTABLE="$VENV/bin/python"
    cmake --build "$build"
    cmake --install "$build"
} >"$build/log" 2>&1 || { tail -n 30 "$build/log" >&2; exit 1; }
python -c 'import tf2_msgs.msg'
