# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0

import numpy as np
import pytest

from fpnet_core.config import FpnetConfig
from fpnet_core.localizer import Localizer, create_localizer
from fpnet_core.localizer import warm_up as module
from fpnet_core.types import OCCUPIED, Status


def recorded_ticks(monkeypatch):
    """What every tick from now on returns, as it is returned."""
    outputs = []
    update = Localizer.update

    def recording_tick(self, now_ns):
        outputs.append(update(self, now_ns))
        return outputs[-1]

    monkeypatch.setattr(Localizer, 'update', recording_tick)
    return outputs


def test_every_stage_runs(monkeypatch):
    outputs = recorded_ticks(monkeypatch)
    module.warm_up(create_localizer(FpnetConfig()))
    # Placements were proposed, verified and refined, so that nothing is left to compile.
    assert outputs[-1].status in (Status.AMBIGUOUS, Status.LOCALIZED)
    assert len(outputs[-1].segmentation.rooms) == 2
    assert len(outputs[-1].segmentation.portals) == 1
    assert outputs[-1].match.hypotheses
    assert outputs[-1].estimates[0].score > 0.5


@pytest.mark.parametrize('resolution_m', [0.02, 0.2])
def test_any_configured_resolution_will_do(monkeypatch, resolution_m):
    outputs = recorded_ticks(monkeypatch)
    module.warm_up(create_localizer(FpnetConfig(submap={'resolution_m': resolution_m})))
    assert outputs[-1].submap.grid.resolution == resolution_m
    assert outputs[-1].segmentation.rooms


def test_the_scan_fits_the_toy_plan():
    grid, scan = module._toy_plan(), module._toy_scan()
    scan = scan[scan[:, 2] < module._LINTEL_M]
    centre = np.array([0.2 + 3.0, 0.2 + 2.5])
    columns, rows = np.floor((scan[:, :2] + centre) / grid.resolution).astype(int).T
    near = [
        grid.cells[np.clip(rows + i, 0, None), np.clip(columns + j, 0, None)] == OCCUPIED
        for i in (-1, 0, 1)
        for j in (-1, 0, 1)
    ]
    assert np.any(near, axis=0).all()
