# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Correction of a scan's rotation and a photograph's perspective by walls or the sheet's edges.

Walls run in two orthogonal directions. The camera rotation that aligns most lines with the image
axes (three angles and a skew) is undone if it aligns many more lines than before. If walls are
drawn by hand and give no result, the edges of the sheet are used, provided that walls stay as
orthogonal as before.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from fpnet_core.raster.morphology import square
from fpnet_core.raster.pixels import cut_from, growth_at, map_points
from fpnet_core.raster.windows import border_of

Array = NDArray[np.float64]
Levels = NDArray[np.uint8]

_DETECTION_PX = 1100  # numerical: longer side of the image for line detection
# Chosen, not measured:
_LINE_SHARE = 0.02  # of that side: shorter lines are letters
_MIN_LINES = 30
_FOCAL = 1.05  # physical: focal length of a phone's main camera over the longer image side
_MAX_TURN_RAD = np.radians(12.0)  # of a skewed sheet; larger angles belong to the drawing
_LEAST_TURN_RAD = np.radians(0.12)  # numerical: half a pixel at the end of a wall of 250 pixels
_MAX_TILT_RAD = np.radians(32.0)
_LIMITS = np.array([1.0, _MAX_TILT_RAD, _MAX_TILT_RAD, 0.12])  # turn, tilts [rad], skew
_SIDES = 4  # given: edges of a sheet
_TILT_STEPS = 9  # numerical
_TURNS = np.linspace(-np.pi / 4.0, np.pi / 4.0, 91)  # numerical
# Numerical: tolerance of aligned lines.
_COARSE_RAD, _FINE_RAD = np.radians(2.0), np.radians(0.35)
# Chosen, not measured:
_GAIN = 1.25  # factor by which a tilt must increase the aligned line length
_LEAST_SHARE = 0.35  # of the line length must be aligned after undoing a rotation
_LEAST_TILT_SHARE = 0.5  # the same after undoing a tilt; curved walls are never aligned
_EDGE_SHARE = 0.15  # of the longer side: shorter edges of a sheet are torn or cut corners
_EDGE_BEND = 0.01  # of the length of a sheet's outline: its deviation from straight edges
_RIM_SHARE = 0.01  # of the longer side: edges this close to the image border are not the sheet's
_SQUARE_SHARE = 0.8  # of a sheet's edges are aligned after undoing its tilt
_ALLOWED = 0.9  # of the walls' aligned share must remain, else the shape is no sheet
_MAX_GROWTH = 1.6  # largest growth of the image's sides
_TABLE_PX = 320  # numerical: longer side of the image for detecting a sheet on a table
_PEN_REACH = 0.03  # of that image: thicker than lines and walls
_BRIGHT_EDGE = 0.35  # of the image border may be as bright as the sheet
_BRIGHTER = 1.3  # smallest brightness of the sheet over that of the table
_SHEET_SHARE, _CONVEX = 0.25, 0.93  # smallest share of the sheet in the image, and in its hull


def find_straightening(grey: Levels) -> Array:
    """
    Return the homography (3, 3) from pixels of ``grey (H, W)`` to those of the straightened image.

    It is the identity if nothing has to be corrected or the lines give no result.
    """
    factor = min(1.0, _DETECTION_PX / max(grey.shape))
    lines = _lines(grey, factor)
    size = np.array(grey.shape[::-1]) * factor
    angles = _best_angles(lines, size) if len(lines) >= _MIN_LINES else None
    if angles is None and len(lines) and (outline := _sheet_outline(grey)) is not None:
        angles = _angles_of_sheet(_edges(factor * outline, size), lines, size)
    if angles is None:
        return np.eye(3)
    S = np.diag([factor, factor, 1.0])
    H: Array = np.linalg.inv(S) @ _camera_turn(angles, size) @ S
    return _placed(H, grey.shape)


