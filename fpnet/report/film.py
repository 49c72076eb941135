# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Animation of a run: the submap grows, and moves onto the floorplan."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

from matplotlib.colors import to_rgb
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from fpnet.report.moments import SHOWN_PLACEMENTS
from fpnet.report.record import RunRecord
from fpnet.report.sheets import Box, PictureSheet, fitted
from fpnet.viz.colours import ERROR_COLOURS, LIDAR_COLOUR, PLACEMENT_COLOURS
from fpnet.viz.segmentation import PALE, painted, partner_colours
from fpnet.viz.strip import STATUS_COLOURS
from fpnet_core.errors import FpnetError
from fpnet_core.geometry import Affine2D, rotation
from fpnet_core.raster.morphology import grown
from fpnet_core.raster.pixels import column_to_xy
from fpnet_core.raster.rays import cells_at
from fpnet_core.types import OCCUPIED, UNKNOWN, GridMap, LocalizerOutput, Segmentation, Status

# Chosen, not measured:
_SIZE = (880, 500)  # width and height
_PLAN_BOX, _SUBMAP_BOX = Box(14, 48, 540, 438), Box(580, 48, 286, 438)
_FRAME_MS, _HOLD_MS, _END_MS = 110, 700, 2500
_STEPS = 60  # numerical: updates that are drawn of a long run
_FLIGHT = 16  # frames of the submap's motion onto the floorplan
_PALETTE = 255  # numerical: colours of the file
_NEARLY_WHITE = 245  # lighter palette colours, averaged with smooth edges, become white
_TEXT = (40, 40, 40)
_WALL, _TRAIL = (
    tuple(round(255 * part) for part in to_rgb(c)) for c in (LIDAR_COLOUR, ERROR_COLOURS[0])
)
_FAINT = 0.35  # opacity of walls at runners-up and, once localized, of the whole submap
_LINE_PX = 3
_STATUS_PX = 250  # offset from the title of the floorplan


def write_film(path: Path, record: RunRecord) -> None:
    """
    Write a run as an animated GIF; its folder is created.

    The left side shows the floorplan with the walls of the submap at the best placements, the
    right side the submap in the colours of its matched rooms. When the robot is first localized,
    the submap moves to its placement.

    Raises
    ------
    FpnetError
        If no update of the run has a submap.
    """
    shown = [each for each in record.outputs if each.segmentation is not None]
    if not shown:
        raise FpnetError(f'{path}: no submap to show: too little was observed')
    frames, durations = zip(*_frames(_Film(record, shown), shown), strict=True)
    palette = _common_palette(frames)
    images = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    path.parent.mkdir(parents=True, exist_ok=True)
    images[0].save(
        path, format='GIF', save_all=True, append_images=images[1:], duration=list(durations),
        loop=0, optimize=True,
    )  # fmt: skip


