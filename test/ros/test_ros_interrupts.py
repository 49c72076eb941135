# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A second signal, as launch and terminal send it, at every line of a node's end."""

import subprocess
import sys

import pytest

from fpnet_lab.nodes.processes import free_domain_id, private_environment

# Node after node in one process: the second signal comes one line later each time, until there
# is no line left. Only the lines of what runs and ends a node are counted.
SCRIPT = """
import os, signal, sys
import rclpy
from rclpy.node import Node
from fpnet_core.errors import FpnetError
from fpnet_ros import runtime

first, second = (getattr(signal, name) for name in sys.argv[1:])


class Saving(Node):
    saved = 0

    def destroy_node(self):
        Saving.saved += 1
        super().destroy_node()


def end_after(count):
    left, is_sent = count, False

    def trace(frame, event, _):
        nonlocal left
        if frame.f_code.co_filename != runtime.__file__:
            return None
        left -= is_sent
        if left == 0:
            left = -1
            os.kill(os.getpid(), second)
        return trace

    def run(node):
        nonlocal is_sent
        is_sent = True
        os.kill(os.getpid(), first)
        rclpy.spin(node)

    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    sys.settrace(trace)
    try:
        status = runtime.run_node(lambda: Saving('saving'), [], run)
    finally:
        sys.settrace(None)
    assert status == 0, status
    return left < 0


count = 1
while end_after(count):
    count += 1
    assert Saving.saved == count - 1, count
print(count, 'lines')
"""


@pytest.mark.parametrize(
    'signals', [('SIGINT', 'SIGINT'), ('SIGTERM', 'SIGINT'), ('SIGINT', 'SIGTERM')]
)
def test_a_second_signal_interrupts_no_end(signals):
    done = subprocess.run(
        [sys.executable, '-c', SCRIPT, *signals],
        env=private_environment(free_domain_id()),
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    lines = int(done.stdout.split()[0])
    assert lines > 5, done.stdout
