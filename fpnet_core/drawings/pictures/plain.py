# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a histogram reads: pictures of a few grey levels with nothing on them but a building."""

from __future__ import annotations

import numpy as np

from fpnet_core.config import SegmentationConfig
from fpnet_core.drawings.pictures.found import NOMINAL_M, Found, likelihood, rooms_of
from fpnet_core.drawings.pictures.plausible import FEATURES, features
from fpnet_core.drawings.pictures.sheet import find_building
from fpnet_core.drawings.pictures.tones import (
    Levels,
    brightness,
    colourfulness,
    commonest_levels,
)
from fpnet_core.drawings.stated import SaidScale
from fpnet_core.drawings.types import Box, ReadOptions
from fpnet_core.errors import MapFormatError
from fpnet_core.io.images import interpret
from fpnet_core.raster.pixels import cut_from
from fpnet_core.types import OCCUPIED

# Chosen, not measured:
_PLAIN_ODDS = 10.0  # before its rooms are looked at: clean pictures mostly mean what they show
_MAX_PLAIN_PX = 6_000_000  # larger pictures are sheets
_MAX_DRAWN_PX = 3_000_000  # and so are larger ones without a level that means unknown
_LEVELS_SHARE = 0.92  # of a clean picture has one of these
_WHITE, _UNKNOWN_SHARE = 240, 0.1  # darker levels over so much of a picture are no lines
_COLOURED = 24  # levels between channels that a scanner's noise does not make
_COLOUR_SHARE = 2e-3  # of a picture has colour
_SPECKS = 1.0  # per room: letters, furniture
_SAME_SCALE = 0.2  # in its logarithm, within which a picture means the same


def best_plain(
    pictures: list[Levels], options: ReadOptions, config: SegmentationConfig, said: SaidScale
) -> Found | None:
    """Return the reading of the picture that looks most like a building; None of sheets."""
    found = (plain_reading(picture, options, config, said) for picture in pictures)
    known = [plain for plain in found if plain is not None]
    return max(known, key=lambda plain: plain.probability, default=None)


def plain_reading(
    pixels: Levels, options: ReadOptions, config: SegmentationConfig, said: SaidScale
) -> Found | None:
    """Return what :func:`fpnet_core.io.images.interpret` reads, of a picture without a sheet."""
    left, top, right, bottom = options.crop or (0, 0, *pixels.shape[1::-1])
    grey = _grey(pixels[top:bottom, left:right])
    if grey is None:
        return None
    H = cut_from(left, top)
    known_m = said.cell_m(H, grey.shape)
    cell_m = known_m or NOMINAL_M
    try:
        cells = interpret(grey, cell_m)
        sheet = find_building(cells == OCCUPIED)
    except MapFormatError:
        return None
    if len(sheet.boxes) > 1 or any(not _is_within(d.box, sheet.boxes[0]) for d in sheet.dropped):
        return None
    segmentation, factor = rooms_of(cells, cell_m, config, known_m and 1.0)
    if known_m is None and abs(np.log(factor)) > _SAME_SCALE:
        cells = interpret(grey, NOMINAL_M * factor)
        segmentation, _ = rooms_of(cells, NOMINAL_M * factor, config)
    how = 'a clean drawing or robot map'
    chance = likelihood(segmentation, _PLAIN_ODDS)
    return Found(cells, H, segmentation, chance, how, said, _PLAIN_ODDS)


def is_lettered(plain: Found, picture: Levels) -> bool:
    """Tell whether more than a building is drawn: texts come with lines that cross rooms."""
    specks = features(plain.segmentation)[FEATURES.index('specks')]
    return bool(specks > np.log1p(_SPECKS)) and not _is_map(commonest_levels(brightness(picture)))


def _grey(pixels: Levels) -> Levels | None:
    """
    Return the grey levels (H, W) of a picture that a histogram explains; None of any other.

    Such pictures are grey, of modest size, and of a few levels: neither paper nor a photograph.
    """
    if pixels.shape[0] * pixels.shape[1] > _MAX_PLAIN_PX:
        return None
    if (colourfulness(pixels) > _COLOURED).mean() > _COLOUR_SHARE:
        return None
    grey = brightness(pixels)
    shares = commonest_levels(grey)
    is_small = grey.size <= _MAX_DRAWN_PX or _is_map(shares)
    return grey if is_small and sum(share for _, share in shares) > _LEVELS_SHARE else None


def _is_map(shares: list[tuple[int, float]]) -> bool:
    """Tell whether a level is as common as that for unknown is on robots' maps."""
    return any(share > _UNKNOWN_SHARE for level, share in shares if level < _WHITE)


def _is_within(inner: Box, outer: Box) -> bool:
    starts = inner[0] >= outer[0] and inner[1] >= outer[1]
    return starts and inner[2] <= outer[2] and inner[3] <= outer[3]
