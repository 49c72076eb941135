# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Reader and writer for network weights: a safetensors file with a JSON manifest.

The manifest ``NAME.json`` of ``NAME.safetensors`` holds the file's ``sha256``, the feature
``schema`` that the network was trained on, the ``network`` configuration, every tensor's shape,
and the origin of the weights (``training``, ``figures``). The reader unpickles nothing and
refuses tensors that the manifest does not describe.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import hashlib
from importlib import resources
from importlib.resources.abc import Traversable
import json
import lzma
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError
import safetensors.numpy

from fpnet_core.errors import WeightsError
from fpnet_core.io.atomic import replaced

_ONNX = '.onnx.xz'  # given
# Numerical: LZMA models bytes by their position in a number; low bytes of float16 values are zero.
_FILTERS = ({'id': lzma.FILTER_LZMA2, 'preset': 9, 'lc': 0, 'lp': 2, 'pb': 2},)

PACKAGED_NAME = 'matcher.safetensors'

_REMEDY = 'reinstall fpnet_ros or train again with fpnet train matcher'


@dataclass(frozen=True, eq=False)
class Weights:
    """Tensors by name, with their manifest."""

    tensors: dict[str, NDArray[Any]]
    manifest: dict[str, Any]


def read_weights(path: Path | None, schema: int, packaged: str = PACKAGED_NAME) -> Weights:
    """
    Read and check a checkpoint.

    Parameters
    ----------
    path : a ``.safetensors`` file with its manifest in the same folder; None reads the file
        ``packaged`` of the package
    schema : schema of the features that the caller computes

    Raises
    ------
    WeightsError
        If a file is missing or malformed, the hash or the feature schema differs, or a tensor is
        missing, unexpected or of the wrong shape.
    """
    folder: Traversable = resources.files('fpnet_core.weights') if path is None else path.parent
    name = packaged if path is None else path.name
    manifest = _read_manifest(folder, name)
    data = _checked(folder, name, manifest, schema)
    try:
        tensors = safetensors.numpy.load(data)
    except SafetensorError as error:
        raise WeightsError(f'{name}: not a safetensors file ({error}); {_REMEDY}') from None
    shapes = {key: tuple(shape) for key, shape in manifest['tensors'].items()}
    check_shapes(name, tensors, shapes)
    return Weights(tensors, manifest)


def read_onnx(path: Path | None, schema: int, packaged: str) -> tuple[bytes, dict[str, Any]]:
    """
    Read and check an LZMA-compressed ONNX network; return it uncompressed with its manifest.

    The manifest is in the same folder as ``path``; None reads the file ``packaged`` of the
    package.

    Raises
    ------
    WeightsError
        If a file is missing or malformed, or the hash or the schema differs.
    """
    folder: Traversable = resources.files('fpnet_core.weights') if path is None else path.parent
    name = packaged if path is None else path.name
    manifest = _read_manifest(folder, name)
    data = _checked(folder, name, manifest, schema)
    try:
        return lzma.decompress(data), manifest
    except lzma.LZMAError as error:
        raise WeightsError(f'{name}: not LZMA-compressed ({error}); {_REMEDY}') from None


def write_onnx(path: Path, network: bytes, schema: int, facts: Mapping[str, Any]) -> None:
    """Write a network for :func:`read_onnx`; ``facts`` must contain ``network``."""
    data = lzma.compress(network, filters=_FILTERS)
    manifest = {'sha256': hashlib.sha256(data).hexdigest(), 'schema': schema, **facts}
    with replaced(path) as packed, replaced(_manifest_of(path)) as manifest_file:
        packed.write_bytes(data)
        manifest_file.write_text(json.dumps(manifest, indent=1) + '\n', encoding='utf-8')


