# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Candidate placements from the rasters alone, beside those of the region graph.

They keep competing hypotheses visible that the graph does not propose: it needs doors or rooms to
anchor a candidate, and a map of one or two rooms, or one whose doors were not observed, has hardly
any. This module correlates walls: for the few rotations that align the wall directions of both
maps and the scales to try, all translations are scored at once on a coarse raster. The score is
the share of walls on plan walls minus the share of free space outside or on walls. The best few of
every rotation and scale are aligned with the graph's. This is a narrow correlative search, with a
few dozen rotations and scales instead of thousands.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import fft

from fpnet_core.geometry import Placements, rotation
from fpnet_core.pose.estimate import in_turn
from fpnet_core.pose.evidence import MapEvidence
from fpnet_core.pose.verify import OUTSIDE_FULL_M
from fpnet_core.raster.blocks import block_means
from fpnet_core.raster.morphology import is_peak

Array = NDArray[np.float64]
Image = NDArray[np.float32]

_LONGER_SIDE = 128  # numerical: coarse pixels along the plan's longer side
# Chosen, not measured:
_MARGIN = 0.12  # share of the plan's size by which a map may extend beyond each side
_WALL_SIGMA_M = 0.4  # standard deviation of the wall likelihood
_ON_WALL_COST = 0.7  # cost of free space on a wall
_MAX_WALLS, _MAX_FREE = 1500, 1000  # numerical: samples that represent the map
_PEAKS = 4  # numerical: best translations of each rotation and scale
_PEAK_PIXELS = 5  # numerical: window in which a peak is the maximum

_BINS = 90  # numerical: directions modulo a right angle, one per degree
# Chosen, not measured:
_BIN_SIGMA = 3.0  # scatter of the directions of parallel walls [degrees]
_FACE_M = 0.5  # distance from a wall within which cells contribute to its direction
_FACE_SMOOTHING_CELLS = 1.5  # numerical
_FACE_KERNEL = 5  # numerical: edge of the derivative's kernel [cells]
_TURN_SHARE = 0.3  # further rotations must align walls this well relative to the best
_MAX_TURNS = 3  # numerical: rotations modulo a right angle


@dataclass(frozen=True, eq=False)
class _Field:
    """Spectra of the plan's wall values and costs; ``A_px_xy (2, 3)`` maps metres to pixels."""

    walls: NDArray[np.complex64]
    costs: NDArray[np.complex64]
    shape: tuple[int, int]
    A_px_xy: Array


def search_placements(
    plan: MapEvidence, sub: MapEvidence, factors: Array, max_candidates: int
) -> Placements:
    """
    Return the best placements by coarse correlation, scales taking turns.

    Parameters
    ----------
    plan, sub : evidence of both maps; empty result without walls or free space
    factors : (L,) plan metres per submap metre to try
    max_candidates : limit of the result
    """
    if not (len(plan.walls) and len(sub.walls) and len(sub.free)):
        return Placements.empty()
    field = plan.kept(_field)
    walls, free = _thinned(sub.walls, _MAX_WALLS), _thinned(sub.free, _MAX_FREE)
    found = [_of_turn(field, walls, free, yaw, factors) for yaw in wall_turns(plan, sub)]
    linear, translation, worth = (np.concatenate(part) for part in zip(*found, strict=True))
    placed = Placements(linear, translation)
    return placed.take(in_turn(placed.scale, worth)[:max_candidates])


