# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0

import pytest

from fpnet_core.config import FpnetConfig
from fpnet_core.localizer import Localizer, create_localizer
from fpnet_core.localizer import warm_up as module
from fpnet_core.types import Status


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
