# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A small storey in pixels, and the sheets it may be drawn on."""

import cv2
import numpy as np

PX_PER_M = 20.0
"""Pixels per metre of :func:`storey`."""

ROOM_COUNT = 13
"""Twelve rooms along a corridor."""

WHITE = 255
_WIDTHS = (4.0, 5.0, 3.5, 6.0, 4.5, 5.0)


def storey(wall=0, paper=WHITE, thickness=4, fill=None):
    """
    Two rows of six rooms along a corridor of 2 m, doors of 0.9 m.

    Returns the picture (H, W, 3) and the room labels (H, W).
    """
    depth, corridor = 5.0, 2.0
    total = sum(_WIDTHS)
    shape = (round((2 * depth + corridor) * PX_PER_M) + 81, round(total * PX_PER_M) + 81)
    picture = np.full((*shape, 3), paper, np.uint8)
    labels = np.zeros(shape, np.int32)
    lines, gaps = [], []
    left = 40
    for k, width in enumerate(_WIDTHS):
        right = left + round(width * PX_PER_M)
        for row, (top, low) in enumerate(((0.0, depth), (depth + corridor, 2 * depth + corridor))):
            y0, y1 = (40 + round(y * PX_PER_M) for y in (top, low))
            labels[y0:y1, left:right] = 1 + 2 * k + row
            lines.append(((left, y0), (right, y1)))
            y = y1 if row == 0 else y0
            gaps.append(((left + 30, y), (left + 30 + round(0.9 * PX_PER_M), y)))
        left = right
    y0, y1 = (40 + round(y * PX_PER_M) for y in (depth, depth + corridor))
    labels[y0:y1, 40:left] = ROOM_COUNT
    lines.append(((40, y0), (left, y1)))
    if fill is not None:
        for room in range(1, ROOM_COUNT + 1):
            picture[labels == room] = fill[room % len(fill)]
    for first, last in lines:
        cv2.rectangle(picture, first, last, _colour(wall), thickness)
    for (x0, y), (x1, _) in gaps:
        beside = picture[y + thickness + 2, x0].tolist()
        cv2.rectangle(picture, (x0, y - thickness), (x1, y + thickness), beside, -1)
    return picture, labels


def _colour(level):
    return (level,) * 3 if np.isscalar(level) else tuple(level)


def sheet(picture, labels, margin=120):
    """Return both on a sheet with a frame, a title block, a title and a north arrow."""
    pad = ((margin, margin + 160), (margin, margin))
    big = np.pad(picture, (*pad, (0, 0)), constant_values=WHITE)
    truth = np.pad(labels, pad)
    height, width = truth.shape
    cv2.rectangle(big, (20, 20), (width - 20, height - 20), (0, 0, 0), 3)
    top, left = height - 150, width - 420
    cv2.rectangle(big, (left, top), (width - 20, height - 20), (0, 0, 0), 2)
    for k, text in enumerate(('Town hall', 'Storey 1', '1:100')):
        y = top + 43 * k
        cv2.line(big, (left, y), (width - 20, y), (0, 0, 0), 2)
        cv2.putText(big, text, (left + 120, y + 32), cv2.FONT_HERSHEY_SIMPLEX, 0.9, (0, 0, 0), 2)
    cv2.line(big, (left + 110, top), (left + 110, height - 20), (0, 0, 0), 2)
    cv2.putText(big, 'GROUND FLOOR', (60, 90), cv2.FONT_HERSHEY_SIMPLEX, 1.4, (0, 0, 0), 3)
    cv2.circle(big, (120, height - 90), 40, (0, 0, 0), 2)
    cv2.arrowedLine(big, (120, height - 60), (120, height - 125), (0, 0, 0), 3)
    return big, truth
