# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Hyperparameters of the matching networks, stored in a checkpoint's manifest."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Literal, Self

from pydantic import Field, TypeAdapter, ValidationError, model_validator

from fpnet_core.config import Section
from fpnet_core.errors import WeightsError
from fpnet_core.io.weights import Weights


class EdgeMapping(StrEnum):
    """Input of the edge function phi of equation (7)."""

    NONE = 'none'
    CONNECTIVITY = 'connectivity'
    DISTANCE = 'distance'
    PROXIMITY = 'proximity'


class _AttentionConfig(Section):
    """Sizes common to both networks: the heads divide a descriptor evenly."""

    width: int
    heads: int

    @model_validator(mode='after')
    def _heads_divide_width(self) -> Self:
        if self.width % self.heads:
            raise ValueError(f'width {self.width} is not a multiple of heads {self.heads}')
        return self


class PaperConfig(_AttentionConfig):
    """Sizes of the paper's network; the defaults are the paper's (section V-A, setup)."""

    kind: Literal['paper'] = Field('paper', description="The paper's network.")
    width: int = Field(26, ge=2, le=512, description='Length of a node descriptor.')
    heads: int = Field(2, ge=1, le=16, description='Attention heads.')
    blocks: int = Field(9, ge=1, le=32, description='Blocks of one self and one cross layer.')
    position_widths: tuple[int, ...] = Field(
        (6, 13, 26), description='Hidden widths of the position encoder.'
    )
    edge_mapping: EdgeMapping = Field(
        EdgeMapping.DISTANCE, description='Edge function multiplied into self-attention.'
    )
    sinkhorn_iterations: int = Field(20, ge=1, le=200, description='Row and column sweeps.')


class InvariantConfig(_AttentionConfig):
    """Sizes of the invariant network of the ``fpnet`` preset."""

    kind: Literal['invariant'] = Field('invariant', description='Invariant network.')
    width: int = Field(64, ge=2, le=512, description='Length of a node descriptor.')
    heads: int = Field(4, ge=1, le=16, description='Attention heads.')
    layers: int = Field(6, ge=1, le=32, description='Layers of joint attention.')


NetworkConfig = Annotated[PaperConfig | InvariantConfig, Field(discriminator='kind')]
"""Either network; ``kind`` selects it."""

_CONFIG: TypeAdapter[NetworkConfig] = TypeAdapter(NetworkConfig)


def network_config(weights: Weights) -> NetworkConfig:
    """Return the configuration of the network in ``weights``; WeightsError if it is unknown."""
    try:
        return _CONFIG.validate_python(weights.manifest['network'])
    except ValidationError as error:
        first = error.errors()[0]
        raise WeightsError(
            f'weights manifest: network.{".".join(map(str, first["loc"][1:]))}: {first["msg"]}'
        ) from None
