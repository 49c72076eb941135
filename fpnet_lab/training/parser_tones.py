# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Grey value and colour augmentation of whole batches, stronger than in the simulator.

All shares and ranges are numerical: they cover the variety of real drawings.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn

# Chosen, not measured; shares of images for each augmentation, and its ranges:
_GREY, _MIXED, _CURVED, _FADED, _TINTED, _SHADED = 0.15, 0.2, 0.25, 0.3, 0.2, 0.2
_BLURRED, _NOISY, _COPIED, _INVERTED = 0.25, 0.3, 0.02, 0.05
_BLUR_PX = (0.4, 1.3)
_NOISE = (1.0, 14.0)  # of 255 levels
_SHADE_CELLS = 4


def varied(pixels: Tensor, generator: torch.Generator) -> Tensor:
    """
    Return augmented images (B, 2, 3, H, W) in [0, 1]; both views of a drawing change alike.

    Noise and blur differ between the views, because their scales differ.
    """
    x = _toned(pixels.float() / 255.0, generator)
    flat = _blurred(x.flatten(0, 1), generator)
    sigma = _uniform(generator, x, (len(flat), 1, 1, 1), *_NOISE) / 255.0
    sigma = sigma * _chosen(generator, x, _NOISY, len(flat))
    noise = torch.randn(flat.shape, generator=generator, device=x.device, dtype=x.dtype)
    return (flat + sigma * noise).clamp(0.0, 1.0).view_as(x)


def _toned(x: Tensor, g: torch.Generator) -> Tensor:
    count = len(x)

    def some(share: float) -> Tensor:
        return _chosen(g, x, share, count).unsqueeze(-1)

    def between(low: float, high: float, channels: int = 1) -> Tensor:
        return _uniform(g, x, (count, 1, channels, 1, 1), low, high)

    x = torch.where(some(_GREY) > 0, x.mean(dim=2, keepdim=True), x)
    order = torch.rand(count, 3, generator=g, device=x.device).argsort(dim=1)
    mixed = torch.gather(x, 2, order[:, None, :, None, None].expand_as(x))
    x = torch.where(some(_MIXED) > 0, mixed, x)
    power = (0.45 * torch.randn(count, 1, 1, 1, 1, generator=g, device=x.device)).exp()
    x = torch.where(some(_CURVED) > 0, x.clamp(0.0, 1.0) ** power, x)
    paper, depth = between(0.65, 1.0), between(0.0, 1.0)
    depth = torch.where(some(0.2) > 0, 0.85 * depth, 0.5 * depth)
    ink = depth * paper
    x = torch.where(some(_FADED) > 0, ink + x * (paper - ink), x)
    x = torch.where(some(_TINTED) > 0, x * between(0.75, 1.0, 3), x)
    shape = (count, 1, _SHADE_CELLS, _SHADE_CELLS)
    low = _uniform(g, x, (count, 1, 1, 1), 0.45, 0.95)
    coarse = low + (1.0 - low) * torch.rand(shape, generator=g, device=x.device)
    light = nn.functional.interpolate(coarse, x.shape[-2:], mode='bilinear')[:, None]
    x = torch.where(some(_SHADED) > 0, x * light, x)
    edge = between(0.5, 0.8)
    x = torch.where(some(_COPIED) > 0, (x.mean(dim=2, keepdim=True) > edge).to(x.dtype), x)
    return torch.where(some(_INVERTED) > 0, 1.0 - x, x)


def _blurred(x: Tensor, g: torch.Generator) -> Tensor:
    """Return images (B, 3, H, W); a share of them is blurred, each by its own width."""
    sigma = _uniform(g, x, (len(x), 1), *_BLUR_PX)
    at = torch.arange(-3, 4, device=x.device, dtype=x.dtype)
    row = (-0.5 * (at / sigma) ** 2).exp()
    is_plain = _chosen(g, x, 1.0 - _BLURRED, len(x)).flatten(1)
    row = torch.where(is_plain > 0, (at == 0).to(x.dtype).expand_as(row), row)
    row = (row / row.sum(dim=1, keepdim=True)).repeat_interleave(x.shape[1], 0)
    flat = x.reshape(1, -1, *x.shape[2:])
    flat = nn.functional.pad(flat, (3, 3, 3, 3), mode='replicate')
    flat = nn.functional.conv2d(flat, row[:, None, None, :], groups=len(row))
    flat = nn.functional.conv2d(flat, row[:, None, :, None], groups=len(row))
    return flat.view_as(x)


def _uniform(
    g: torch.Generator, like: Tensor, shape: tuple[int, ...], low: float, high: float
) -> Tensor:
    return low + (high - low) * torch.rand(shape, generator=g, device=like.device)


def _chosen(g: torch.Generator, like: Tensor, share: float, count: int) -> Tensor:
    """Return 1 for a random share of images, else 0: (B, 1, 1, 1)."""
    picks = torch.rand((count, 1, 1, 1), generator=g, device=like.device)
    return (picks < share).to(like.dtype)
