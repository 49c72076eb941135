# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One tick of the localizer, to and from a file: what reports and pictures are made from."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fpnet_core.errors import FpnetError
from fpnet_core.geometry import SE2, Affine2D, Placement, Placements
from fpnet_core.io.arrays import read_arrays
from fpnet_core.types import (
    Cause,
    CauseKind,
    GridMap,
    LocalizerOutput,
    MatchResult,
    PlanScale,
    Portal,
    Region,
    RegionLabel,
    Segmentation,
    Status,
    Submap,
)

Arrays = dict[str, NDArray[Any]]

_NO_ROOM = -1  # stands for the unseen side of a portal
_FIGURES = ('area_m2', 'observed_fraction', 'frontier_fraction', 'confidence')


def write_output(path: Path | str, output: LocalizerOutput) -> None:
    """
    Write a tick as compressed arrays (.npz), creating the folder.

    The region graph is left out: it is rebuilt from the segmentation.
    """
    arrays: Arrays = {
        'status': np.array(output.status.value),
        'stamp_ns': np.array(output.stamp_ns),
        'probability': np.array(output.probability),
        'why': np.array(output.reason),
        'is_mirrored': np.array(output.is_mirrored),
        'causes': np.array(
            [(cause.kind.value, cause.evidence, cause.next) for cause in output.causes],
            dtype=np.str_,
        ).reshape(-1, 3),
        'timing_names': np.array(list(output.timings_ms), dtype=np.str_),
        'timings_ms': np.array(list(output.timings_ms.values()), dtype=np.float64),
        **_estimates_to_arrays(output.estimates),
    }
    if output.A_plan_odom is not None:
        arrays['A_plan_odom'] = output.A_plan_odom.matrix
    if output.cov is not None:
        arrays['cov'] = output.cov
    if output.scale is not None:
        arrays |= _scale_to_arrays(output.scale)
    if output.submap is not None:
        arrays |= _submap_to_arrays(output.submap)
    if output.segmentation is not None:
        arrays |= _segmentation_to_arrays(output.segmentation)
    if output.match is not None:
        arrays |= {
            'pairs': output.match.pairs,
            'scores': output.match.scores,
            'assignment': output.match.probability,
        }
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open('wb') as file:
        np.savez_compressed(file, **arrays)  # type: ignore[arg-type]


def read_output(path: Path | str) -> LocalizerOutput:
    """
    Read a tick; its region graph is None.

    Raises
    ------
    FpnetError
        If the file is missing, damaged, or not one of :func:`write_output`.
    """
    try:
        return _output_from_arrays(read_arrays(Path(path)))
    except (OSError, KeyError, ValueError, TypeError, IndexError) as error:
        raise FpnetError(
            f'{path} is not a written tick: {error}; run the localizer again'
        ) from None


def _output_from_arrays(arrays: Arrays) -> LocalizerOutput:
    A_plan_odom = arrays.get('A_plan_odom')
    submap = _submap_from_arrays(arrays) if 'cells' in arrays else None
    return LocalizerOutput(
        stamp_ns=int(arrays['stamp_ns']),
        status=Status(str(arrays['status'])),
        A_plan_odom=None if A_plan_odom is None else Affine2D.from_matrix(A_plan_odom),
        cov=arrays.get('cov'),
        probability=float(arrays['probability']),
        estimates=_estimates_from_arrays(arrays),
        match=MatchResult(arrays['pairs'], arrays['scores'], arrays['assignment'])
        if 'pairs' in arrays
        else None,
        segmentation=_segmentation_from_arrays(arrays) if 'labels' in arrays else None,
        submap=submap,
        timings_ms=dict(
            zip(arrays['timing_names'].tolist(), arrays['timings_ms'].tolist(), strict=True)
        ),
        scale=_scale_from_arrays(arrays) if 'scale_stretch' in arrays else None,
        # Files of older versions have none of these.
        reason=str(arrays.get('why', '')),
        is_mirrored=bool(arrays.get('is_mirrored', False)),
        causes=tuple(
            Cause(CauseKind(kind), evidence, following)
            for kind, evidence, following in arrays.get('causes', np.zeros((0, 3))).tolist()
        ),
    )


def _scale_to_arrays(scale: PlanScale) -> Arrays:
    return {
        'scale_stretch': scale.stretch,
        'scale_sigma': np.array(scale.sigma),
        'scale_is_locked': np.array(scale.is_locked),
    }


def _scale_from_arrays(arrays: Arrays) -> PlanScale:
    return PlanScale(
        arrays['scale_stretch'], float(arrays['scale_sigma']), bool(arrays['scale_is_locked'])
    )