class _Film:
    """Renderer of frames; holds what all frames share."""

    def __init__(self, record: RunRecord, shown: list[LocalizerOutput]) -> None:
        self.record = record
        grid = record.plan.grid
        corners = [region.polygon for region in record.plan.rooms]
        drawn = np.concatenate(corners) if corners else grid.rc_to_xy(np.argwhere(grid.cells == 0))
        self.A_px_plan = fitted(drawn, _PLAN_BOX, grid.T_frame_grid)
        self.A_px_odom = fitted(_seen(shown[-1]), _SUBMAP_BOX)
        self.background = self._background(record.plan)

    def _background(self, plan: Segmentation) -> PictureSheet:
        sheet = PictureSheet.blank(_SIZE)
        picture = painted(plan, shades=PALE)
        A = self.A_px_plan @ column_to_xy(plan.grid.T_frame_grid, plan.grid.resolution)
        sheet.picture(picture, np.ones(plan.grid.shape), A, _PLAN_BOX)
        sheet.text((_PLAN_BOX.x, 14), 'floorplan', _TEXT)
        sheet.text((_SUBMAP_BOX.x, 14), 'submap of the robot', _TEXT)
        return sheet

    def picture(self, output: LocalizerOutput, flown: float | None = None) -> Image.Image:
        """Return the frame of an update; ``flown`` in [0, 1] is the submap's progress."""
        sheet = self.background.copy()
        assert output.submap is not None  # only such updates are shown
        A_px_submap = self.A_px_odom @ output.submap.T_odom_submap
        self._submap(sheet, output, A_px_submap, 1.0)
        sheet.arrow(*self._robot(output, A_px_submap), _TEXT)
        if flown is None:
            self._placements(sheet, output)
        elif output.A_plan_odom is not None:
            A_end = self.A_px_plan @ output.A_plan_odom @ output.submap.T_odom_submap
            self._submap(sheet, output, on_the_way(A_px_submap, A_end, flown), 0.75)
        self._status(sheet, output)
        return sheet.image()

    def _submap(
        self, sheet: PictureSheet, output: LocalizerOutput, A: Affine2D, opacity: float
    ) -> None:
        sub = output.segmentation
        assert sub is not None  # only such updates are shown
        image = painted(sub, partner_colours(sub, output.match))
        known = (sub.grid.cells != UNKNOWN) * opacity
        cells = column_to_xy(sub.grid.T_frame_grid, sub.grid.resolution)
        sheet.picture(image, known, A @ cells)

    def _placements(self, sheet: PictureSheet, output: LocalizerOutput) -> None:
        """Draw the accepted placement with path and robot, or else the best placements."""
        submap = output.submap
        assert submap is not None  # only such updates are shown
        if output.A_plan_odom is not None:
            A = self.A_px_plan @ output.A_plan_odom @ submap.T_odom_submap
            if output.estimates:
                A_whole = self.A_px_plan @ output.estimates[0].A_plan_submap
                self._walls(sheet, output, A_whole, _WALL, _FAINT)
            self._near(sheet, output, A)
            so_far = self.record.published.stamps_ns <= output.stamp_ns
            for piece in _pieces(self.record.published.xy[so_far]):
                sheet.line(self.A_px_plan.apply(piece), _TRAIL, _LINE_PX)
            sheet.arrow(*self._robot(output, A), _WALL)
            return
        best = output.estimates.take(np.s_[:SHOWN_PLACEMENTS])
        for rank, estimate in reversed(list(enumerate(best))):
            colour = tuple(round(255 * each) for each in to_rgb(PLACEMENT_COLOURS[rank]))
            A = self.A_px_plan @ estimate.A_plan_submap
            self._walls(sheet, output, A, colour, _FAINT if rank else 1.0)
            sheet.arrow(*self._robot(output, A), colour)

    def _walls(
        self,
        sheet: PictureSheet,
        output: LocalizerOutput,
        A: Affine2D,
        colour: tuple[int, ...],
        opacity: float = 1.0,
    ) -> None:
        assert output.submap is not None  # only such updates are shown
        grid = output.submap.grid
        self._cells(sheet, grid, (grid.cells == OCCUPIED) * opacity, A, colour)

    def _near(self, sheet: PictureSheet, output: LocalizerOutput, A: Affine2D) -> None:
        """Draw the walls of the last metres at the pose, which is accepted."""
        assert output.submap is not None  # only such updates are shown
        grid = output.submap.grid
        rows, columns = cells_at(grid.xy_to_rc(output.submap.recent_xy), grid.shape)
        near = np.zeros(grid.shape, np.bool_)
        near[rows, columns] = True
        self._cells(sheet, grid, grown(near, 1).astype(np.float64), A, _WALL)

    @staticmethod
    def _cells(
        sheet: PictureSheet,
        grid: GridMap,
        opacity: NDArray[np.float64],
        A: Affine2D,
        colour: tuple[int, ...],
    ) -> None:
        image = np.broadcast_to(np.array(colour, np.uint8), (*grid.shape, 3))
        cells = column_to_xy(grid.T_frame_grid, grid.resolution)
        sheet.picture(image, opacity, A @ cells, _PLAN_BOX)

    def _robot(
        self, output: LocalizerOutput, A_px_submap: Affine2D
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the robot's position on the frame, and its heading vector."""
        assert output.submap is not None  # only such updates are shown
        place = A_px_submap.apply(output.submap.path_xy[-1])
        yaw = self.record.heading(output) or 0.0
        return place, A_px_submap.linear @ np.array([np.cos(yaw), np.sin(yaw)])

    def _status(self, sheet: PictureSheet, output: LocalizerOutput) -> None:
        seconds = self.record.seconds(np.array([output.stamp_ns]))[0]
        colour = tuple(round(200 * each) for each in to_rgb(STATUS_COLOURS[output.status]))
        text = f'{seconds:.0f} s: {output.status.value}, p {output.probability:.2f}'
        sheet.text((_PLAN_BOX.x + _STATUS_PX, 14), text, colour)


def _frames(film: _Film, shown: list[LocalizerOutput]) -> Iterator[tuple[Image.Image, int]]:
    """Yield frames and their durations [ms]."""
    first_localized = next(
        (k for k, each in enumerate(shown) if each.status is Status.LOCALIZED), None
    )
    for k in _drawn(len(shown), first_localized):
        if k == first_localized:
            yield film.picture(shown[k], 0.0), _HOLD_MS
            for step in range(1, _FLIGHT):
                yield film.picture(shown[k], step / _FLIGHT), _FRAME_MS // 2
            yield film.picture(shown[k], 1.0), _HOLD_MS
        yield film.picture(shown[k]), _END_MS if k == len(shown) - 1 else _FRAME_MS


def _drawn(count: int, first_localized: int | None) -> list[int]:
    """Return the updates to draw: evenly spaced ones, the first localized and the last one."""
    chosen = set(np.linspace(0, count - 1, min(count, _STEPS)).astype(int).tolist())
    return sorted(chosen | ({first_localized} if first_localized is not None else set()))


def on_the_way(A_start: Affine2D, A_end: Affine2D, share: float) -> Affine2D:
    """
    Interpolate between two maps at ``share`` in [0, 1], slow at both ends.

    Rotation and scale are interpolated as such: mixing matrix entries would distort the submap.
    """
    eased = share * share * (3.0 - 2.0 * share)
    between = A_end @ A_start.inv()
    scale, angle = between.scale, between.heading
    bent = A_end.linear - scale * rotation(angle) @ A_start.linear
    linear = scale**eased * rotation(eased * angle) @ A_start.linear + eased * bent
    return Affine2D(linear, (1.0 - eased) * A_start.translation + eased * A_end.translation)


def _seen(output: LocalizerOutput) -> NDArray[np.float64]:
    """Return the known cells of the submap ``(P, 2)``, in ``odom``."""
    assert output.submap is not None  # only such updates are shown
    grid = output.submap.grid
    return output.submap.T_odom_submap.apply(grid.rc_to_xy(np.argwhere(grid.cells != UNKNOWN)))


def _pieces(xy: NDArray[np.float64]) -> Iterator[NDArray[np.float64]]:
    """Yield a path in pieces, split at jumps, where the pose was corrected."""
    jumps = np.flatnonzero(np.linalg.norm(np.diff(xy, axis=0), axis=1) > 1.0) + 1
    for start, end in pairwise([0, *jumps.tolist(), len(xy)]):
        yield xy[start:end]


def _common_palette(frames: tuple[Image.Image, ...]) -> Image.Image:
    """Return one palette for all frames, as changing colours would flicker."""
    some = frames[:: max(1, len(frames) // 6)]
    strip = np.concatenate([np.asarray(frame) for frame in some])
    reduced = Image.fromarray(strip).quantize(_PALETTE, method=Image.Quantize.MEDIANCUT)
    colours = np.array(reduced.getpalette(), np.uint8).reshape(-1, 3)
    colours[colours.min(axis=1) >= _NEARLY_WHITE] = 255
    palette = Image.new('P', (1, 1))
    palette.putpalette(colours.tobytes())
    return palette
