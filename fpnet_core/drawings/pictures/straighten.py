# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
A slight turn of a scan and the perspective of a photograph, undone by walls or by the sheet.

Walls run in two directions square to each other. A camera that was held at an angle bends them
by a turn of the camera, three angles; those that make most of the lines run along the sides of
the picture are undone, if many more lines do then. Where walls are drawn by hand and do not tell,
the edges of the sheet do, if walls are as square to each other then.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.pixels import cut_from, growth_at, map_points

Array = NDArray[np.float64]
Levels = NDArray[np.uint8]

_LOOK_PX = 1100  # numerical: the longer side of the picture that lines are looked for in
# Chosen, not measured:
_LINE_SHARE = 0.02  # of that side: shorter lines are letters
_MIN_LINES = 30
_FOCAL = 1.05  # physical: of a phone's main camera, in longer sides of its picture
_MAX_TURN_RAD = np.radians(12.0)  # of a sheet laid askew; more was drawn like that
_LEAST_TURN_RAD = np.radians(0.12)  # numerical: half a pixel at the end of a wall of 250
_MAX_TILT_RAD = np.radians(32.0)
_LIMITS = np.array([1.0, _MAX_TILT_RAD, _MAX_TILT_RAD, 0.12])  # turn, tilts [rad], skew
_SIDES = 4  # given: of a sheet
_TILT_STEPS = 9  # numerical
_TURNS = np.linspace(-np.pi / 4.0, np.pi / 4.0, 91)  # numerical
# Numerical: how far off a line still counts.
_COARSE_RAD, _FINE_RAD = np.radians(2.0), np.radians(0.35)
# Chosen, not measured:
_GAIN = 1.25  # so much more line must run along the sides for a tilt to be believed
_LEAST_SHARE = 0.35  # of all lines run along the sides once a turn is undone
_LEAST_TILT_SHARE = 0.5  # and once a tilt is: curved walls never run along them
_EDGE_SHARE = 0.15  # of the longer side: shorter edges of a sheet are torn or cut corners
_EDGE_BEND = 0.01  # of a sheet's outline may lie so far off its edges
_RIM_SHARE = 0.01  # of the longer side: edges so near to the picture's are not the sheet's
_SQUARE_SHARE = 0.8  # of a sheet's edges run along the sides once its tilt is undone
_ALLOWED = 0.9  # of the walls' share in two directions stays: or the shape is no sheet
_MAX_GROWTH = 1.6  # a picture grows by no more than this


def find_straightening(levels: Levels, outline: Array | None = None) -> Array:
    """
    Return the homography (3, 3) from pixels to those of the picture straightened.

    Parameters
    ----------
    levels : (H, W)
        Contrast of lines, as of :func:`fpnet_core.drawings.pictures.binarization.contrast`.
    outline : (V, 2)
        Of the sheet that was photographed, x and y in pixels; None where none is seen.

    Returns
    -------
    The identity where nothing is to be undone or the lines do not tell.
    """
    factor = min(1.0, _LOOK_PX / max(levels.shape))
    lines = _lines(levels, factor)
    size = np.array(levels.shape[::-1]) * factor
    angles = _best_angles(lines, size) if len(lines) >= _MIN_LINES else None
    if angles is None and outline is not None and len(lines):
        angles = _angles_of_sheet(_edges(factor * outline, size), lines, size)
    if angles is None:
        return np.eye(3)
    S = np.diag([factor, factor, 1.0])
    H: Array = np.linalg.inv(S) @ _camera_turn(angles, size) @ S
    return _placed(H, levels.shape)


def straightened_size(H: Array, shape: tuple[int, ...]) -> tuple[int, int]:
    """Return width and height of the straightened picture of one of ``shape``."""
    corners = map_points(H, _corners(shape))
    width, height = np.ceil(corners.max(axis=0)).astype(int) + 1
    limit = (_MAX_GROWTH * np.array(shape[1::-1])).astype(int)
    return int(min(width, limit[0])), int(min(height, limit[1]))


def _lines(levels: Levels, factor: float) -> Array:
    """Return straight lines (N, 2, 2) in pixels of the picture reduced by ``factor``."""
    small = cv2.resize(levels, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    detector = cv2.createLineSegmentDetector(cv2.LSD_REFINE_NONE)
    found = detector.detect(np.asarray(255 - small, dtype=np.uint8))[0]
    if found is None:
        return np.zeros((0, 2, 2))
    ends = np.asarray(found, dtype=np.float64).reshape(-1, 2, 2)
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    return np.asarray(ends[length > _LINE_SHARE * max(small.shape)])


def _best_angles(lines: Array, size: Array) -> Array | None:
    """Return turn, both tilts [rad] and skew that are worth undoing; None for none."""
    turned = _searched(lines, size, with_tilt=False)
    tilted = _searched(lines, size, with_tilt=True)
    as_is, share, best = (
        _aligned(angles, lines, size, _FINE_RAD) for angles in (np.zeros(4), turned, tilted)
    )
    if best > _GAIN * share and best > _LEAST_TILT_SHARE:
        return _kept_askew(tilted)
    is_slight = _LEAST_TURN_RAD < abs(turned[0]) < _MAX_TURN_RAD
    return turned if is_slight and share > max(_LEAST_SHARE, as_is) else None


def _edges(outline: Array, size: Array) -> Array:
    """Return the long straight edges (N, 2, 2) of a sheet's outline (V, 2) within the picture."""
    bend = _EDGE_BEND * cv2.arcLength(outline.astype(np.float32), True)
    corners = cv2.approxPolyDP(outline.astype(np.float32), bend, True).reshape(-1, 2)
    edges = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1).astype(np.float64)
    rim = _RIM_SHARE * size.max()
    at_rim = ((edges < rim) | (edges > size - rim)).all(axis=1).any(axis=1)
    return np.asarray(edges[~at_rim & (_length(edges) > _EDGE_SHARE * size.max())])


