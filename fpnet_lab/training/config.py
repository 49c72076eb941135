# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Settings of a training run; separate from the run-time settings, which are ROS parameters."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field, ValidationError

from fpnet_core.config import Section, set_dotted
from fpnet_core.errors import ConfigError
from fpnet_core.models.config import InvariantConfig, NetworkConfig


class LossConfig(Section):
    """Weights a, b, c of the paper's equation (10)."""

    match: float = Field(1.0, ge=0.0, description='Likelihood of partners and dustbins.')
    topology: float = Field(0.0, ge=0.0, description='Expected adjacency error.')
    spatial: float = Field(0.0, ge=0.0, description='Expected distance from the true partner.')


class AugmentationConfig(Section):
    """Random changes to each pair, on top of a random rotation of either side."""

    mirror_probability: float = Field(
        0.5, ge=0.0, le=1.0, description='Chance that both sides are mirrored together.'
    )
    feature_noise: float = Field(
        0.05, ge=0.0, description='Standard deviation added to shape and area features.'
    )
    scale_noise: float = Field(
        0.1, ge=0.0, le=0.5, description='Standard deviation of the log scale between sides.'
    )
    crop_probability: float = Field(
        0.5, ge=0.0, le=1.0, description='Chance that only a connected part of a side is kept.'
    )
    drop_probability: float = Field(
        0.05, ge=0.0, lt=1.0, description='Chance that a region of either side goes missing.'
    )


class TrainingConfig(Section):
    """All settings of a run."""

    seed: int = Field(0, ge=0, description='Seed of initialisation, order and augmentation.')
    epochs: int = Field(36, ge=1, description='Passes over the training pairs.')
    batch_size: int = Field(8, ge=1, description='Pairs per optimiser step.')
    optimizer: Literal['adamw', 'muon'] = Field(
        'muon', description='Muon for matrices and AdamW for the rest, or AdamW for all.'
    )
    learning_rate: float = Field(4e-3, gt=0.0, description='Peak rate.')
    weight_decay: float = Field(1e-4, ge=0.0, description='Decoupled weight decay.')
    warmup_fraction: float = Field(
        0.05, ge=0.0, lt=1.0, description='Share of all steps with a rising rate; then cosine.'
    )
    clip_norm: float = Field(1.0, gt=0.0, description='Largest gradient norm.')
    patience: int = Field(8, ge=1, description='Epochs without a lower validation loss.')
    validation_fraction: float = Field(
        0.1, gt=0.0, lt=1.0, description='Share of plans (not pairs) held back.'
    )
    match_threshold: float = Field(
        0.2, ge=0.0, lt=1.0, description='Probability that counts as a match in validation.'
    )
    loss: LossConfig = LossConfig()
    augmentation: AugmentationConfig = AugmentationConfig()
    network: NetworkConfig = InvariantConfig()


_PAPER_LOSS = {'loss.match': 1.0, 'loss.topology': 0.25, 'loss.spatial': 0.5}  # chosen
PRESETS: dict[str, dict[str, Any]] = {
    # Section V-A of the paper; it does not state an augmentation.
    'paper': {'network.kind': 'paper', **_PAPER_LOSS},
    # The paper's backbone and its first comparison: no edges, no penalties.
    'superglue': {'network.kind': 'paper', 'network.edge_mapping': 'none'},
    'fpnet': {'network.kind': 'invariant'},
}


def parse_training_config(overrides: dict[str, Any], preset: str = 'fpnet') -> TrainingConfig:
    """
    Return a preset changed by dotted ``overrides``, for example ``{'network.width': 64}``.

    Raises
    ------
    ConfigError
        If a key is unknown or a value out of range.
    """
    tree: dict[str, Any] = {}
    set_dotted(tree, PRESETS[preset] | overrides)
    try:
        return TrainingConfig.model_validate(tree)
    except ValidationError as error:
        first = error.errors()[0]
        key = '.'.join(str(part) for part in first['loc']) or '(top level)'
        raise ConfigError(
            f'training setting {key}: {first["msg"]} (got {first["input"]!r})'
        ) from None
