# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Network that parses drawings: a U-Net (Ronneberger et al., 2015) that sees a whole sheet.

Six levels down to 1/64 of the image give every output a receptive field of the whole sheet. The
network runs twice: the first pass sees the sheet; the second sees only the building, at a
resolution that suits its walls, with the first pass's output as additional input channels.

Letters: ``B`` images of ``H`` by ``W`` pixels, ``C`` channels.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import onnx
from onnx import numpy_helper
import torch
from torch import Tensor, nn
from torch.nn.utils.fusion import fuse_conv_bn_eval

from fpnet_core.drawings.parsing.network import CHANNELS, SCALE_BINS
from fpnet_core.io.pixel_classes import CLASSES

OVERLAYS = ('text', 'furniture')
"""Given: overlays of a class, each with its own probability."""

ANSWERS = len(CLASSES) + len(OVERLAYS)
"""Given: logits per pixel: one for each class, and one for each overlay."""

_LEAST_VARIANCE = 1e-6  # numerical: limits the scaling of constant channels
_PER_ANSWER = 4  # given: the last layer has outputs for each pixel of a block of two by two


@dataclass(frozen=True)
class ParserNetworkConfig:
    """Channels at 1/2 to 1/64 of the image, and residual blocks at the last five levels."""

    widths: tuple[int, ...] = (16, 32, 48, 64, 96, 128)
    down_blocks: tuple[int, ...] = (1, 2, 2, 3, 2)
    up_blocks: tuple[int, ...] = (1, 1, 1, 1)