def _angles_of_sheet(edges: Array, lines: Array, size: Array) -> Array | None:
    """Return the angles (4,) that make a sheet's edges (N, 2, 2) square, if walls allow it."""
    if len(edges) != _SIDES:
        return None
    tilted = _searched(edges, size, with_tilt=True)
    if _aligned(tilted, edges, size, _FINE_RAD) < _SQUARE_SHARE:
        return None
    before, after = (_most_aligned(a, lines, size) for a in (np.zeros(4), tilted))
    return _kept_askew(tilted) if after > _ALLOWED * before else None


def _most_aligned(angles: Array, lines: Array, size: Array) -> float:
    """Return the largest share of lines that run along two directions square to each other."""
    off = _directions(angles, lines, size)
    return float(_shares(off[:, None] + _TURNS, _length(lines)[:, None], _COARSE_RAD).max())


def _kept_askew(angles: Array) -> Array:
    """Return the angles (4,) without a turn so large that the building was drawn with it."""
    is_askew = abs(angles[0]) > _MAX_TURN_RAD
    return np.where([is_askew, False, False, False], 0.0, angles)


def _searched(lines: Array, size: Array, with_tilt: bool) -> Array:
    """Return the angles (4,) under which most of the lines run along the sides."""
    tilts = np.linspace(-_MAX_TILT_RAD, _MAX_TILT_RAD, _TILT_STEPS) if with_tilt else np.zeros(1)
    best, most = np.zeros(4), -1.0
    for across in tilts:
        for along in tilts:
            off = _directions(np.array([0.0, across, along, 0.0]), lines, size)
            share = _shares(off[:, None] + _TURNS, _length(lines)[:, None], _COARSE_RAD)
            if share.max() > most:
                best, most = (
                    np.array([_TURNS[share.argmax()], across, along, 0.0]),
                    float(share.max()),
                )
    for width in (_COARSE_RAD, _FINE_RAD):
        best = _refined(best, lines, size, width, with_tilt)
    return best


def _refined(start: Array, lines: Array, size: Array, width: float, with_tilt: bool) -> Array:
    free = np.array([1.0, with_tilt, with_tilt, with_tilt])
    steps = np.vstack([start, start + 0.02 * np.eye(4)[free > 0.0]])[:, free > 0.0]

    def loss(values: Array) -> float:
        angles = start.copy()
        angles[free > 0.0] = values
        if (np.abs(angles) > _LIMITS).any():
            return 0.0
        return -_aligned(angles, lines, size, width)

    from scipy.optimize import minimize  # slow to load, and few sheets lie askew

    found = minimize(
        loss, steps[0], method='Nelder-Mead', options={'initial_simplex': steps, 'maxfev': 300}
    )
    best = start.copy()
    best[free > 0.0] = found.x
    return best


def _aligned(angles: Array, lines: Array, size: Array, width: float) -> float:
    """Return the share of the lines' length that runs along the sides."""
    off = _directions(angles, lines, size)
    return float(_shares(off[:, None], _length(lines)[:, None], width)[0])


def _shares(off: Array, length: Array, width: float) -> Array:
    """Return for each column of angles (N, K) the share of lines near a right angle (K,)."""
    off = (off + np.pi / 4.0) % (np.pi / 2.0) - np.pi / 4.0
    return np.asarray((np.exp(-np.square(off / width)) * length).sum(axis=0) / length.sum())


def _length(lines: Array) -> Array:
    return np.asarray(np.hypot(*(lines[:, 1] - lines[:, 0]).T))


def _directions(angles: Array, lines: Array, size: Array) -> Array:
    """Return the directions [rad] of lines once the camera's turn is undone."""
    ends = map_points(_camera_turn(angles, size), lines)
    along = ends[:, 1] - ends[:, 0]
    return np.arctan2(along[:, 1], along[:, 0])


def _camera_turn(angles: Array, size: Array) -> Array:
    """
    Return the homography (3, 3) of a camera turned in its plane, across and along it [rad].

    The fourth of ``angles`` is a skew: what is left where the focal length is another one.
    """
    focal = _FOCAL * float(size.max())
    K = np.array([[focal, 0.0, size[0] / 2.0], [0.0, focal, size[1] / 2.0], [0.0, 0.0, 1.0]])
    c, s, skew = np.cos(angles), np.sin(angles), angles[3]
    R_turn = np.array([[c[0], -s[0], 0.0], [s[0], c[0], 0.0], [0.0, 0.0, 1.0]])
    R_across = np.array([[c[1], 0.0, s[1]], [0.0, 1.0, 0.0], [-s[1], 0.0, c[1]]])
    R_along = np.array([[1.0, 0.0, 0.0], [0.0, c[2], -s[2]], [0.0, s[2], c[2]]])
    skewed = np.array([[1.0, skew, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(K @ R_turn @ skewed @ R_across @ R_along @ np.linalg.inv(K))


def _placed(H: Array, shape: tuple[int, ...]) -> Array:
    """Return ``H`` scaled to keep the size in the picture's middle, and moved into view."""
    growth = growth_at(H, np.array([shape[1] / 2.0, shape[0] / 2.0]))
    H = np.diag([1.0 / growth, 1.0 / growth, 1.0]) @ H
    left, top = map_points(H, _corners(shape)).min(axis=0)
    placed: Array = cut_from(left, top) @ H
    return np.asarray(placed / placed[2, 2])


def _corners(shape: tuple[int, ...]) -> Array:
    right, bottom = shape[1] - 1.0, shape[0] - 1.0
    return np.array([[0.0, 0.0], [right, 0.0], [right, bottom], [0.0, bottom]])
