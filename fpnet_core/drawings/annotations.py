# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Scale stated by a drawing's annotations: dimensions, a scale bar or a ratio such as 1:100.

A single number is not sufficient; see :mod:`fpnet_core.drawings.votes`.
"""

from __future__ import annotations

from collections.abc import Sequence
import math

import numpy as np

from fpnet_core.drawings.dimensions import DrawnLines, dimension_votes
from fpnet_core.drawings.formats.doors import DOOR_WIDTHS_M
from fpnet_core.drawings.lengths import ratios
from fpnet_core.drawings.scale_bars import bar_votes
from fpnet_core.drawings.types import BUILDING_M, Drawing, DrawingScale, ScaleSource
from fpnet_core.drawings.votes import Consensus, Prior, Vote, VoteKind, most_likely

_MAX_LABELS = 600  # numerical: labels that are evaluated
_PICTURE_PX = 1.0  # numerical: error of line ends in an image
# Chosen, not measured:
_RATIO_ERROR = 0.005  # relative, of paper that was printed and scanned
_DOOR_M, _DOOR_SPREAD = 0.9, 0.2  # median width of doors, and the spread of its logarithm
_MIN_DOORS = 3
_SOURCES = {
    VoteKind.DIMENSION: ScaleSource.DIMENSIONS,
    VoteKind.BAR: ScaleSource.SCALE_BAR,
    VoteKind.AREA: ScaleSource.ROOM_TEXTS,
    VoteKind.SIZE: ScaleSource.ROOM_TEXTS,
    VoteKind.PAPER: ScaleSource.PAPER,
}


def annotated_scale(drawing: Drawing, votes: Sequence[Vote] | None = None) -> DrawingScale | None:
    """
    Return the scale stated by a drawing's annotations; None without consistent ones.

    Sources are dimension texts with their lines, scale bars with their ticks, and a ratio such as
    1:100 if the format has a paper size and doors confirm it. They must not contradict each other.
    ``votes`` are those of :func:`label_votes`.
    """
    prior = None
    if len(drawing.door_px) >= _MIN_DOORS:
        door_px = float(np.median(drawing.door_px))
        prior = Prior(math.log(_DOOR_M / door_px), _DOOR_SPREAD)
    found = most_likely(label_votes(drawing) if votes is None else votes, prior)
    return None if found is None or not is_building(drawing, found) else scale_of(found)


def label_votes(drawing: Drawing) -> list[Vote]:
    """Return the votes of a drawing's texts that do not depend on its rooms."""
    if not drawing.labels:
        return []
    labels = drawing.labels[:_MAX_LABELS]
    votes = _paper_votes(drawing)
    strokes, error_px = drawing.strokes, 0.0
    if strokes is None or not len(strokes.ends):
        from fpnet_core.drawings.picture_lines import picture_lines  # loads OpenCV

        strokes, error_px = picture_lines(drawing.pixels, labels), _PICTURE_PX
    if len(strokes.ends):
        lines = DrawnLines.of(strokes)
        votes += dimension_votes(labels, lines, error_px) + bar_votes(labels, lines, error_px)
    return votes


def is_building(drawing: Drawing, found: Consensus) -> bool:
    """Return whether the size of a drawing and its doors are plausible for a building."""
    size_m = max(drawing.pixels.shape[:2]) * found.resolution_m
    if not BUILDING_M[0] < size_m < BUILDING_M[1]:
        return False
    if len(drawing.door_px) < _MIN_DOORS:
        return True
    door_m = float(np.median(drawing.door_px)) * found.resolution_m
    return DOOR_WIDTHS_M[0] < door_m < DOOR_WIDTHS_M[1]


def _paper_votes(drawing: Drawing) -> list[Vote]:
    """Return a vote per printed ratio if the paper size is known."""
    if drawing.paper_m is None:
        return []
    return [
        Vote(math.log(drawing.paper_m * ratio), VoteKind.PAPER, ratio, number, '', _RATIO_ERROR)
        for number, label in enumerate(drawing.labels[:_MAX_LABELS])
        for ratio in ratios(label.text)
    ]


def scale_of(found: Consensus) -> DrawingScale:
    """Return the consensus of texts as a drawing's scale."""
    kind = max(found.counts, key=lambda kind: found.counts[kind])
    return DrawingScale(found.resolution_m, found.low_m, found.high_m, _SOURCES[kind], found.why)
