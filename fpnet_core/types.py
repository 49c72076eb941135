# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Frozen values passed between the stages; their arrays are checked and read-only. SI units.

Letters: ``P`` points, ``M`` plan regions, ``N`` submap regions, ``R`` regions of either map,
``E`` edges, ``D`` features, ``K`` matches, ``V`` vertices, ``S`` path samples, ``H, W`` raster.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import Enum, StrEnum
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fpnet_core.frozen import freeze_field
from fpnet_core.geometry import SE2, Affine2D, Placements, scale_of
from fpnet_core.matches import MatchResult
from fpnet_core.pose_covariance import PoseCovariance

FREE, OCCUPIED, UNKNOWN = 0, 100, -1
"""Given: cell values of a :class:`GridMap`, as in ``nav_msgs/OccupancyGrid``."""

FEATURE_SCHEMA = 1  # given: the layout of node and edge features; other weights are refused


@dataclass(frozen=True, eq=False)
class GridMap:
    """
    Occupancy raster with its pose in a metric frame.

    Parameters
    ----------
    cells : (H, W) int8
        ``FREE``, ``OCCUPIED`` or ``UNKNOWN``. Row 0 is the lowest y, as in OccupancyGrid; image
        readers flip rows once, in :mod:`fpnet_core.io`.
    resolution : float
        Cell size [m].
    T_frame_grid : SE2
        Pose of the outer corner of cell (0, 0) in ``frame``, yaw included.
    frame : str
        Name of the metric frame: ``plan``, ``odom``, ``submap``.
    """

    cells: NDArray[np.int8]
    resolution: float
    T_frame_grid: SE2 = field(default_factory=SE2.identity)
    frame: str = 'plan'

    def __post_init__(self) -> None:
        """Check cell values and resolution."""
        freeze_field(self, 'cells', np.int8, (None, None))
        if self.cells.size == 0:
            raise ValueError('GridMap.cells: the grid has no cells')
        cells = self.cells
        if not ((cells == FREE) | (cells == OCCUPIED) | (cells == UNKNOWN)).all():
            raise ValueError('GridMap.cells: values must be 0, 100 or -1')
        if not (np.isfinite(self.resolution) and self.resolution > 0.0):
            raise ValueError(f'GridMap.resolution: must be positive, got {self.resolution}')

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.cells.shape[0], self.cells.shape[1]

    def mirrored(self) -> GridMap:
        """Return the map with its columns reversed, for a mirrored drawing."""
        return replace(self, cells=self.cells[:, ::-1])

    def cropped(self, rows: slice, cols: slice) -> GridMap:
        """Return a window of the map; its cells keep their positions in the frame."""
        first = np.array([rows.indices(self.shape[0])[0], cols.indices(self.shape[1])[0]])
        x, y = self.rc_to_xy(first - 0.5).tolist()
        pose = SE2.from_xy_yaw(x, y, self.T_frame_grid.yaw)
        return replace(self, cells=self.cells[rows, cols], T_frame_grid=pose)

    def rc_to_xy(self, rc: ArrayLike) -> NDArray[np.float64]:
        """Map raster indices ``rc (..., 2)`` (cell centres; fractions allowed) to metres."""
        rc = np.asarray(rc, dtype=np.float64)
        return self.T_frame_grid.apply((rc[..., ::-1] + 0.5) * self.resolution)

    def xy_to_rc(self, xy: ArrayLike) -> NDArray[np.float64]:
        """Map metric points ``xy (..., 2)`` to fractional raster indices (centre = integer)."""
        return self.T_frame_grid.inv().apply(xy)[..., ::-1] / self.resolution - 0.5


@dataclass(frozen=True, eq=False)
class Submap:
    """
    Gravity-aligned raster of everything that the robot has observed so far.

    Parameters
    ----------
    grid : GridMap
        Free where a ray crossed at body height or above the lintel; occupied where a mid-height
        hit was never crossed; frame ``submap``.
    lintel : (H, W) bool
        Free cells below a high hit: candidates for doors. All False for planar scanners.
    path_xy : (S, 2) float64
        Robot positions, frame ``submap`` [m]; (0, 2) for a map read from an image.
    T_odom_submap : SE2
        Pose of the submap frame in ``odom``.
    stamp_ns, id : int
        Sensor time of the newest scan; grows by one with every hand-out, 0 for a map from a file.
    recent_xy : (P, 2) float64
        Returns at body height over the last metres of the path, frame ``submap`` [m].
    newest_xy, newest_walls_xy : (P, 2) float64
        Those of the last few scans; the ones with nothing seen behind them: walls, no furniture.
    """

    grid: GridMap
    lintel: NDArray[np.bool_]
    path_xy: NDArray[np.float64]
    T_odom_submap: SE2 = field(default_factory=SE2.identity)
    stamp_ns: int = 0
    id: int = 0
    recent_xy: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 2)))
    newest_xy: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 2)))
    newest_walls_xy: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 2)))

    def __post_init__(self) -> None:
        """Check that the rasters have the same shape."""
        freeze_field(self, 'lintel', np.bool_, self.grid.shape)
        for name in ('path_xy', 'recent_xy', 'newest_xy', 'newest_walls_xy'):
            freeze_field(self, name, np.float64, (None, 2))

    @property
    def free_area_m2(self) -> float:
        """Area observed as free [m^2], the explored area of the graded thresholds."""
        return float(np.count_nonzero(self.grid.cells == FREE)) * self.grid.resolution**2


