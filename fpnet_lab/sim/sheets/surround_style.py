# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Components around the building of a varied sheet, and effects on its picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

Framing = Literal['as laid out', 'cropped', 'small on a large sheet', 'padded']

# Chosen, not measured; shares of varied sheets with a component:
AROUND: dict[str, float] = {
    'contours': 0.16,
    'lawn': 0.12,
    'road': 0.12,
    'parking': 0.12,
    'trees': 0.2,
    'hedge': 0.1,
    'neighbours': 0.18,
    'terrace': 0.2,
    'pool': 0.07,
    'court': 0.6,
    'boundary': 0.14,
    'eaves': 0.1,
    'dimensions': 0.3,
    'near frame': 0.15,
}
OVER: dict[str, float] = {
    'axes': 0.14,
    'section': 0.12,
    'leaders': 0.1,
}
BLOCKS: dict[str, float] = {
    'title block': 0.25,
    'table': 0.2,
    'legend': 0.2,
    'key plan': 0.16,
    'photo': 0.14,
    'gradient': 0.07,
    'elevation': 0.16,
    'paragraph': 0.25,
    'cloud': 0.08,
    'stamp': 0.1,
    'code': 0.07,
    'scale bar': 0.25,
    'north': 0.22,
    'logo': 0.16,
    'page number': 0.12,
    'headline': 0.2,
    'scribble': 0.1,
    'frame': 0.2,
}
STRIPS: dict[str, float] = {
    'toolbar': 0.09,
    'banner': 0.12,
    'footer': 0.12,
    'column': 0.12,
}
EFFECTS: dict[str, float] = {
    'grid': 0.07,
    'tint': 0.22,
    'watermark': 0.08,
    'stain': 0.05,
    'holes': 0.05,
    'highlighter': 0.07,
    'stamp over': 0.06,
    'broken ink': 0.07,
    'faint': 0.07,
    'wobble': 0.12,
    'turn': 0.14,
    'skew': 0.07,
    'shrink': 0.28,
    'halftone': 0.04,
    'moire': 0.05,
    'blocks': 0.2,
    'yellowed': 0.07,
}
_FRAMINGS: dict[Framing, float] = {
    'as laid out': 0.45,
    'cropped': 0.2,
    'small on a large sheet': 0.12,
    'padded': 0.23,
}
_BARE_SHARE = 0.12  # share of varied sheets without any of these parts


@dataclass(frozen=True)
class SurroundStyle:
    """
    Selection of the components around a sheet's building.

    Parameters
    ----------
    parts : names of :data:`AROUND`, :data:`OVER`, :data:`BLOCKS` and :data:`STRIPS`
    effects : names of :data:`EFFECTS`
    framing : framing of the building in the picture
    seed : seed of positions, sizes and colours
    """

    parts: frozenset[str]
    effects: frozenset[str]
    framing: Framing
    seed: int


def draw_surround_style(rng: np.random.Generator) -> SurroundStyle:
    """Sample a combination of components."""
    richness = float(rng.uniform(0.0, 2.0)) * float(rng.random() > _BARE_SHARE)
    parts = {
        name
        for shares in (AROUND, OVER, BLOCKS, STRIPS)
        for name, share in shares.items()
        if rng.random() < richness * share
    }
    effects = {name for name, share in EFFECTS.items() if rng.random() < share}
    names = list(_FRAMINGS)
    framing = names[int(rng.choice(len(names), p=list(_FRAMINGS.values())))]
    return SurroundStyle(frozenset(parts), frozenset(effects), framing, int(rng.integers(1 << 31)))
