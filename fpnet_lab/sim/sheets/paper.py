# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Effects of scanning or photographing paper: folds, shading, dirt, rotation, perspective."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_lab.sim.sheets.looks import SheetKind

Array = NDArray[np.float64]
Pixels = NDArray[np.uint8]

# Chosen, not measured:
_TURN_RAD = 0.03
_CORNER_SHIFT = (0.015, 0.08)  # shift of the paper's corners as a share of a photo's sides
_TABLE_SHARE = (0.02, 0.12)  # margin around the paper as a share of a photo's sides
_SHADE_CELLS = 5  # grid size of the shading
_FOLD_PX = 3.0
_PHONE_PIXELS = 3500


def weather(pixels: Pixels, kind: SheetKind, rng: np.random.Generator) -> tuple[Pixels, Array]:
    """
    Return a sheet as scanned or photographed, and the homography of its pixels.

    Parameters
    ----------
    pixels : (H, W, 3) as drawn
    kind : scan or phone
    rng : random generator of the effects

    Returns
    -------
    pixels : (H', W', 3)
    H_image_drawn : (3, 3)
        Homography from drawn pixels (x right, y down) to the picture's pixels.
    """
    shown = pixels.astype(np.float32)
    if rng.random() < 0.6:
        _fold(shown, rng)
    if kind is SheetKind.SCAN:
        shown, H = _scan(shown, rng)
    else:
        shown, H = _photograph(shown, rng)
    return np.clip(np.rint(shown), 0, 255).astype(np.uint8), H


def _fold(shown: NDArray[np.float32], rng: np.random.Generator) -> None:
    """Draw creases in place, with one darker side and a light or dark crease line."""
    height, width = shown.shape[:2]
    for _ in range(int(rng.integers(1, 4))):
        axis, at = int(rng.integers(2)), float(rng.uniform(0.2, 0.8))
        along, across = np.arange(height), np.arange(width)
        distance = (across[None] - at * width) if axis == 0 else (along[:, None] - at * height)
        reach = 0.15 * (width, height)[axis]
        shade = 1.0 - rng.uniform(0.02, 0.12) * np.exp(-np.abs(distance) / reach) * (distance > 0)
        crease = 1.0 + rng.uniform(-0.25, 0.12) * np.exp(-((distance / _FOLD_PX) ** 2))
        shown *= (shade * crease).astype(np.float32)[..., None]


def _scan(
    drawn: NDArray[np.float32], rng: np.random.Generator
) -> tuple[NDArray[np.float32], Array]:
    height, width = drawn.shape[:2]
    angle = float(np.clip(rng.normal(0.0, _TURN_RAD / 2.5), -_TURN_RAD, _TURN_RAD))
    H = _turn_about(angle, (width - 1) / 2.0, (height - 1) / 2.0)
    bed = 255.0 if rng.random() < 0.7 else float(rng.uniform(20.0, 120.0))
    turned = cv2.warpPerspective(
        drawn, H, (width, height), flags=cv2.INTER_LINEAR, borderValue=(bed, bed, bed)
    )
    shown = np.asarray(turned, np.float32)
    if rng.random() < 0.5:
        shown = np.repeat(shown.mean(axis=2, keepdims=True), 3, axis=2)
    shown = _blurred(shown, float(rng.uniform(0.0, 1.0)))
    shown = _faded(shown, rng)
    shown *= _shading(shown.shape[:2], float(rng.uniform(0.02, 0.2)), rng)[..., None]
    _speckle(shown, rng)
    noise = rng.standard_normal(shown.shape[:2], np.float32) * np.float32(rng.uniform(1.0, 7.0))
    shown += noise[..., None]
    if rng.random() < 0.1:  # copied in black and white
        grey = shown.mean(axis=2, keepdims=True)
        shown = np.repeat(np.where(grey > rng.uniform(150.0, 200.0), 255.0, 0.0), 3, axis=2)
    return np.asarray(shown, np.float32), H


def _turn_about(angle_rad: float, x: float, y: float) -> Array:
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    there, back = np.eye(3), np.eye(3)
    there[:2, 2], back[:2, 2] = (x, y), (-x, -y)
    return np.asarray(there @ turn @ back)


