# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Robots of all kinds find themselves with what the launch file starts: the short form."""

from pathlib import Path
import subprocess
import sys

import pytest

pytest.importorskip('rclpy')
pytest.importorskip('tf2_msgs.msg', reason='needs a C++ compiler at set-up')

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.alone]

ROOT = Path(__file__).parents[2]


def test_every_robot_of_the_short_form_passes():
    command = [sys.executable, str(ROOT / 'benchmarks' / 'wirings.py'), '--short']
    run = subprocess.run(command, capture_output=True, text=True, timeout=1200, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
    assert run.stdout.count('| passes |') == 4
