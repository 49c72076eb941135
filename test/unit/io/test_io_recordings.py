# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A recording is found in its folder, and its truth is of one floorplan only."""

import json

import pytest

from fpnet.recordings.opening import bag_within
from fpnet.recordings.truth import RESOLUTION_KEY, check_truth
from fpnet_core.errors import FpnetError


def test_the_bag_of_a_simulated_recording_is_found(tmp_path):
    bag = tmp_path / 'drive' / 'bag'
    bag.mkdir(parents=True)
    assert bag_within(tmp_path / 'drive') == bag
    (bag / 'metadata.yaml').write_text('')
    assert bag_within(bag) == bag
    (bag / 'bag').mkdir()
    assert bag_within(bag) == bag, 'a bag itself is not looked into'
    assert bag_within(tmp_path) == tmp_path
    assert bag_within(tmp_path / 'missing') == tmp_path / 'missing'


def test_truth_of_another_resolution_is_refused(tmp_path):
    truth = tmp_path / 'truth.tum'
    check_truth(truth, 0.05)
    (tmp_path / 'truth.json').write_text(json.dumps({RESOLUTION_KEY: 0.0317}))
    check_truth(truth, 0.0317)
    with pytest.raises(FpnetError, match=r'0\.0317 m per pixel, but it was read at 0\.05'):
        check_truth(truth, 0.05)
    check_truth(tmp_path / 'mine.tum', 0.05)
    (tmp_path / 'truth.json').write_text('{}')
    check_truth(truth, 0.05)
