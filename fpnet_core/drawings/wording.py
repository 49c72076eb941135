# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Messages about the parse of a drawing."""

from __future__ import annotations

from fpnet_core.drawings.ocr import NOT_READ, is_unread
from fpnet_core.drawings.types import DrawingScale, Reading, ScaleSource


def said_of(reading: Reading) -> list[str]:
    """Return the summary of a parse, one line each: method, content, scale and notes."""
    segmentation = reading.segmentation
    area_m2 = sum(room.area_m2 for room in segmentation.rooms)
    return [
        f'{reading.drawing.name}: {reading.how}',
        f'{len(segmentation.rooms)} rooms, {area_m2:.0f} m², {len(segmentation.doors)} doors',
        said_of_scale(reading.scale),
        *reading.notes,
        *([NOT_READ] if is_unread(reading) else []),
    ]


def said_of_scale(scale: DrawingScale) -> str:
    """Return a scale as text: metres per pixel, interval, reason or source."""
    text = f'{scale.resolution_m:.4g} m per pixel'
    if scale.low_m < scale.high_m:
        text += f' ({scale.low_m:.3g} to {scale.high_m:.3g})'
    if scale.source is ScaleSource.UNKNOWN:
        return f'scale unknown, assumed {text}'
    return f'{text}, {scale.why or scale.source.value}'
