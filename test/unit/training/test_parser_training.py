# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Views of sheets for the parser, and its training."""

import numpy as np
import pytest
import torch

from fpnet_core.drawings.parsing.network import network_from, parse
from fpnet_core.io.pixel_classes import CLASSES
from fpnet_core.io.weights import read_onnx
from fpnet_lab.sim.sheets import SheetKind
from fpnet_lab.training.parser import STATE_FILE, ParserTrainer, ParserTraining
from fpnet_lab.training.parser_network import (
    ParserNetwork,
    ParserNetworkConfig,
    onnx_bytes,
    pooled_scale,
    restored,
    settle,
    unweighted,
)
from fpnet_lab.training.parser_samples import FIRST_SEED, samples, sheet_sample
from fpnet_lab.training.parser_views import two_views

SIDE = 128


@pytest.fixture(scope='module')
def sample():
    return sheet_sample(FIRST_SEED, SheetKind.CLEAN)


def test_views_show_the_same_places(sample):
    """What the second look shows lies in the first one where the map says."""
    rng = np.random.default_rng(5)
    for _ in range(6):
        first, second, A = two_views(sample, SIDE, rng)
        assert first.pixels.shape == second.pixels.shape == (SIDE, SIDE, 3)
        assert first.pixel_m / second.pixel_m == pytest.approx(
            1.0 / np.sqrt(abs(np.linalg.det(A[:2, :2])))
        )
        middle = A[:2] @ [(SIDE - 1) / 2.0, (SIDE - 1) / 2.0, 1.0]
        col, row = np.rint(middle).astype(int)
        if 2 <= col < SIDE - 2 and 2 <= row < SIDE - 2:
            near = first.answers[row - 2 : row + 3, col - 2 : col + 3] & 0b111
            there = second.answers[SIDE // 2 - 3 : SIDE // 2 + 3, SIDE // 2 - 3 : SIDE // 2 + 3]
            assert np.isin(near, np.unique(there & 0b111)).any()


def test_equal_seeds_give_equal_samples():
    one, other = (next(samples(np.random.default_rng(2), FIRST_SEED, 1, [])) for _ in range(2))
    np.testing.assert_array_equal(one.pixels, other.pixels)
    np.testing.assert_array_equal(one.classes, other.classes)


def test_opencv_evaluates_what_torch_trained():
    torch.manual_seed(1)
    network = ParserNetwork(ParserNetworkConfig((4, 8, 8, 8, 8, 8), (1,) * 5, (1,) * 4)).eval()
    for module in network.modules():
        if isinstance(module, torch.nn.BatchNorm2d):
            module.running_var.uniform_(0.5, 2.0)
            module.running_mean.uniform_(-0.5, 0.5)
    pixels = np.random.default_rng(3).integers(0, 256, (64, 128, 3)).astype(np.uint8)
    picture = (torch.from_numpy(pixels).permute(2, 0, 1)[None] / 255.0 - 0.75) / 0.25
    empty = torch.zeros(1, len(CLASSES) + 1, 64, 128)
    with torch.no_grad():
        logits, places = network(torch.cat([picture, empty], dim=1))
    data = onnx_bytes(network)
    opened = network_from(data, {'network': {'classes': list(CLASSES)}})
    seen = parse(pixels, None, opened).chances
    true = logits[0, : len(CLASSES)].softmax(dim=0)
    np.testing.assert_allclose(seen, true, atol=2e-3)
    scale = torch.from_numpy(opened.forward('scale'))
    np.testing.assert_allclose(pooled_scale(scale), pooled_scale(places), atol=2e-3)


def asked_of(network, pictures):
    """Yield pictures, each made with another answer of the network."""
    for picture in pictures:
        network(1e3 * torch.ones(1, 9, 64, 64))
        yield picture


def test_a_packaged_network_learns_on_with_the_same_answers():
    """Normalisations that were folded away come back, and count what they see."""
    torch.manual_seed(1)
    first = ParserNetwork(ParserNetworkConfig())
    pictures = [torch.randn(2, 9, 64, 64) for _ in range(3)]
    with torch.no_grad():
        for picture in pictures:
            first.train()(picture)
        packaged = ParserNetwork(ParserNetworkConfig())
        weights = (0.8, 1.0, 2.5, 4.0, 3.0)
        packaged.load_state_dict(unweighted(first.state_dict(), weights))
        again = ParserNetwork(ParserNetworkConfig())
        restored(onnx_bytes(packaged), again, weights)
        before, after = (each.eval()(pictures[0]) for each in (first, again))
        settle(again, asked_of(again, pictures))
        settled = again.eval()(pictures[0])
    for one, two, three in zip(before, after, settled, strict=True):
        torch.testing.assert_close(two, one, atol=2e-2, rtol=1e-2)  # half precision
        torch.testing.assert_close(three, two, atol=1e-3, rtol=1e-3)
    norm = again.stem.norm
    assert 0.0 < norm.running_mean.abs().max() < 10.0
    assert not torch.equal(norm.weight, torch.ones_like(norm.weight))


def test_a_run_goes_on_where_it_was_and_writes_the_network(tmp_path, monkeypatch):
    monkeypatch.setattr('fpnet_lab.training.parser.DataLoader', _in_this_process)
    settings = {'batch_size': 2, 'chunk': 2, 'side_px': SIDE, 'workers': 0}
    first = ParserTrainer(tmp_path, ParserTraining(steps=1, **settings), None)
    told = []
    first.run(told.append)
    assert told[-1]['step'] == 1
    assert np.isfinite(told[-1]['loss'])
    assert (tmp_path / STATE_FILE).is_file()
    again = ParserTrainer(tmp_path, ParserTraining(steps=2, **settings), None)
    assert again.step == 1
    again.run()
    assert again.step == 2
    monkeypatch.setattr('fpnet_lab.training.parser.held_figures', lambda *_: {'all': {}})
    path = again.write({'data': {'command': 'fpnet train parser'}}, 1)
    data, manifest = read_onnx(path, 1, path.name)
    assert manifest['training']['steps_made'] == 2
    seen = parse(np.full((64, 64, 3), 200, np.uint8), None, network_from(data, manifest)).chances
    assert np.isfinite(seen).all()


def _in_this_process(stream, **_):
    return stream