def write_weights(
    path: Path, tensors: Mapping[str, NDArray[Any]], schema: int, facts: Mapping[str, Any]
) -> None:
    """
    Write ``path`` (.safetensors) and its manifest.

    Both files are renamed to their final names once both are complete. If the machine stops
    between the two renames, the hash does not match.

    ``facts`` are the manifest's other entries, JSON-serialisable; must contain ``network``.
    """
    # Copy to row-major order, because safetensors stores the buffer as it is in memory.
    data = safetensors.numpy.save({key: np.array(value) for key, value in tensors.items()})
    manifest = {
        'sha256': hashlib.sha256(data).hexdigest(),
        'schema': schema,
        **facts,
        'tensors': {key: list(value.shape) for key, value in sorted(tensors.items())},
    }
    with replaced(path) as weights, replaced(_manifest_of(path)) as manifest_file:
        weights.write_bytes(data)
        manifest_file.write_text(json.dumps(manifest, indent=1) + '\n', encoding='utf-8')


def _checked(folder: Traversable, name: str, manifest: dict[str, Any], schema: int) -> bytes:
    """Return a file's bytes after checking them against manifest and schema."""
    if manifest['schema'] != schema:
        raise WeightsError(
            f'{name}: made for feature schema {manifest["schema"]!r}, this version computes '
            f'schema {schema}; {_REMEDY}'
        )
    data = _read_bytes(folder, name)
    digest = hashlib.sha256(data).hexdigest()
    if digest != manifest['sha256']:
        raise WeightsError(
            f'{name}: sha256 is {digest[:12]}..., its manifest says '
            f'{str(manifest["sha256"])[:12]}...; the file is damaged or was replaced; {_REMEDY}'
        )
    return data


def network_of(
    weights: Weights, what: str, names: Mapping[str, Sequence[str]], remedy: str
) -> dict[str, Any]:
    """
    Return the manifest's ``network`` after checking its lists of features or classes.

    Raises
    ------
    WeightsError
        If a list differs from ``names``; the message says how to train ``what`` again.
    """
    network: dict[str, Any] = weights.manifest['network']
    for key, expected in names.items():
        if network.get(key) != list(expected):
            raise WeightsError(
                f'{what} weights: {key} differ from those of this version; train again with '
                f'fpnet {remedy}'
            )
    return network


def check_shapes(
    name: str, tensors: Mapping[str, NDArray[Any]], expected: Mapping[str, tuple[int, ...]]
) -> None:
    """Raise WeightsError for the first tensor that is missing, unexpected or misshapen."""
    found = {key: value.shape for key, value in tensors.items()}
    for key in sorted({*found, *expected}):
        if found.get(key) != expected.get(key):
            raise WeightsError(
                f'{name}: tensor {key}: expected {_describe(expected.get(key))}, '
                f'got {_describe(found.get(key))}; {_REMEDY}'
            )


def _describe(shape: tuple[int, ...] | None) -> str:
    return 'none' if shape is None else f'shape {shape}'


def _manifest_of(path: Path) -> Path:
    return path.with_name(f'{path.name.removesuffix(_ONNX).removesuffix(".safetensors")}.json')


def _read_bytes(folder: Traversable, name: str) -> bytes:
    try:
        return (folder / name).read_bytes()
    except OSError as error:
        reason = error.strerror or 'cannot be read'
        raise WeightsError(f'weights {folder / name}: {reason}; {_REMEDY}') from None


def _read_manifest(folder: Traversable, name: str) -> dict[str, Any]:
    is_onnx = name.endswith(_ONNX)
    if not is_onnx and not name.endswith('.safetensors'):
        raise WeightsError(
            f'weights {name}: expected a .safetensors file, or an {_ONNX} file of the parser'
        )
    manifest_name = str(_manifest_of(Path(name)))
    try:
        manifest: dict[str, Any] = json.loads(_read_bytes(folder, manifest_name))
    except ValueError as error:
        raise WeightsError(f'{manifest_name}: not valid JSON ({error}); {_REMEDY}') from None
    wanted = {'sha256': str, 'schema': int, 'network': dict}
    wanted |= {} if is_onnx else {'tensors': dict}
    for key, kind in wanted.items():
        if not isinstance(manifest, dict) or not isinstance(manifest.get(key), kind):
            raise WeightsError(f'{manifest_name}: lacks {key!r} ({kind.__name__}); {_REMEDY}')
    return manifest
