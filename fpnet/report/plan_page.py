# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Page of a floorplan check: segmentation, rooms that look alike, drives, advice."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import plotly.graph_objects as go

from fpnet.plan_check.check import PlanCheck, expected_path_m, room_note
from fpnet.report.charts import add_rooms, equal_axes, show_regions
from fpnet.report.page import write_page
from fpnet.report.pictures import segmentation_picture
from fpnet.viz.plan_check import similarity_colours
from fpnet.viz.segmentation import Colour
from fpnet_core.types import Segmentation


def write_plan_report(path: Path | str, name: str, check: PlanCheck) -> None:
    """Write the check of the floorplan ``name`` as one self-contained HTML file."""
    expected_m = expected_path_m(check.tours)
    segmentation, similarity = check.segmentation, check.similarity
    alike = similarity_colours(segmentation, similarity)
    notes = {room.id: room_note(check, room.id) for room in segmentation.rooms}
    tiles = {
        'rooms': str(len(segmentation.rooms)),
        'doors': str(len(segmentation.doors)),
        'area [m²]': f'{sum(room.area_m2 for room in segmentation.rooms):.0f}',
        'metres per pixel': f'{check.drawn.resolution_m:.4f}',
        'scale factor from doors': f'{check.scale.factor:.2f}',
        'rooms that look alike': str(len(similarity.alone)),
        'even with adjacent rooms': str(len(similarity.with_neighbours)),
        'typical path to a pose [m]': '-' if expected_m is None else f'{expected_m:.1f}',
    }
    rooms = [
        (room.id, f'{room.area_m2:.1f}', notes[room.id])
        for room in segmentation.rooms
        if notes[room.id]
    ]
    write_page(
        Path(path),
        'plan.html.j2',
        {'rooms': _figure(segmentation), 'similar': _figure(segmentation, alike, notes)},
        title=f'Floorplan check: {name}',
        summary='Findings and advice, before a robot drives on this floorplan.',
        tiles=list(tiles.items()),
        advice=check.advice,
        verdict=check.verdict,
        rooms=rooms,
        tours=check.tours,
    )


def _figure(
    segmentation: Segmentation,
    colours: Mapping[int, Colour] | None = None,
    notes: Mapping[int, str] | None = None,
) -> go.Figure:
    """Return the floorplan with its rooms in the given colours, and notes on hover."""
    figure = go.Figure()
    show_regions(figure, segmentation, segmentation_picture(segmentation, colours=colours))
    add_rooms(figure, segmentation, notes)
    equal_axes(figure, segmentation.grid.frame)
    figure.update_layout(showlegend=False)
    return figure
