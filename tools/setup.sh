#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
#
# Create .venv with all dependencies of fpnet_ros; called once by `make setup`.
#
#   PYTHON           interpreter to use; default: the first suitable one on the path
#   TORCH_INDEX_URL  package index tried first for PyTorch; empty: the default index only
set -euo pipefail
cd "$(dirname "$0")/.."

readonly VENV=.venv
TORCH_INDEX_URL=${TORCH_INDEX_URL-https://download.pytorch.org/whl/cpu}

say() { printf 'setup: %s\n' "$*"; }
die() { printf 'setup: %s\n' "$*" >&2; exit 1; }

as_root() { [ "$(id -u)" -eq 0 ] && command -v apt-get >/dev/null; }

install_packages() {
    say "installing system packages: $*"
    export DEBIAN_FRONTEND=noninteractive
    { apt-get update -qq && apt-get install -y -qq --no-install-recommends "$@" >/dev/null; } ||
        die "apt-get could not install $*; install them by hand and run make again"
}

# Open3D's renderer is linked against these libraries, even if nothing is rendered.
require_libraries() {
    local missing=() known entry
    known=$(PATH=$PATH:/sbin:/usr/sbin ldconfig -p)
    for entry in libusb-1.0.so.0:libusb-1.0-0 libEGL.so.1:libegl1 libGL.so.1:libgl1 \
        libX11.so.6:libx11-6 libgomp.so.1:libgomp1; do
        grep -qF "${entry%%:*}" <<<"$known" || missing+=("${entry##*:}")
    done
    [ ${#missing[@]} -eq 0 ] && return
    as_root || die "system libraries are missing; run: sudo apt-get install ${missing[*]}"
    install_packages "${missing[@]}"
}

# An interpreter is suitable if it runs, is 3.11 or 3.12, can create environments and, if ROS 2 is
# sourced, imports its rclpy. A program on the path may be a shim that does not run.
is_suitable() {
    local check='import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 12))'
    [ "$1" = with-venv ] && check="import ensurepip, venv; $check"
    [ "${ROS_DISTRO:-}" = jazzy ] && check="import rclpy; $check"
    "$2" -c "$check" >/dev/null 2>&1
}

find_python() {
    local candidate
    for candidate in ${PYTHON:-python3 python3.12 python3.11}; do
        is_suitable "$1" "$candidate" && command -v "$candidate" && return
    done
    return 1
}

require_python() {
    python=$(find_python with-venv) && return
    # Debian and Ubuntu ship the interpreter without the venv module.
    if as_root && [ -z "${PYTHON:-}" ]; then
        install_packages python3 python3-venv
        python=$(find_python with-venv) && return
    fi
    if python=$(find_python any); then
        die "$python cannot create virtual environments; run: sudo apt-get install python3-venv"
    fi
    die "no Python 3.11 or 3.12 found${ROS_DISTRO:+ that imports rclpy}; install one" \
        "(Debian 12, Ubuntu 24.04: sudo apt-get install python3 python3-venv)" \
        "or name it: make PYTHON=/path/to/python3.12"
}

pip_install() {
    "$VENV/bin/python" -m pip install -qq --no-input --disable-pip-version-check "$@"
}

# On Linux, PyPI's torch depends on gigabytes of CUDA libraries; the CPU build is on PyTorch's own
# index only. That index is tried first, without retries, so that an unreachable index costs
# seconds; the fallback is the default index, which may be a mirror with a CPU build.
install_torch() {
    local torch
    torch=$(grep '^torch==' requirements-core.txt)
    if [ -n "$TORCH_INDEX_URL" ] &&
        pip_install --timeout 10 --retries 0 --no-deps --index-url "$TORCH_INDEX_URL" "$torch" \
            2>/dev/null; then
        return
    fi
    say "no PyTorch at ${TORCH_INDEX_URL:-a CPU index}; using the default index"
    pip_install "$torch"
}

# There are no wheels of tf2_msgs, bond, nav2_msgs and our own action; without a compiler the nodes
# run without TF, bond, ~/set_initial_pose and ~/localize.
generate_interfaces() {
    command -v c++ >/dev/null || ! as_root || install_packages g++
    if ! command -v c++ >/dev/null; then
        say 'no C++ compiler, so no TF and no action: install g++ and run make setup again'
        return
    fi
    say 'generating messages without wheels'
    pip_install -r requirements-interfaces.txt
    tools/interfaces/build.sh "$VENV"
}

main() {
    local requirements=requirements.txt options=()
    case ${ROS_DISTRO:-} in
        '') ;;
        jazzy)
            requirements=requirements-jazzy.txt options=(--system-site-packages)
            say 'using the rclpy of the sourced ROS 2 Jazzy'
            ;;
        *) die "ROS 2 $ROS_DISTRO is sourced; expected jazzy, or a shell without ROS 2" ;;
    esac
    require_libraries
    require_python
    say "creating $VENV with $("$python" --version) (takes some minutes, once)"
    "$python" -m venv "${options[@]}" "$VENV"
    touch "$VENV/COLCON_IGNORE"
    say 'installing PyTorch'
    install_torch
    say "installing $requirements and requirements-dev.txt"
    pip_install -r "$requirements" -r requirements-dev.txt
    pip_install --no-deps --no-build-isolation --editable .
    [ -n "${ROS_DISTRO:-}" ] || generate_interfaces
    say 'done'
}

main
