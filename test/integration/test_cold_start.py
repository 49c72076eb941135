# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A warm-up leaves a drive nothing to compile: no tick of a new installation takes seconds."""

from dataclasses import replace
import subprocess
import sys

import pytest
from short_recording import start_of_recording

from fpnet_lab.sim.drives.recording import write_recording
from fpnet_lab.sim.lidars.sensors import SENSORS

# In a process of its own: other tests have compiled what they use.
DRIVEN = """
import gc
import sys

from numba.core.dispatcher import Dispatcher

import fpnet
from fpnet_core.config import FpnetConfig
from fpnet_core.localizer import create_localizer
from fpnet_core.localizer.warm_up import warm_up

def compiled():
    functions = [each for each in gc.get_objects() if isinstance(each, Dispatcher)]
    return {(f.py_func.__name__, str(kind)) for f in functions for kind in f.signatures}

plan = fpnet.read_plan(sys.argv[1] + '/floorplan.yaml')
warm_up(create_localizer(FpnetConfig()))
warm = compiled()
run = fpnet.localize(plan, sys.argv[1] + '/bag')
assert len(warm) > 20, warm
assert run.status is fpnet.Status.LOCALIZED, run
print(compiled() - warm or 'nothing')
"""


@pytest.mark.slow
# A third of their rays: what is compiled depends on the kind of scan, and not on its size.
@pytest.mark.parametrize(('sensor', 'seed'), [('beams32', 4), ('dome', 3)])
def test_a_drive_compiles_nothing_that_the_warm_up_has_not(tmp_path, sensor, seed):
    lidar = replace(SENSORS[sensor], columns=SENSORS[sensor].columns // 3)
    write_recording(start_of_recording(20.0, lidar, seed), tmp_path)
    ended = subprocess.run(
        [sys.executable, '-c', DRIVEN, str(tmp_path)], capture_output=True, text=True, check=False
    )
    assert ended.stdout.strip() == 'nothing', ended.stdout + ended.stderr