class RegionLabel(StrEnum):
    """Semantic class of a region (paper, section III-A)."""

    ROOM = 'room'
    DOOR = 'door'


@dataclass(frozen=True, eq=False)
class Region:
    """
    One room or door of a segmentation, a vertex of the region graph.

    ``polygon (V, 2)`` is the outer boundary, counter-clockwise, not closed, in the frame of the
    segmented grid [m]. ``observed_fraction`` estimates how much of the region was observed and
    ``frontier_fraction`` is the share of its boundary that borders unknown space (0 for a
    drawing); ``confidence`` in [0, 1] rates the extent of the region.
    ``track`` identifies the region across segmentations of a growing submap; it is -1 where
    regions are not tracked.
    """

    id: int
    label: RegionLabel
    polygon: NDArray[np.float64]
    centroid: NDArray[np.float64]
    area_m2: float
    observed_fraction: float = 1.0
    frontier_fraction: float = 0.0
    confidence: float = 1.0
    track: int = -1

    def __post_init__(self) -> None:
        """Check shapes and ranges."""
        freeze_field(self, 'polygon', np.float64, (None, 2))
        freeze_field(self, 'centroid', np.float64, (2,))
        if len(self.polygon) < 3 or not self.area_m2 > 0.0:
            raise ValueError('Region: needs three vertices and a positive area')
        for name in ('observed_fraction', 'frontier_fraction', 'confidence'):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise ValueError(f'Region.{name}: must be in [0, 1], got {getattr(self, name)}')


@dataclass(frozen=True, eq=False)
class Portal:
    """
    Opening line of a door: ``ends (2, 2)`` [m], the door's region id and the rooms it joins.

    ``rooms`` holds two room ids; the second is None if the door leads into unobserved space.
    """

    door: int
    rooms: tuple[int, int | None]
    ends: NDArray[np.float64]
    has_lintel: bool = False

    def __post_init__(self) -> None:
        """Check the shape of the line."""
        freeze_field(self, 'ends', np.float64, (2, 2))

    @property
    def width_m(self) -> float:
        """Length of the opening line [m]."""
        return float(np.linalg.norm(self.ends[1] - self.ends[0]))


@dataclass(frozen=True, eq=False)
class Segmentation:
    """
    A grid segmented into rooms and doors.

    ``labels (H, W) int32`` holds the room's region id + 1, or 0 where there is no room; doors
    are in ``regions`` and ``portals`` only. Region ids are positions in ``regions``: rooms
    first, then doors. If nothing was found the tuples are empty and ``reason`` states why.
    """

    grid: GridMap
    labels: NDArray[np.int32]
    regions: tuple[Region, ...]
    portals: tuple[Portal, ...]
    reason: str = ''

    def __post_init__(self) -> None:
        """Check that ids are positions and that portals name existing regions."""
        freeze_field(self, 'labels', np.int32, self.grid.shape)
        if [region.id for region in self.regions] != list(range(len(self.regions))):
            raise ValueError('Segmentation: region ids must be their positions')
        for portal in self.portals:
            if self.regions[portal.door].label is not RegionLabel.DOOR:
                raise ValueError(f'Segmentation: portal names region {portal.door}, not a door')

    @cached_property
    def rooms(self) -> tuple[Region, ...]:
        """Regions labelled room."""
        return tuple(r for r in self.regions if r.label is RegionLabel.ROOM)

    @cached_property
    def doors(self) -> tuple[Region, ...]:
        """Regions labelled door."""
        return tuple(r for r in self.regions if r.label is RegionLabel.DOOR)


@dataclass(frozen=True, eq=False)
class RegionGraph:
    """
    Regions as vertices, door-room adjacency as edges (paper, section III-C).

    ``edges (E, 2) int64`` are undirected, each once, smaller id first. ``node_feat (R, D)`` and
    ``edge_feat (E, De)`` are float32 in the layout of :mod:`fpnet_core.graphs.features`.
    """

    regions: tuple[Region, ...]
    edges: NDArray[np.int64]
    node_feat: NDArray[np.float32]
    edge_feat: NDArray[np.float32]
    frame: Literal['plan', 'submap']

    def __post_init__(self) -> None:
        """Check shapes and that edges name existing regions."""
        freeze_field(self, 'edges', np.int64, (None, 2))
        freeze_field(self, 'node_feat', np.float32, (len(self.regions), None))
        freeze_field(self, 'edge_feat', np.float32, (len(self.edges), None))
        if self.edges.size and not (0 <= self.edges.min() <= self.edges.max() < len(self.regions)):
            raise ValueError('RegionGraph.edges: names a region that does not exist')

    def __len__(self) -> int:
        """Count the regions."""
        return len(self.regions)


