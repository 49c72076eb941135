# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Learning to read walls: samples, patches, a run that goes on where it was."""

from dataclasses import replace
import json

import numpy as np
import pytest
import torch

from fpnet_core.errors import FpnetError
from fpnet_core.io.pixel_classes import CLASSES, FLOOR, OUTSIDE, WALL, WINDOW
from fpnet_core.io.weights import read_weights
from fpnet_core.models.walls import WALLS_SCHEMA, WallNetwork, WallNetworkConfig, wall_network_of
from fpnet_lab.evaluation.drawings import FIRST_SEEDS as BENCH_SEEDS
from fpnet_lab.sim.sheets import SheetKind
from fpnet_lab.training.wall_patches import patch, patches
from fpnet_lab.training.wall_samples import (
    FIRST_SEEDS,
    MOST_BUILDING_PX,
    WallSample,
    gather_samples,
    read_sample,
    resized,
    sample_stems,
    sheet_sample,
)
from fpnet_lab.training.walls import WallTrainer, WallTraining, unweighted

SMALL = WallNetworkConfig(widths=(4, 8, 8, 8, 8), down_blocks=(1, 1, 1, 1))
QUICK = WallTraining(steps=4, batch_size=2, side_px=64, save_every=2)


@pytest.fixture
def sample():
    """A building of two rooms, 100 by 60 pixels, walls of 4, on a sheet of 200 by 120."""
    classes = np.full((120, 200), OUTSIDE, np.uint8)
    classes[30:90, 50:150] = WALL
    classes[34:86, 54:98] = FLOOR
    classes[34:86, 102:146] = FLOOR
    classes[30:34, 60:80] = WINDOW
    pixels = np.where(classes[..., None] == WALL, 40, 240).astype(np.uint8)
    return WallSample(np.repeat(pixels, 3, axis=2), classes)


@pytest.fixture(scope='module')
def samples(tmp_path_factory):
    folder = tmp_path_factory.mktemp('walls')
    gather_samples(folder / 'samples', {'train': 2, 'held': 1}, None)
    return folder


def test_no_seed_is_learned_from_that_readers_are_measured_on():
    starts = [*BENCH_SEEDS.values(), *FIRST_SEEDS.values()]
    assert min(np.diff(sorted(starts))) >= 1_000_000


def test_a_building_is_as_long_as_it_is_drawn(sample):
    assert sample.building_px == 100
    nothing = WallSample(sample.pixels, np.zeros_like(sample.classes))
    assert nothing.building_px == 1


@pytest.mark.parametrize('factor', [0.5, 0.3])
def test_walls_of_a_smaller_picture_stay_closed(sample, factor):
    small = resized(sample, (round(200 * factor), round(120 * factor)))
    assert small.pixels.shape[:2] == small.classes.shape == (120 * factor, 200 * factor)
    assert small.building_px == pytest.approx(100 * factor, abs=1)
    middle = small.classes[round(60 * factor)]
    runs = np.flatnonzero(np.diff((middle == FLOOR).astype(int)) == 1)
    assert len(runs) == 2  # two rooms, a wall between them


def test_sheets_are_kept_as_they_were_drawn(samples):
    stems = sample_stems(samples / 'samples', 'train')
    assert [stem.name.partition('-')[0] for stem in stems] == ['clean', 'office']
    kept = read_sample(stems[0])
    drawn = sheet_sample(FIRST_SEEDS['train'], SheetKind.CLEAN)
    np.testing.assert_array_equal(kept.pixels, drawn.pixels)
    np.testing.assert_array_equal(kept.classes, drawn.classes)
    assert kept.building_px <= 1.05 * MOST_BUILDING_PX  # outer walls are beyond the rooms
    with pytest.raises(FpnetError, match='train-walls'):
        sample_stems(samples, 'train')


def test_patches_are_varied_and_their_classes_go_with_them(sample):
    rng = np.random.default_rng(7)
    seen = [patch(sample, 96, rng) for _ in range(30)]
    assert all(p.shape == (96, 96, 3) and c.shape == (96, 96) for p, c in seen)
    assert len({p.tobytes() for p, _ in seen}) > 25  # bare paper looks the same twice
    light = [
        np.median(p[c == FLOOR]) > np.median(p[c == WALL])
        for p, c in seen
        if (c == WALL).sum() > 50 and (c == FLOOR).sum() > 50
    ]
    assert np.mean(light) > 0.7  # few are light on dark


def test_equal_seeds_give_equal_patches(samples):
    stems = sample_stems(samples / 'samples', 'train')
    one, other = (patches(stems, 64, np.random.default_rng(3)) for _ in range(2))
    for _ in range(3):
        for a, b in zip(next(one), next(other), strict=True):
            np.testing.assert_array_equal(a, b)


def test_a_run_writes_weights_and_goes_on_where_it_was(samples):
    told = []
    first = WallTrainer(samples, SMALL, replace(QUICK, steps=2))
    first.run({'data': 'test'}, on_saved=told.append)
    again = WallTrainer(samples, SMALL, QUICK)
    assert again.step == 2
    for a, b in zip(first.mean.parameters(), again.mean.parameters(), strict=True):
        torch.testing.assert_close(a, b)
    again.run({'data': 'test'}, on_saved=told.append)
    assert [figures['step'] for figures in told] == [2, 4]
    assert set(told[-1]['iou']['all']) == set(CLASSES)
    manifest = json.loads((samples / 'walls.json').read_text())
    assert manifest['figures'] == told[-1]
    assert manifest['data'] == 'test'
    network = wall_network_of(read_weights(samples / 'walls.safetensors', WALLS_SCHEMA))
    x = torch.rand(1, 3, 64, 96)
    mean = unweighted(again.mean, QUICK.class_weights).eval()
    with torch.no_grad():
        torch.testing.assert_close(network(x), mean(x), atol=0.02, rtol=0.02)


def test_what_weighs_more_while_learning_is_as_probable_as_it_is():
    network = WallNetwork(SMALL).eval()
    weights = (0.5, 1.0, 2.0, 4.0, 1.0)
    x = torch.rand(1, 3, 32, 32)
    with torch.no_grad():
        before = network(x).softmax(dim=1)
        after = unweighted(network, weights)(x).softmax(dim=1)
    expected = before / torch.tensor(weights)[:, None, None]
    torch.testing.assert_close(after, expected / expected.sum(dim=1, keepdim=True))


def test_every_pixel_gets_its_classes():
    logits = WallNetwork(SMALL).eval()(torch.rand(2, 3, 64, 32))
    assert logits.shape == (2, len(CLASSES), 64, 32)