def _thinned(points: Array, limit: int) -> Array:
    """Return at most ``limit`` of the points, evenly subsampled."""
    return points[:: max(1, -(-len(points) // limit))]


def wall_turns(plan: MapEvidence, sub: MapEvidence) -> Array:
    """
    Return the rotations (4 T,) [rad] that align the submap's wall directions with the plan's.

    Directions are compared modulo a right angle. A rectangular building gives four
    rotations, one with oblique wings more.
    """
    plan_spectrum, sub_spectrum = (fft.rfft(side.kept(_directions)) for side in (plan, sub))
    match = fft.irfft(plan_spectrum * np.conj(sub_spectrum), n=_BINS)
    match -= match.mean()
    is_peak = (match >= np.roll(match, 1)) & (match > np.roll(match, -1))
    is_peak[int(match.argmax())] = True
    turns = np.flatnonzero(is_peak & (match >= _TURN_SHARE * match.max()))
    turns = turns[np.argsort(-match[turns], kind='stable')][:_MAX_TURNS]
    quarters = np.arange(4) * (np.pi / 2.0)
    return np.asarray((turns * (np.pi / 2.0 / _BINS))[:, None] + quarters).ravel()


def _directions(side: MapEvidence) -> Array:
    """Return the amount of wall per direction modulo a right angle, ``(90,)``, smoothed."""
    smooth = cv2.GaussianBlur(side.wall_distance, (0, 0), _FACE_SMOOTHING_CELLS)
    rows, cols = (
        cv2.Sobel(smooth, cv2.CV_32F, *axes, ksize=_FACE_KERNEL) for axes in ((0, 1), (1, 0))
    )
    faces = side.observed & (side.wall_distance > 0.0) & (side.wall_distance < _FACE_M)
    normals = np.stack([rows[faces], cols[faces]], axis=1) @ side.A_rc_xy[:, :2]
    angle = np.mod(np.arctan2(normals[:, 1], normals[:, 0]), np.pi / 2.0)
    bins = (angle * (_BINS / (np.pi / 2.0))).astype(np.int64) % _BINS
    counts = np.bincount(bins, weights=np.square(normals).sum(axis=1), minlength=_BINS)
    distance = np.minimum(np.arange(_BINS), _BINS - np.arange(_BINS)) / _BIN_SIGMA
    kernel = np.exp(-0.5 * np.square(distance))
    spread: Array = fft.irfft(fft.rfft(counts) * fft.rfft(kernel), n=_BINS)
    return spread


def _field(plan: MapEvidence) -> _Field:
    """Return the plan's spectra, padded by a margin in which free space has the highest cost."""
    step = max(1, round(max(plan.wall_distance.shape) / _LONGER_SIDE))
    sigma = max(_WALL_SIGMA_M, 0.5 * step * plan.cell_m)
    near = np.exp(-0.5 * np.square(plan.wall_distance / np.float32(sigma)))
    outside = np.minimum(plan.outside_depth / np.float32(OUTSIDE_FULL_M), np.float32(1.0))
    cost = np.maximum(outside, np.float32(_ON_WALL_COST) * near)
    near, cost = block_means(near, step, 0.0), block_means(cost, step, 1.0)
    margin = [int(np.ceil(_MARGIN * size)) for size in near.shape]
    shape = tuple(
        fft.next_fast_len(size + 2 * extra, real=True)
        for size, extra in zip(near.shape, margin, strict=True)
    )
    pad = [
        (extra, full - size - extra)
        for size, extra, full in zip(near.shape, margin, shape, strict=True)
    ]
    A_px_xy = plan.A_rc_xy / step
    A_px_xy[:, 2] += 0.5 / step - 0.5 + np.array(margin)
    return _Field(
        fft.rfft2(np.pad(near, pad)),
        fft.rfft2(np.pad(cost, pad, constant_values=1.0)),
        (shape[0], shape[1]),
        A_px_xy,
    )


def _of_turn(
    field: _Field, walls: Array, free: Array, yaw: float, factors: Array
) -> tuple[Array, Array, Array]:
    """Return linear parts (K, 2, 2), translations (K, 2) and scores (K,) for one rotation."""
    in_px, R = field.A_px_xy[:, :2], rotation(yaw)
    placed = [points @ (in_px @ R).T for points in (walls, free)]
    low = np.minimum(*(points.min(axis=0) for points in placed))
    extent = np.maximum(*(points.max(axis=0) for points in placed)) - low
    fitting = factors[(factors[:, None] * extent + 2.0 < field.shape).all(axis=1)]
    maps = _correlation(field, placed[0] - low, placed[1] - low, fitting)
    linear, shift, worth = [np.zeros((0, 2, 2))], [np.zeros((0, 2))], [np.zeros(0)]
    for factor, values in zip(fitting, maps, strict=True):
        inside = np.array(field.shape) - np.ceil(factor * extent).astype(np.int64)
        peaks, heights = _peaks(values[: inside[0], : inside[1]])
        linear.append(np.tile(factor * R, (len(peaks), 1, 1)))
        shift.append(peaks - factor * low)
        worth.append(heights)
    translation = (np.concatenate(shift) - field.A_px_xy[:, 2]) @ np.linalg.inv(in_px).T
    return np.concatenate(linear), translation, np.concatenate(worth)


def _correlation(field: _Field, walls: Array, free: Array, factors: Array) -> Image:
    """Return the score (L, H, W) of every shift of the points, which start at pixel 0."""
    if len(factors) == 0:
        return np.zeros((0, *field.shape), dtype=np.float32)
    wall_spectra, free_spectra = (
        np.conj(fft.rfft2(np.array([_raster(f * points, field.shape) for f in factors])))
        for points in (walls, free)
    )
    total = wall_spectra * field.walls - free_spectra * field.costs
    return np.asarray(fft.irfft2(total, s=field.shape), dtype=np.float32)


def _raster(pixels: Array, shape: tuple[int, int]) -> Image:
    """Return the share of the points in each pixel."""
    index = np.rint(pixels).astype(np.int64)
    flat = np.bincount(index[:, 0] * shape[1] + index[:, 1], minlength=shape[0] * shape[1])
    return (flat / len(pixels)).astype(np.float32).reshape(shape)


def _peaks(values: Image) -> tuple[Array, Array]:
    """Return (row, column) (K, 2) and heights (K,) of the highest peaks."""
    values = np.ascontiguousarray(values)
    index = np.flatnonzero(is_peak(values, _PEAK_PIXELS))
    heights = values.ravel()[index].astype(np.float64)
    best = np.argsort(-heights, kind='stable')[:_PEAKS]
    rows, cols = np.unravel_index(index[best], values.shape)
    return np.stack([rows, cols], axis=1).astype(np.float64), heights[best]
