# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Maps prepared for matching: segmentation, region graph and evidence."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import time

import numpy as np
from numpy.typing import NDArray

from fpnet_core.config import FpnetConfig
from fpnet_core.errors import MapFormatError
from fpnet_core.graphs import build_region_graph
from fpnet_core.pose import (
    PreparedMap,
    map_evidence,
)
from fpnet_core.raster.pieces import pieces_of
from fpnet_core.segmentation import SubmapSegmenter, segment_floorplan
from fpnet_core.types import (
    FREE,
    GridMap,
    Segmentation,
    Submap,
)

RobotXY = NDArray[np.float64] | None
"""Position of the robot in the submap, ``(2,)`` [m]; None without one."""


class StageTimer:
    """Collects the duration of named stages in milliseconds."""

    def __init__(self) -> None:
        self.timings_ms: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time the enclosed block under ``name``."""
        start = time.perf_counter()
        yield
        elapsed = 1e3 * (time.perf_counter() - start)
        self.timings_ms[name] = self.timings_ms.get(name, 0.0) + elapsed


def prepare_plan(
    grid: GridMap, config: FpnetConfig, segmentation: Segmentation | None = None
) -> PreparedMap:
    """
    Return a floorplan's segmentation (computed unless given), graph and evidence.

    Raises
    ------
    MapFormatError
        If the drawing contains no room.
    """
    segmentation = segmentation or segment_floorplan(grid, config.segmentation)
    if not segmentation.rooms:
        raise MapFormatError(
            f'the floorplan contains no room ({segmentation.reason}); check that free space is '
            'drawn light, walls dark, and that the resolution is in metres per cell'
        )
    return prepared_plan(segmentation)


def prepared_plan(segmentation: Segmentation) -> PreparedMap:
    """Return graph and evidence of a segmented plan; only its rooms count as free space."""
    return PreparedMap(
        segmentation,
        build_region_graph(segmentation, 'plan'),
        map_evidence(segmentation.grid, interior_of(segmentation)),
    )


def interior_of(segmentation: Segmentation) -> NDArray[np.bool_]:
    """Return rooms (H, W) and free cells connected to one: openings, slivers outside rooms."""
    free = segmentation.grid.cells == FREE
    components, figures = pieces_of(free, connectivity=4)
    touched = np.zeros(len(figures), dtype=bool)
    touched[components[segmentation.labels > 0]] = True
    touched[0] = False
    return np.asarray((segmentation.labels > 0) | touched[components])


def prepare_submap(
    submap: Submap, segmenter: SubmapSegmenter, timer: StageTimer
) -> tuple[PreparedMap, SubmapSegmenter]:
    """
    Segment a submap and derive its graph and evidence; it may contain no region.

    ``segmenter`` segments only the parts that changed since its last submap; the returned one is
    for the next submap.
    """
    with timer.stage('segment'):
        segmentation, segmenter = segmenter.update(submap)
    with timer.stage('graph'):
        graph = build_region_graph(segmentation, 'submap')
    with timer.stage('evidence'):
        evidence = map_evidence(submap.grid)
    return PreparedMap(segmentation, graph, evidence), segmenter