def _photograph(
    shown: NDArray[np.float32], rng: np.random.Generator
) -> tuple[NDArray[np.float32], Array]:
    height, width = shown.shape[:2]
    margin = rng.uniform(*_TABLE_SHARE, (2, 2)) * [width, height]
    corners = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float64) - 0.5
    reach = float(rng.uniform(*_CORNER_SHIFT))
    there = corners + rng.uniform(-reach, reach, (4, 2)) * [width, height]
    there += margin[0] - there.min(axis=0)
    size = there.max(axis=0) + margin[1]
    shrink = min(1.0, _PHONE_PIXELS / float(size.max()))
    H = cv2.getPerspectiveTransform(
        corners.astype(np.float32), (shrink * there).astype(np.float32)
    )
    columns, rows = np.ceil(shrink * size).astype(int).tolist()
    table = _table((rows, columns), rng)
    mask = cv2.warpPerspective(np.ones((height, width), np.float32), H, (columns, rows))
    paper = cv2.warpPerspective(
        shown, H, (columns, rows), flags=cv2.INTER_AREA, borderMode=cv2.BORDER_REPLICATE
    )
    taken = paper * mask[..., None] + table * (1.0 - mask[..., None])
    taken *= _shading((rows, columns), float(rng.uniform(0.1, 0.4)), rng)[..., None]
    taken *= rng.uniform(0.9, 1.0, 3).astype(np.float32)  # white balance
    taken = _blurred(taken, float(rng.uniform(0.3, 1.3)))
    noise = rng.standard_normal((rows, columns, 3), np.float32)
    return taken + noise * np.float32(rng.uniform(1.0, 6.0)), np.asarray(H, np.float64)


def _table(shape: tuple[int, int], rng: np.random.Generator) -> NDArray[np.float32]:
    """Return the table under the paper (H, W, 3): a colour with grain."""
    grey, tint = rng.uniform(30.0, 200.0), rng.uniform(0.75, 1.0, 3)
    colour = (grey * tint).astype(np.float32)
    rows, columns = shape
    grain = rng.standard_normal((rows // 4 + 1, columns // 40 + 1), np.float32)
    fine = cv2.resize(grain, (columns, rows), interpolation=cv2.INTER_LINEAR)
    return np.asarray(colour + fine[..., None] * np.float32(rng.uniform(2.0, 15.0)), np.float32)


def _shading(
    shape: tuple[int, int], strength: float, rng: np.random.Generator
) -> NDArray[np.float32]:
    """Return a smooth brightness factor (H, W) of at most 1."""
    coarse = rng.uniform(1.0 - strength, 1.0, (_SHADE_CELLS, _SHADE_CELLS)).astype(np.float32)
    rows, columns = shape
    light = cv2.resize(coarse, (columns, rows), interpolation=cv2.INTER_CUBIC)
    return np.asarray(np.minimum(light, 1.0), np.float32)


def _blurred(shown: NDArray[np.float32], sigma_px: float) -> NDArray[np.float32]:
    if sigma_px < 0.2:
        return shown
    return np.asarray(cv2.GaussianBlur(shown, (0, 0), sigma_px), np.float32)


def _faded(shown: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.float32]:
    """Return the sheet with paler ink and darker paper."""
    ink, paper = rng.uniform(0.0, 70.0), rng.uniform(215.0, 255.0)
    return np.asarray(ink + shown * (paper - ink) / 255.0, np.float32)


def _speckle(shown: NDArray[np.float32], rng: np.random.Generator) -> None:
    """Draw dust specks in place."""
    height, width = shown.shape[:2]
    count = int(rng.poisson(float(rng.uniform(0.0, 60.0)) * height * width * 1e-6))
    for x, y, radius, tone in zip(
        rng.integers(width, size=count).tolist(),
        rng.integers(height, size=count).tolist(),
        rng.integers(1, 3, count).tolist(),
        rng.uniform(0.0, 160.0, count).tolist(),
        strict=True,
    ):
        cv2.circle(shown, (x, y), radius, (tone, tone, tone), -1)