def _sheet_outline(grey: Levels) -> Array | None:
    """Return the outline (V, 2), x and y, of a bright convex sheet on a darker table, or None."""
    factor = min(1.0, _TABLE_PX / max(grey.shape))
    small = cv2.resize(grey, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    side = max(3, round(_PEN_REACH * max(small.shape)))
    plain = cv2.morphologyEx(small, cv2.MORPH_CLOSE, square(side))
    _, bright = cv2.threshold(plain, 0, 1, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    if border_of(bright).mean() > _BRIGHT_EDGE or not bright.any() or bright.all():
        return None
    if plain[bright > 0].mean() < _BRIGHTER * plain[bright == 0].mean():
        return None
    contours, _ = cv2.findContours(bright, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    sheet = max(contours, key=cv2.contourArea)
    hull = cv2.convexHull(sheet)
    area = cv2.contourArea(hull)
    if area < _SHEET_SHARE * small.size or cv2.contourArea(sheet) < _CONVEX * area:
        return None
    per_small = np.array(grey.shape[::-1]) / np.array(small.shape[::-1])
    return np.asarray((hull.reshape(-1, 2) + 0.5) * per_small - 0.5, dtype=np.float64)


def straightened_size(H: Array, shape: tuple[int, ...]) -> tuple[int, int]:
    """Return width and height of the straightened image for an image of ``shape``."""
    corners = map_points(H, _corners(shape))
    width, height = np.ceil(corners.max(axis=0)).astype(int) + 1
    limit = (_MAX_GROWTH * np.array(shape[1::-1])).astype(int)
    return int(min(width, limit[0])), int(min(height, limit[1]))


def _lines(grey: Levels, factor: float) -> Array:
    """Return straight lines (N, 2, 2) in pixels of the image reduced by ``factor``."""
    small = cv2.resize(grey, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    found = cv2.createLineSegmentDetector(cv2.LSD_REFINE_NONE).detect(small)[0]
    if found is None:
        return np.zeros((0, 2, 2))
    ends = np.asarray(found, dtype=np.float64).reshape(-1, 2, 2)
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    return np.asarray(ends[length > _LINE_SHARE * max(small.shape)])


def _best_angles(lines: Array, size: Array) -> Array | None:
    """Return rotation, both tilts [rad] and skew to undo; None if there is no clear gain."""
    turned = _searched(lines, size, with_tilt=False)
    tilted = _searched(lines, size, with_tilt=True)
    as_is, share, best = (
        _aligned(angles, lines, size, _FINE_RAD) for angles in (np.zeros(4), turned, tilted)
    )
    if best > _GAIN * share and best > _LEAST_TILT_SHARE:
        return _without_large_turn(tilted)
    is_slight = _LEAST_TURN_RAD < abs(turned[0]) < _MAX_TURN_RAD
    return turned if is_slight and share > max(_LEAST_SHARE, as_is) else None


def _edges(outline: Array, size: Array) -> Array:
    """Return the long straight edges (N, 2, 2) of a sheet's outline (V, 2) inside the image."""
    bend = _EDGE_BEND * cv2.arcLength(outline.astype(np.float32), True)
    corners = cv2.approxPolyDP(outline.astype(np.float32), bend, True).reshape(-1, 2)
    edges = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1).astype(np.float64)
    rim = _RIM_SHARE * size.max()
    at_rim = ((edges < rim) | (edges > size - rim)).all(axis=1).any(axis=1)
    return np.asarray(edges[~at_rim & (_length(edges) > _EDGE_SHARE * size.max())])


def _angles_of_sheet(edges: Array, lines: Array, size: Array) -> Array | None:
    """Return the angles (4,) that align a sheet's edges (N, 2, 2); None if walls contradict."""
    if len(edges) != _SIDES:
        return None
    tilted = _searched(edges, size, with_tilt=True)
    if _aligned(tilted, edges, size, _FINE_RAD) < _SQUARE_SHARE:
        return None
    before, after = (_most_aligned(a, lines, size) for a in (np.zeros(4), tilted))
    return _without_large_turn(tilted) if after > _ALLOWED * before else None


def _most_aligned(angles: Array, lines: Array, size: Array) -> float:
    """Return the largest share of line length along two orthogonal directions."""
    off = _directions(angles, lines, size)
    return float(_shares(off[:, None] + _TURNS, _length(lines)[:, None], _COARSE_RAD).max())


def _without_large_turn(angles: Array) -> Array:
    """Return the angles (4,) with a large rotation set to 0, as the building was drawn with it."""
    is_drawn_turned = abs(angles[0]) > _MAX_TURN_RAD
    return np.where([is_drawn_turned, False, False, False], 0.0, angles)


def _searched(lines: Array, size: Array, with_tilt: bool) -> Array:
    """Return the angles (4,) that align most of the line length with the image axes."""
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

    from scipy.optimize import minimize  # slow to load, and few sheets are skewed

    found = minimize(
        loss, steps[0], method='Nelder-Mead', options={'initial_simplex': steps, 'maxfev': 300}
    )
    best = start.copy()
    best[free > 0.0] = found.x
    return best


def _aligned(angles: Array, lines: Array, size: Array, width: float) -> float:
    """Return the share of line length along the image axes."""
    off = _directions(angles, lines, size)
    return float(_shares(off[:, None], _length(lines)[:, None], width)[0])


def _shares(off: Array, length: Array, width: float) -> Array:
    """Return the share (K,) of lines near a multiple of 90 degrees for ``off (N, K)``."""
    off = (off + np.pi / 4.0) % (np.pi / 2.0) - np.pi / 4.0
    return np.asarray((np.exp(-np.square(off / width)) * length).sum(axis=0) / length.sum())


def _length(lines: Array) -> Array:
    return np.asarray(np.hypot(*(lines[:, 1] - lines[:, 0]).T))


def _directions(angles: Array, lines: Array, size: Array) -> Array:
    """Return the directions [rad] of lines after undoing the camera rotation."""
    ends = map_points(_camera_turn(angles, size), lines)
    along = ends[:, 1] - ends[:, 0]
    return np.arctan2(along[:, 1], along[:, 0])


def _camera_turn(angles: Array, size: Array) -> Array:
    """
    Return the homography (3, 3) of a camera rotated in its plane, across and along it [rad].

    The fourth of ``angles`` is a skew, which compensates for a wrong focal length.
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
    """Return ``H`` scaled to keep the size at the image centre, and shifted into view."""
    growth = growth_at(H, np.array([shape[1] / 2.0, shape[0] / 2.0]))
    H = np.diag([1.0 / growth, 1.0 / growth, 1.0]) @ H
    left, top = map_points(H, _corners(shape)).min(axis=0)
    placed: Array = cut_from(left, top) @ H
    return np.asarray(placed / placed[2, 2])


def _corners(shape: tuple[int, ...]) -> Array:
    right, bottom = shape[1] - 1.0, shape[0] - 1.0
    return np.array([[0.0, 0.0], [right, 0.0], [right, bottom], [0.0, bottom]])
