# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The network that parses pictures: what comes out, and which files are taken."""

from importlib import resources
import json
import subprocess
import sys

import numpy as np
from plan_pictures import storey
import pytest

from fpnet_core.drawings.parsing.network import (
    PARSER_NAME,
    PARSER_SCHEMA,
    network_from,
    packaged_parser,
    parse,
)
from fpnet_core.errors import WeightsError
from fpnet_core.io.pixel_classes import CLASSES, FLOOR, OUTSIDE
from fpnet_core.io.weights import read_onnx, write_onnx


def test_probabilities_are_of_the_pictures_own_size():
    pixels = np.random.default_rng(3).integers(0, 256, (70, 45, 3)).astype(np.uint8)
    seen = parse(pixels).chances
    assert seen.shape == (len(CLASSES), 70, 45)
    np.testing.assert_allclose(seen.sum(axis=0), 1.0, atol=1e-5)


def test_rooms_are_told_from_paper():
    picture, labels = storey()
    seen = parse(picture).chances.argmax(axis=0)
    rooms = labels > 0
    assert (seen[rooms] == FLOOR).mean() > 0.6
    padded = parse(np.pad(picture, ((60, 60), (60, 60), (0, 0)), constant_values=255)).chances
    assert padded[OUTSIDE, :40].mean() > 0.8


def test_the_packaged_network_is_that_of_its_manifest():
    data, manifest = read_onnx(None, PARSER_SCHEMA, PARSER_NAME)
    assert manifest['network']['classes'] == list(CLASSES)
    assert manifest['data']['command'].startswith('fpnet train parser')
    assert manifest['figures']['iou']['all']['wall'] > 0.5
    assert len(data) > 1_000_000
    assert len((resources.files('fpnet_core.weights') / PARSER_NAME).read_bytes()) < 10_000_000
    assert packaged_parser() is packaged_parser()


def test_what_is_not_the_network_is_refused(tmp_path):
    path = tmp_path / 'parser.onnx.xz'
    with pytest.raises(WeightsError, match='No such file'):
        read_onnx(path, PARSER_SCHEMA, PARSER_NAME)
    write_onnx(path, b'not a network', PARSER_SCHEMA, {'network': {'classes': ['wall']}})
    data, manifest = read_onnx(path, PARSER_SCHEMA, PARSER_NAME)
    assert data == b'not a network'
    with pytest.raises(WeightsError, match='fpnet train parser'):
        network_from(data, manifest)
    with pytest.raises(WeightsError, match='schema'):
        read_onnx(path, PARSER_SCHEMA + 1, PARSER_NAME)
    path.write_bytes(path.read_bytes() + b'!')
    with pytest.raises(WeightsError, match='sha256'):
        read_onnx(path, PARSER_SCHEMA, PARSER_NAME)
    said = json.loads((tmp_path / 'parser.json').read_text())
    del said['sha256']
    (tmp_path / 'parser.json').write_text(json.dumps(said))
    with pytest.raises(WeightsError, match='sha256'):
        read_onnx(path, PARSER_SCHEMA, PARSER_NAME)


def test_reading_a_picture_loads_no_torch(tmp_path):
    from PIL import Image

    Image.fromarray(storey(wall=(150, 40, 30))[0]).save(tmp_path / 'plan.png')
    code = (
        'import sys; from fpnet_core.drawings.read import read_plan; '
        f'print(read_plan({str(tmp_path / "plan.png")!r}).how); print("torch" in sys.modules)'
    )
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    how, has_torch = done.stdout.splitlines()[-2:]
    assert how == 'walls and rooms segmented by the network'
    assert has_torch == 'False'
