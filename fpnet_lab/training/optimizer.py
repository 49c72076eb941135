# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Muon for weight matrices, AdamW for everything else, as one optimizer.

Muon (Jordan et al., 2024) replaces the momentum of a matrix by the nearest orthogonal matrix, so
that all of its directions learn equally fast. ``torch.optim.Muon`` updates one matrix at a time in
bfloat16, which a CPU emulates: a step of this small network took 2.4 times as long. Here matrices
of equal shape are orthogonalized together in single precision.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
import math
from typing import Any

import torch
from torch import Tensor, nn

from fpnet_lab.training.config import TrainingConfig

SMALLEST_SIDE = 26
"""
AdamW updates matrices with a shorter side: they are tables rather than linear maps. Chosen.
"""

# Chosen, not measured:
_MOMENTUM = 0.95
_ITERATIONS = 5  # numerical
# Given: odd polynomial a x + b x^3 + c x^5 that drives singular values to about 1 (0.7 to 1.2) in
# five steps; the coefficients are those of torch.optim.Muon.
_A, _B, _C = 3.4445, -4.7750, 2.0315
_ADAMW_RMS = 0.2  # usual size of an AdamW step, so that both share one learning rate


def rate_at(step: int, steps: int, highest: float, warmup: float) -> float:
    """Return the learning rate of a step: linear over a share ``warmup``, then half a cosine."""
    rising = max(1, round(warmup * steps))
    if step < rising:
        return highest * (step + 1) / rising
    done = (step - rising) / max(1, steps - rising)
    return 0.5 * highest * (1.0 + math.cos(math.pi * done))


def make_optimizer(network: nn.Module, config: TrainingConfig) -> torch.optim.Optimizer:
    """Return the optimizer selected by ``config.optimizer`` for all of ``network``."""
    kind = Muon if config.optimizer == 'muon' else torch.optim.AdamW
    return kind(network.parameters(), lr=config.learning_rate, weight_decay=config.weight_decay)


class Muon(torch.optim.AdamW):
    """AdamW that updates matrices along their orthogonalized Nesterov momentum."""

    def __init__(self, params: Iterable[nn.Parameter], lr: float, weight_decay: float) -> None:
        super().__init__(params, lr=lr, weight_decay=weight_decay)

    @torch.no_grad()
    def step(self, closure: Callable[[], Any] | None = None) -> Any:
        """Update every parameter that has a gradient; gradients of matrices are reset."""
        loss = closure() if closure is not None else None
        for group in self.param_groups:
            matrices = [p for p in group['params'] if p.grad is not None and _is_matrix(p)]
            self._step_matrices(matrices, group['lr'], group['weight_decay'])
            for matrix in matrices:
                matrix.grad = None
        super().step()
        return loss

    def _step_matrices(self, matrices: list[nn.Parameter], rate: float, decay: float) -> None:
        by_shape: dict[torch.Size, list[tuple[Tensor, Tensor]]] = {}
        for matrix in matrices:
            assert matrix.grad is not None
            state = self.state[matrix]
            # The base class AdamW expects a step count in every loaded state.
            state.setdefault('step', torch.zeros(())).add_(1.0)
            momentum = state.setdefault('momentum', torch.zeros_like(matrix))
            momentum.lerp_(matrix.grad, 1.0 - _MOMENTUM)
            ahead = torch.lerp(matrix.grad, momentum, _MOMENTUM)
            matrix.mul_(1.0 - rate * decay)
            for block in zip(_blocks(matrix), _blocks(ahead), strict=True):
                by_shape.setdefault(block[0].shape, []).append(block)
        for shape, blocks in by_shape.items():
            directions = orthogonalized(torch.stack([ahead for _, ahead in blocks]))
            size = rate * _ADAMW_RMS * math.sqrt(max(shape))
            for (weights, _), direction in zip(blocks, directions, strict=True):
                weights.sub_(direction, alpha=size)


def orthogonalized(matrices: Tensor) -> Tensor:
    """Return ``(K, A, B)`` with the singular vectors of ``matrices`` and values of about 1."""
    wide = matrices.shape[-2] <= matrices.shape[-1]
    x = matrices if wide else matrices.mT
    x = x / x.norm(dim=(-2, -1), keepdim=True).clamp_min(1e-7)
    for _ in range(_ITERATIONS):
        gram = x @ x.mT
        x = _A * x + (_B * gram + _C * gram @ gram) @ x
    settled: Tensor = x if wide else x.mT
    return settled


def _is_matrix(parameter: Tensor) -> bool:
    return parameter.ndim == 2 and min(parameter.shape) >= SMALLEST_SIDE


def _blocks(matrix: Tensor) -> tuple[Tensor, ...]:
    """Return views of square maps stacked in a tall matrix: queries, keys and values."""
    rows, columns = matrix.shape
    return torch.split(matrix, columns) if rows % columns == 0 else (matrix,)
