# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0

import os
import platform
import subprocess
import sys

import pytest

RASTERS = """
import resource
import numpy as np
from fpnet_core.freed_memory import keep_freed_memory

def faults():
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    for _ in range(20):
        rasters = [np.ones((1000, 1000), np.uint8) for _ in range(12)]
        del rasters
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before

faults()
print(faults(), keep_freed_memory(), faults() and faults())
"""


@pytest.mark.skipif(platform.libc_ver()[0] != 'glibc', reason='another C library')
def test_rasters_of_a_second_tick_lie_where_those_of_the_first_did():
    environment = {key: value for key, value in os.environ.items() if 'MALLOC' not in key}
    made = subprocess.run(
        [sys.executable, '-c', RASTERS],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    before, is_kept, after = made.stdout.split()
    assert is_kept == 'True'
    assert int(before) > 2000
    assert int(after) < int(before) / 20
