# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Serialization of the evidence model in a checkpoint's manifest."""

from __future__ import annotations

from typing import Any

import numpy as np

from fpnet_core.errors import WeightsError
from fpnet_core.io.weights import Weights
from fpnet_core.matching.consensus import EVIDENCE, EvidenceModel

_NONE = 'none'


def evidence_entry(model: EvidenceModel) -> dict[str, float]:
    """Return the model as the manifest's ``evidence`` entry."""
    named = zip(EVIDENCE, model.weights.tolist(), strict=True)
    return {**dict(named), _NONE: model.null}


def evidence_model(weights: Weights) -> EvidenceModel | None:
    """
    Return the model in the manifest, or None if it has none.

    Raises
    ------
    WeightsError
        If its kinds of evidence differ from those of this version.
    """
    entry: Any = weights.manifest.get('evidence')
    if entry is None:
        return None
    expected = {*EVIDENCE, _NONE}
    if not isinstance(entry, dict) or set(entry) != expected:
        found = sorted(entry) if isinstance(entry, dict) else entry
        raise WeightsError(
            f'weights manifest: evidence: expected {sorted(expected)}, got {found}; '
            'calibrate again with fpnet train matcher'
        )
    return EvidenceModel(np.array([float(entry[name]) for name in EVIDENCE]), float(entry[_NONE]))
