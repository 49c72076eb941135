# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The updates of a run as plain values for the slider of the page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet.report.pictures import grid_picture
from fpnet.report.record import RunRecord, best_placement_error, position_sigma
from fpnet.viz.segmentation import label_xy, painted, partner_colours, turned
from fpnet_core.geometry import Affine2D
from fpnet_core.geometry.distinct import evenly_drawn
from fpnet_core.localizer.kept import is_brief
from fpnet_core.types import OCCUPIED, UNKNOWN, LocalizerOutput, Segmentation, Status

MAX_MOMENTS = 90
"""
Numerical: more updates are thinned out, so that the file stays small enough to be mailed.
"""

# Chosen, not measured:
SHOWN_PLACEMENTS = 3  # per update; in the film while none is accepted
_SUBMAP_PX = 380
_WALL_SAMPLES, _NEAR_SAMPLES = 700, 500  # numerical: of the whole submap, of the last metres
_PATH_SAMPLES = 400  # numerical
_GATE_95 = (
    5.991  # given: 95 % quantile of the chi-squared distribution with two degrees of freedom
)
_ELLIPSE_CORNERS = 36  # numerical


def moments(record: RunRecord) -> list[dict[str, Any]]:
    """Return the updates of the slider in time order; empty for a run without updates."""
    return [moment(record, record.outputs[index]) for index in shown_updates(record.outputs)]


def changes(record: RunRecord) -> list[dict[str, Any]]:
    """Return all updates at which the status changes, with reasons, including the first one."""
    found: list[dict[str, Any]] = []
    for output in record.outputs:
        if not found or found[-1]['status'] != output.status.value:
            found.append(_state(record, output))
    return found


def _state(record: RunRecord, output: LocalizerOutput) -> dict[str, Any]:
    return {
        'time_s': round(float(record.seconds(np.array([output.stamp_ns]))[0]), 2),
        'status': output.status.value,
        'reason': output.reason,
        'probability': round(output.probability, 3),
    }


def shown_updates(outputs: Sequence[LocalizerOutput]) -> list[int]:
    """Return the indices of the slider's updates, among those that still have their maps."""
    whole = [index for index, output in enumerate(outputs) if not is_brief(output)]
    return [whole[k] for k in chosen_updates([outputs[index].status.value for index in whole])]