class _ConvNorm(nn.Module):
    """Convolution with batch normalization, and ReLU if ``is_active``."""

    def __init__(
        self, inputs: int, outputs: int, side: int = 3, stride: int = 1, *, is_active: bool = True
    ) -> None:
        super().__init__()
        self.conv = nn.Conv2d(inputs, outputs, side, stride, side // 2, bias=False)
        self.norm: nn.BatchNorm2d | nn.Identity = nn.BatchNorm2d(outputs)
        self.is_active = is_active

    def forward(self, x: Tensor) -> Tensor:
        x = self.norm(self.conv(x))
        return torch.relu(x) if self.is_active else x

    @property
    def batch_norm(self) -> nn.BatchNorm2d:
        """Batch normalization; only before it is folded."""
        assert isinstance(self.norm, nn.BatchNorm2d)
        return self.norm

    def fold(self) -> None:
        """Fold the normalization into the convolution, in place; for inference only."""
        if isinstance(self.norm, nn.BatchNorm2d):
            self.conv = fuse_conv_bn_eval(self.conv, self.norm)
            self.norm = nn.Identity()


class _ResidualBlock(nn.Module):
    """Two convolutions with a skip connection (He et al., 2016)."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.first = _ConvNorm(width, width)
        self.second = _ConvNorm(width, width, is_active=False)

    def forward(self, x: Tensor) -> Tensor:
        return torch.relu(x + self.second(self.first(x)))


def _blocks(width: int, count: int) -> list[nn.Module]:
    return [_ResidualBlock(width) for _ in range(count)]


class ParserNetwork(nn.Module):
    """Pixel classes and scale of an image, from the image and an earlier output."""

    def __init__(self, config: ParserNetworkConfig) -> None:
        super().__init__()
        widths = config.widths
        self.stem = _ConvNorm(CHANNELS, widths[0], stride=2)
        self.down = nn.ModuleList(
            nn.Sequential(_ConvNorm(a, b, stride=2), *_blocks(b, count))
            for a, b, count in zip(widths, widths[1:], config.down_blocks, strict=False)
        )
        inner = list(zip(widths[1:], widths[2:], config.up_blocks, strict=False))[::-1]
        self.lift = nn.ModuleList(_ConvNorm(b, a, 1) for a, b, _ in inner)
        self.up = nn.ModuleList(nn.Sequential(*_blocks(a, count)) for a, _, count in inner)
        self.last_lift = _ConvNorm(widths[1], widths[0], 1)
        self.last = _ConvNorm(widths[0], widths[0])
        self.head = nn.Conv2d(widths[0], _PER_ANSWER * ANSWERS, 3, padding=1)
        self.shuffle = nn.PixelShuffle(2)
        self.scale_head = nn.Conv2d(widths[-1], SCALE_BINS + 1, 1)

    def forward(self, picture: Tensor) -> tuple[Tensor, Tensor]:
        """
        Return logits (B, ANSWERS, H, W), and (B, SCALE_BINS + 1, H / 64, W / 64) of the scale.

        ``picture (B, CHANNELS, H, W)`` is the output of
        :func:`fpnet_core.drawings.parsing.network.channels`; H and W are multiples of 64.
        """
        finest = x = self.stem(picture)
        seen = []
        for layer in self.down:
            x = layer(x)
            seen.append(x)
        x = seen.pop()
        scale = self.scale_head(x)
        for lift, blocks in zip(self.lift, self.up, strict=True):
            x = blocks(seen.pop() + _doubled(lift(x)))
        x = self.last(finest + _doubled(self.last_lift(x)))
        return torch.as_tensor(self.shuffle(self.head(x))), scale


def _doubled(x: Tensor) -> Tensor:
    return nn.functional.interpolate(x, scale_factor=2.0, mode='nearest')


def pooled_scale(scale: Tensor) -> Tensor:
    """Return logits (B, SCALE_BINS) of an image, the weighted mean over its positions."""
    votes, weight = scale[:, :-1].flatten(2), scale[:, -1:].flatten(2).softmax(dim=2)
    return torch.as_tensor((votes * weight).sum(dim=2))


def onnx_bytes(network: ParserNetwork) -> bytes:
    """
    Return a network as ONNX, with weights rounded to half precision for compression.

    The file stores single precision, which every version of OpenCV supports.
    """
    network = network.eval()
    for module in network.modules():
        if isinstance(module, _ConvNorm):
            module.fold()
    state = network.state_dict()
    network.load_state_dict({name: _rounded(value) for name, value in state.items()})
    free = {2: 'height', 3: 'width'}
    names = {'picture': free, 'classes': free, 'scale': {2: 'rows', 3: 'columns'}}
    with TemporaryDirectory() as folder:
        path = Path(folder) / 'parser.onnx'
        torch.onnx.export(
            network,
            (torch.zeros(1, CHANNELS, 128, 192),),
            path,
            dynamo=False,
            opset_version=13,
            input_names=['picture'],
            output_names=['classes', 'scale'],
            dynamic_axes=names,
        )
        return path.read_bytes()


def _rounded(value: Tensor) -> Tensor:
    return value.half().float() if value.is_floating_point() else value


def unweighted(
    state: Mapping[str, Tensor], class_weights: tuple[float, ...], times: float = 1.0
) -> dict[str, Tensor]:
    """
    Return a state with the probabilities of equally weighted pixels.

    ``times`` -1 is the inverse.
    """
    weights = np.ones(ANSWERS)
    weights[: len(CLASSES)] = class_weights
    logs = torch.tensor(times * np.log(weights), dtype=torch.float32)
    each = logs.repeat_interleave(_PER_ANSWER)
    return {k: v - each if k == 'head.bias' else v for k, v in state.items()}


def restored(onnx_data: bytes, network: ParserNetwork, class_weights: tuple[float, ...]) -> None:
    """
    Load the weights of a file by :func:`onnx_bytes` into ``network``, in place.

    The file's normalizations are folded into the convolutions: here each is the identity until
    :func:`settle` estimates its statistics. ``class_weights`` are those of training.
    """
    tensors = {
        each.name: torch.from_numpy(numpy_helper.to_array(each).copy())
        for each in onnx.load_from_string(onnx_data).graph.initializer
    }
    for name, layer in _normalised(network).items():
        bias = tensors.pop(f'{name}.conv.bias')
        ones = torch.ones_like(bias)
        identity = {
            'weight': ones,
            'bias': bias,
            'running_mean': 0.0 * ones,
            'running_var': (1.0 - layer.batch_norm.eps) * ones,
        }
        tensors |= {f'{name}.norm.{part}': value for part, value in identity.items()}
    network.load_state_dict(network.state_dict() | unweighted(tensors, class_weights, -1.0))


@torch.no_grad()
def settle(network: ParserNetwork, pictures: Iterable[Tensor]) -> None:
    """Estimate the statistics of a restored network's normalizations; outputs do not change."""
    layers = _normalised(network)
    counted: dict[str, list[Tensor]] = {name: [] for name in layers}

    def watch(name: str) -> Callable[[nn.Module, Any, Tensor], None]:
        def count(_: nn.Module, __: Any, x: Tensor) -> None:
            each = x.float()
            moments = each.mean((0, 2, 3)), each.square().mean((0, 2, 3))
            counted[name].append(torch.stack(moments))

        return count

    for picture in pictures:  # the generator of pictures may call the network, too
        hooks = [layer.conv.register_forward_hook(watch(name)) for name, layer in layers.items()]
        network.eval()(picture)
        for hook in hooks:
            hook.remove()
    state = network.state_dict()
    for name, told in counted.items():
        mean, square = torch.stack(told).mean(dim=0)
        spread = (square - mean.square()).clamp(min=_LEAST_VARIANCE).sqrt()
        state[f'{name}.conv.weight'] = state[f'{name}.conv.weight'] / spread[:, None, None, None]
        state[f'{name}.norm.weight'] = spread
        state[f'{name}.norm.running_mean'] = mean / spread
        state[f'{name}.norm.bias'] = state[f'{name}.norm.bias'] + mean
    network.load_state_dict(state)


def _normalised(network: ParserNetwork) -> dict[str, _ConvNorm]:
    return {name: each for name, each in network.named_modules() if isinstance(each, _ConvNorm)}