def _estimates_to_arrays(estimates: Placements) -> Arrays:
    return {
        'estimate_A_plan_submap': estimates.matrix,
        'estimate_score': estimates.score,
        'estimate_cov': estimates.cov,
        'estimate_probability': estimates.probability,
    }


def _estimates_from_arrays(arrays: Arrays) -> Placements:
    scores = arrays['estimate_score']
    columns = (
        map(Affine2D.from_matrix, arrays['estimate_A_plan_submap']),
        map(float, scores),
        arrays['estimate_cov'],
        # Files of older versions have none.
        map(float, arrays.get('estimate_probability', np.full(len(scores), np.nan))),
    )
    return Placements.of(Placement(*column) for column in zip(*columns, strict=True))


def _submap_to_arrays(submap: Submap) -> Arrays:
    return {
        **_grid_to_arrays('', submap.grid),
        'lintel': submap.lintel,
        'path_xy': submap.path_xy,
        'T_odom_submap': submap.T_odom_submap.matrix,
        'submap_stamp_ns': np.array(submap.stamp_ns),
        'submap_id': np.array(submap.id),
    }


def _submap_from_arrays(arrays: Arrays) -> Submap:
    return Submap(
        _grid_from_arrays('', arrays),
        arrays['lintel'],
        arrays['path_xy'],
        SE2.from_matrix(arrays['T_odom_submap']),
        int(arrays['submap_stamp_ns']),
        int(arrays['submap_id']),
    )


def _grid_to_arrays(prefix: str, grid: GridMap) -> Arrays:
    return {
        f'{prefix}cells': grid.cells,
        f'{prefix}resolution': np.array(grid.resolution),
        f'{prefix}T_frame_grid': grid.T_frame_grid.matrix,
        f'{prefix}frame': np.array(grid.frame),
    }


def _grid_from_arrays(prefix: str, arrays: Arrays) -> GridMap:
    return GridMap(
        arrays[f'{prefix}cells'],
        float(arrays[f'{prefix}resolution']),
        SE2.from_matrix(arrays[f'{prefix}T_frame_grid']),
        str(arrays[f'{prefix}frame']),
    )


def _segmentation_to_arrays(segmentation: Segmentation) -> Arrays:
    """Store polygons end to end, as they have different lengths."""
    regions, portals = segmentation.regions, segmentation.portals
    rooms = [[_NO_ROOM if room is None else room for room in p.rooms] for p in portals]
    return {
        **_grid_to_arrays('segmented_', segmentation.grid),
        'labels': segmentation.labels,
        'reason': np.array(segmentation.reason),
        'region_label': np.array([r.label.value for r in regions], dtype=np.str_),
        'region_vertices': np.concatenate([np.zeros((0, 2)), *(r.polygon for r in regions)]),
        'region_ends': np.cumsum([len(r.polygon) for r in regions], dtype=np.int64),
        'region_centroid': np.array([r.centroid for r in regions]).reshape(-1, 2),
        'region_figures': np.array(
            [[getattr(r, name) for name in _FIGURES] for r in regions], dtype=np.float64
        ).reshape(-1, len(_FIGURES)),
        'portal_door': np.array([p.door for p in portals], dtype=np.int64),
        'portal_rooms': np.array(rooms, dtype=np.int64).reshape(-1, 2),
        'portal_ends': np.array([p.ends for p in portals]).reshape(-1, 2, 2),
        'portal_has_lintel': np.array([p.has_lintel for p in portals], dtype=np.bool_),
    }


def _named(figures: NDArray[np.float64]) -> dict[str, Any]:
    return dict(zip(_FIGURES, map(float, figures), strict=True))


def _segmentation_from_arrays(arrays: Arrays) -> Segmentation:
    ends = arrays['region_ends']
    polygons = np.split(arrays['region_vertices'], ends[:-1]) if len(ends) else []
    regions = tuple(
        Region(index, RegionLabel(str(label)), polygon, centroid, **_named(figures))
        for index, (label, polygon, centroid, figures) in enumerate(
            zip(
                arrays['region_label'],
                polygons,
                arrays['region_centroid'],
                arrays['region_figures'],
                strict=True,
            )
        )
    )
    portals = tuple(
        Portal(int(door), (int(a), None if b == _NO_ROOM else int(b)), line, bool(has_lintel))
        for door, (a, b), line, has_lintel in zip(
            arrays['portal_door'],
            arrays['portal_rooms'],
            arrays['portal_ends'],
            arrays['portal_has_lintel'],
            strict=True,
        )
    )
    return Segmentation(
        _grid_from_arrays('segmented_', arrays),
        arrays['labels'],
        regions,
        portals,
        str(arrays['reason']),
    )
