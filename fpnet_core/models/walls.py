# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
The network that reads walls from pictures: a small U-Net (Ronneberger et al., 2015).

Letters: ``B`` pictures of ``H`` by ``W`` pixels, ``K`` classes, ``C`` channels. Half resolution
is the finest that is convolved; the last layer answers for each pixel of a block of two by two.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
import torch
from torch import Tensor, nn
from torch.nn.utils.fusion import fuse_conv_bn_eval

from fpnet_core.errors import WeightsError
from fpnet_core.io.pixel_classes import CLASSES
from fpnet_core.io.weights import Weights, check_shapes, network_of, read_weights

WALLS_SCHEMA = 1
"""Given: grows when the picture that the network sees is made otherwise."""

WALLS_NAME = 'walls.safetensors'

STRIDE = 32
"""Given: pictures are padded to a multiple of so many pixels."""

PIXELS_PER_ANSWER = 4
"""Given: logits of a class lie side by side for so many pixels: a block of two by two."""

_MIDDLE, _SPREAD = 0.75, 0.25  # numerical: of brightness in [0, 1]: paper is bright


@dataclass(frozen=True)
class WallNetworkConfig:
    """Channels at 1/2, 1/4, 1/8, 1/16 and 1/32 of the picture, and blocks at the last four."""

    widths: tuple[int, ...] = (16, 32, 48, 64, 96)
    down_blocks: tuple[int, ...] = (1, 2, 2, 3)
    up_blocks: tuple[int, ...] = (1, 1, 1)


class ConvNorm(nn.Module):
    """A convolution, normalised over the batch, and then rectified where ``is_active``."""

    def __init__(
        self, inputs: int, outputs: int, side: int = 3, stride: int = 1, is_active: bool = True
    ) -> None:
        super().__init__()
        self.conv = nn.Conv2d(inputs, outputs, side, stride, side // 2, bias=False)
        self.norm = nn.BatchNorm2d(outputs)
        self.is_active = is_active

    def forward(self, x: Tensor) -> Tensor:
        """Return (B, outputs, H / stride, W / stride) of ``x (B, inputs, H, W)``."""
        x = self.norm(self.conv(x))
        return nn.functional.relu(x, inplace=True) if self.is_active else x

    def fused(self) -> nn.Sequential:
        """Return the same function in one convolution, for inference."""
        conv = fuse_conv_bn_eval(self.conv, self.norm)
        return (
            nn.Sequential(conv, nn.ReLU(inplace=True)) if self.is_active else nn.Sequential(conv)
        )


class ResidualBlock(nn.Module):
    """Two convolutions around which the input is added (He et al., 2016)."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.first = ConvNorm(width, width)
        self.second = ConvNorm(width, width, is_active=False)

    def forward(self, x: Tensor) -> Tensor:
        """Return the same shape as ``x (B, C, H, W)``."""
        return torch.relu(x + self.second(self.first(x)))


def _blocks(width: int, count: int) -> nn.Sequential:
    return nn.Sequential(*(ResidualBlock(width) for _ in range(count)))


class WallNetwork(nn.Module):
    """Classes of pixels from a picture."""

    def __init__(self, config: WallNetworkConfig) -> None:
        super().__init__()
        widths = config.widths
        self.stem = ConvNorm(3, widths[0], stride=2)
        self.down = nn.ModuleList(
            nn.Sequential(ConvNorm(a, b, stride=2), _blocks(b, count))
            for a, b, count in zip(widths, widths[1:], config.down_blocks, strict=False)
        )
        inner = list(zip(widths[1:], widths[2:], config.up_blocks, strict=False))[::-1]
        self.lift = nn.ModuleList(ConvNorm(b, a, 1) for a, b, _ in inner)
        self.up = nn.ModuleList(_blocks(a, count) for a, _, count in inner)
        self.last_lift = ConvNorm(widths[1], widths[0], 1)
        self.last = ConvNorm(widths[0], widths[0])
        self.head = nn.Conv2d(widths[0], PIXELS_PER_ANSWER * len(CLASSES), 3, padding=1)
        self.shuffle = nn.PixelShuffle(2)

    def forward(self, picture: Tensor) -> Tensor:
        """Return logits (B, K, H, W) of ``picture (B, 3, H, W)`` in [0, 1], H and W whole."""
        finest = x = self.stem((picture - _MIDDLE) / _SPREAD)
        seen = []
        for layer in self.down:
            x = layer(x)
            seen.append(x)
        x = seen.pop()
        for lift, blocks in zip(self.lift, self.up, strict=True):
            x = blocks(seen.pop() + _doubled(lift(x)))
        x = self.last(finest + _doubled(self.last_lift(x)))
        return torch.as_tensor(self.shuffle(self.head(x)))

    def fused(self) -> WallNetwork:
        """Fold the normalisation into the convolutions, in place; for inference only."""
        self.eval()
        for module in list(self.modules()):
            for name, child in module.named_children():
                if isinstance(child, ConvNorm):
                    setattr(module, name, child.fused())
        return self


def _doubled(x: Tensor) -> Tensor:
    return nn.functional.interpolate(x, scale_factor=2.0, mode='nearest')


def classify(network: nn.Module, pixels: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return the probability (K, H, W) of each class for ``pixels (H, W, 3)``."""
    height, width = pixels.shape[:2]
    margin = ((0, -height % STRIDE), (0, -width % STRIDE), (0, 0))
    padded = np.pad(pixels, margin, mode='edge')
    picture = torch.from_numpy(padded).permute(2, 0, 1)[None].float().div_(255.0)
    with torch.inference_mode():
        chance = network(picture.contiguous(memory_format=torch.channels_last)).softmax(dim=1)
    return np.asarray(chance[0, :, :height, :width].contiguous().numpy(), np.float32)


def wall_network_of(weights: Weights) -> WallNetwork:
    """
    Return the network that a checkpoint holds, ready for inference.

    Raises
    ------
    WeightsError
        If it is for other classes, or its tensors do not fit.
    """
    stored = network_of(weights, 'wall', {'classes': CLASSES}, 'train-walls')
    layers = {key: tuple(value) for key, value in stored.items() if key != 'classes'}
    try:
        config = WallNetworkConfig(**layers)
    except TypeError:
        raise WeightsError(
            'wall weights: the manifest describes another network; train again with '
            'fpnet train-walls'
        ) from None
    network = WallNetwork(config)
    expected = {key: tuple(value.shape) for key, value in network.state_dict().items()}
    check_shapes('walls', weights.tensors, expected)
    network.load_state_dict({key: torch.from_numpy(v) for key, v in weights.tensors.items()})
    network.requires_grad_(False)
    return network.fused().to(memory_format=torch.channels_last)  # type: ignore[call-overload,no-any-return]


@cache
def packaged_wall_network() -> WallNetwork:
    """Return the packaged network, read once."""
    return wall_network_of(read_weights(None, WALLS_SCHEMA, WALLS_NAME))