@dataclass(frozen=True, eq=False)
class PlanScale:
    """
    Scale of a floorplan.

    ``stretch (2, 2)`` is symmetric, nominal plan metres per true metre in the plan's axes;
    ``sigma`` is its relative standard deviation; once ``is_locked`` no other scale is searched.
    """

    stretch: NDArray[np.float64]
    sigma: float
    is_locked: bool

    def __post_init__(self) -> None:
        """Check the stretch's shape."""
        freeze_field(self, 'stretch', np.float64, (2, 2))

    @property
    def factor(self) -> float:
        """Mean scale of both axes."""
        return float(scale_of(self.stretch))


class Status(Enum):
    """Status of the localizer."""

    NO_PLAN = 'no_plan'
    WAITING = 'waiting'
    SEARCHING = 'searching'
    AMBIGUOUS = 'ambiguous'
    LOCALIZED = 'localized'
    LOST = 'lost'


def status_line(status: Status, probability: float, reason: str) -> str:
    """Return status, probability and reason in one line."""
    return f'{status.value} (p {probability:.2f}): {reason}'


class CauseKind(StrEnum):
    """Kinds of causes why there is no pose."""

    DRAWING = 'floorplan parsed wrongly'
    SCALE = 'scale outside the searched range'
    MIRRORED = 'floorplan mirrored'
    OTHER_PLAN = 'other building or storey'
    INPUT = 'no walls in the scans'
    UPSIDE_DOWN = 'scanner upside down'
    RARE_SCANS = 'scans too rare for odometry'
    TOO_LITTLE = 'too little observed'
    DRIFT = 'odometry drift'
    SELF_SIMILAR = 'plan self-similar'


@dataclass(frozen=True)
class Cause:
    """Likely cause of a missing pose: ``evidence`` in numbers, ``next`` the command to run."""

    kind: CauseKind
    evidence: str
    next: str

    @property
    def said(self) -> str:
        """Cause and evidence in one line."""
        return f'{self.kind.value}: {self.evidence}'

    def as_json(self) -> dict[str, str]:
        """Return the cause as JSON values."""
        return {'cause': self.kind.value, 'evidence': self.evidence, 'next': self.next}


@dataclass(frozen=True, eq=False)
class LocalizerOutput:
    """
    Result of one update.

    ``A_plan_odom`` is valid near the robot, also if the submap as a whole is bent by drift. It is
    None unless ``status`` is LOCALIZED, so that no caller uses an identity by mistake.
    ``covariance`` is that of the pose, ``probability`` that of the best hypothesis; all
    ``estimates`` are in nominal plan metres, best first. ``scale`` is the plan scale measured by
    accepted placements; ``reason`` explains the status; ``is_mirrored``: only the mirror image
    fits. ``causes`` explain a missing pose. ``storeys``: probability of each; rest: ``storey``.
    """

    stamp_ns: int
    status: Status
    A_plan_odom: Affine2D | None = None
    covariance: PoseCovariance | None = None
    probability: float = 0.0
    estimates: Placements = field(default_factory=Placements.empty)
    match: MatchResult | None = None
    segmentation: Segmentation | None = None
    graph: RegionGraph | None = None
    submap: Submap | None = None
    timings_ms: dict[str, float] = field(default_factory=dict)
    scale: PlanScale | None = None
    reason: str = ''
    is_mirrored: bool = False
    causes: tuple[Cause, ...] = ()
    storey: str = ''
    storeys: dict[str, float] = field(default_factory=dict)

    @property
    def said(self) -> str:
        """Status, probability and reason in one line."""
        return status_line(self.status, self.probability, self.reason)

    def __str__(self) -> str:
        """Return :attr:`said`; the full representation would fill pages."""
        return self.said

    def pose(self, T_odom_base: NDArray[np.float64]) -> SE2 | None:
        """
        Return the pose of ``base`` in the floorplan grid's own frame and nominal metres.

        None unless LOCALIZED. ``T_odom_base`` is (4, 4); odometry bridges the time to an update.
        """
        if self.A_plan_odom is None:
            return None
        base = SE2.from_matrix4(T_odom_base)
        x, y = self.A_plan_odom.apply(base.translation)
        return SE2.from_xy_yaw(float(x), float(y), self.A_plan_odom.apply_yaw(base.yaw))

    def covariance_at(
        self, T_odom_base: NDArray[np.float64], stamp_ns: int
    ) -> NDArray[np.float64] | None:
        """Return the covariance ``(3, 3)`` of :meth:`pose` at a scan: x, y [m], yaw [rad]."""
        if self.A_plan_odom is None or self.covariance is None:
            return None
        return self.covariance.at(self.A_plan_odom, T_odom_base[:2, 3], stamp_ns)

    def __post_init__(self) -> None:
        """Check that a transform is given exactly if the status is LOCALIZED."""
        if (self.A_plan_odom is not None) != (self.status is Status.LOCALIZED):
            raise ValueError('LocalizerOutput: a transform and LOCALIZED go together')