def chosen_updates(statuses: Sequence[str]) -> list[int]:
    """Return the indices of evenly spaced updates; status changes have priority."""
    if len(statuses) <= MAX_MOMENTS:
        return list(range(len(statuses)))
    changes = [k for k in range(1, len(statuses)) if statuses[k] != statuses[k - 1]]
    kept = set(changes[: MAX_MOMENTS // 2])
    even = np.linspace(0, len(statuses) - 1, MAX_MOMENTS - len(kept)).astype(int)
    return sorted(kept | set(even.tolist()))


def moment(record: RunRecord, output: LocalizerOutput) -> dict[str, Any]:
    """Return an update as plain values for the page."""
    error_m, heading = best_placement_error(record, output), record.heading(output)
    values: dict[str, Any] = _state(record, output) | {
        'heading': None if heading is None else round(heading, 3),
        'error_m': None if error_m is None else round(error_m, 2),
        'timings_ms': {name: round(ms, 1) for name, ms in output.timings_ms.items()},
        'picture': None,
        'view': [[0, 0], [0, 0]],
        'rooms': 0,
        'doors': 0,
        'explored_m2': 0.0,
        'turn': 0.0,
        'walls': [[], []],
        'near': [[], []],
        'A_plan_near': None,
        'ellipse': [[], []],
        'path': [[], []],
        'labels': [],
        'door_lines': [[], []],
        'matches': [],
        'placements': _placements(output),
    }
    if output.submap is not None:
        path = output.submap.path_xy
        values['explored_m2'] = round(output.submap.free_area_m2, 1)
        values['path'] = _columns(evenly_drawn(path, _PATH_SAMPLES))
        grid = output.submap.grid
        walls = grid.rc_to_xy(np.argwhere(grid.cells == OCCUPIED))
        values['walls'] = _columns(evenly_drawn(walls, _WALL_SAMPLES))
        values['near'] = _columns(evenly_drawn(output.submap.recent_xy, _NEAR_SAMPLES))
        if output.A_plan_odom is not None:
            A_plan_near = output.A_plan_odom @ output.submap.T_odom_submap
            values['A_plan_near'] = _rows(A_plan_near)
        values['ellipse'] = _columns(ellipse(output))
    if output.segmentation is not None:
        values['turn'] = round(_turn(output), 4)
        values |= _regions(record.plan, output.segmentation, output)
    return values


def ellipse(output: LocalizerOutput) -> NDArray[np.float64]:
    """Return the corners ``(C, 2)`` of the position's 95 % ellipse on the plan; else none."""
    if output.covariance is None or output.A_plan_odom is None:
        return np.zeros((0, 2))
    spread = np.linalg.cholesky(output.covariance.cov[:2, :2] * _GATE_95)
    angles = np.linspace(0.0, 2.0 * np.pi, _ELLIPSE_CORNERS)
    middle = output.A_plan_odom.apply(output.covariance.xy_odom)
    corners: NDArray[np.float64] = np.column_stack([np.cos(angles), np.sin(angles)]) @ spread.T
    return middle + corners


def _turn(output: LocalizerOutput) -> float:
    """Return the rotation [rad] from the submap to the plan at the best placement, else 0."""
    return output.estimates[0].A_plan_submap.heading if output.estimates else 0.0


def _rows(A: Affine2D) -> list[list[float]]:
    rows: list[list[float]] = np.round(A.matrix[:2], 5).tolist()
    return rows


def _placements(output: LocalizerOutput) -> list[dict[str, Any]]:
    """Return the best placements: affine map as rows of (2, 3), score and sigma [m]."""
    is_accepted, sigma_m = output.status is Status.LOCALIZED, None
    if output.covariance is not None:
        sigma_m = round(position_sigma(output.covariance.cov), 3)
    return [
        {
            'A_plan_submap': _rows(e.A_plan_submap),
            'score': round(e.score, 3),
            'sigma_m': sigma_m if is_accepted and rank == 0 else None,
            'is_claimed': is_accepted and rank == 0,
        }
        for rank, e in enumerate(output.estimates.take(np.s_[:SHOWN_PLACEMENTS]))
    ]


def _regions(plan: Segmentation, sub: Segmentation, output: LocalizerOutput) -> dict[str, Any]:
    partners = {} if output.match is None else _partners(output)
    doors = {door.id for door in sub.doors}
    colours = partner_colours(sub, output.match)
    grid = turned(sub, _turn(output)).grid
    picture = grid_picture(grid, painted(sub, colours), _SUBMAP_PX)
    seen = grid.rc_to_xy(np.argwhere(grid.cells != UNKNOWN)).reshape(-1, 2)
    view = [seen.min(axis=0), seen.max(axis=0)] if len(seen) else np.zeros((2, 2))
    return {
        'picture': picture.as_layout_image(),
        'view': np.round(view, 1).T.tolist(),
        'rooms': len(sub.rooms),
        'doors': len(sub.doors),
        'labels': [
            [*np.round(label_xy(room), 2).tolist(), f'{room.id}→{partners[room.id][0]}']
            for room in sub.rooms
            if room.id in partners
        ],
        'door_lines': door_lines(sub),
        'matches': [
            {
                'plan_id': plan_id,
                'sub_id': sub_id,
                'label': sub.regions[sub_id].label.value,
                'is_door': sub_id in doors,
                'score': round(score, 3),
                'plan_xy': np.round(plan.regions[plan_id].centroid, 2).tolist(),
                'sub_xy': np.round(sub.regions[sub_id].centroid, 2).tolist(),
            }
            for sub_id, (plan_id, score) in partners.items()
        ],
    }


def _partners(output: LocalizerOutput) -> dict[int, tuple[int, float]]:
    """Return plan region and score by submap region."""
    assert output.match is not None  # checked by the caller
    pairs = zip(output.match.pairs.tolist(), output.match.scores.tolist(), strict=True)
    return {sub_id: (plan_id, score) for (plan_id, sub_id), score in pairs}


def door_lines(segmentation: Segmentation) -> list[list[float | None]]:
    """Return all door lines as x and y columns, separated by None."""
    x: list[float | None] = []
    y: list[float | None] = []
    for portal in segmentation.portals:
        (x0, y0), (x1, y1) = np.round(portal.ends, 2).tolist()
        x += [x0, x1, None]
        y += [y0, y1, None]
    return [x, y]


def _columns(xy: NDArray[np.float64]) -> list[list[float]]:
    columns: list[list[float]] = np.round(xy, 2).T.reshape(2, -1).tolist()
    return columns
