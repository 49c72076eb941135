# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Resumable state of a run: one safetensors file, scalars in its header, no pickle."""

from __future__ import annotations

from collections.abc import Mapping
import json
from pathlib import Path
from typing import Any

from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file
import torch
from torch import Tensor, nn

from fpnet_core.errors import WeightsError
from fpnet_core.io.atomic import replaced

_NETWORK, _OPTIMIZER = 'network.', 'optimizer.'
_HEADER = 'state'


def save_state(
    path: Path, network: nn.Module, optimizer: torch.optim.Optimizer, scalars: Mapping[str, Any]
) -> None:
    """
    Write parameters, optimizer moments and JSON ``scalars``.

    The write is atomic: a run that is killed while writing keeps its previous state.
    """
    tensors = {_NETWORK + key: value for key, value in network.state_dict().items()}
    for index, moments in optimizer.state_dict()['state'].items():
        tensors.update({f'{_OPTIMIZER}{index}.{key}': value for key, value in moments.items()})
    plain = {key: value.detach().cpu().contiguous() for key, value in tensors.items()}
    with replaced(path) as partial:
        save_file(plain, partial, metadata={_HEADER: json.dumps(dict(scalars))})


def load_state(path: Path, network: nn.Module, optimizer: torch.optim.Optimizer) -> dict[str, Any]:
    """
    Restore parameters and optimizer moments in place and return the scalars.

    Raises
    ------
    WeightsError
        If the file is not a state of this network.
    """
    try:
        with safe_open(path, framework='pt') as file:
            tensors = {key: file.get_tensor(key) for key in file.keys()}  # noqa: SIM118
            scalars: dict[str, Any] = json.loads(file.metadata()[_HEADER])
        network.load_state_dict(_below(tensors, _NETWORK))
    except (SafetensorError, OSError, RuntimeError, KeyError, TypeError, ValueError) as error:
        raise WeightsError(
            f'{path}: not a training state of this network '
            f'({str(error).splitlines()[0]}); remove it to start again'
        ) from None
    moments: dict[int, dict[str, Tensor]] = {}
    for key, value in _below(tensors, _OPTIMIZER).items():
        index, _, name = key.partition('.')
        moments.setdefault(int(index), {})[name] = value
    optimizer.load_state_dict({**optimizer.state_dict(), 'state': moments})
    return scalars


def _below(tensors: Mapping[str, Tensor], prefix: str) -> dict[str, Tensor]:
    return {k.removeprefix(prefix): v for k, v in tensors.items() if k.startswith(prefix)}
