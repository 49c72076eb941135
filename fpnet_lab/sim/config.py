# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parameter ranges of generated matching pairs; not part of the robot's configuration."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field, model_validator

from fpnet_core.config import Section, SegmentationConfig
from fpnet_lab.sim.drawn.styles import StyleConfig

Range = tuple[float, float]


class DrawingConfig(Section):
    """Differences between a storey's drawing and the building."""

    resolution_m: Range = Field((0.05, 0.1), description='Cell edge of the drawing.')
    wall_factor: Range = Field((0.5, 1.8), description='Ratio of drawn to true wall thickness.')
    scale_error: float = Field(
        0.09, ge=0.0, lt=0.5, description='Largest relative error of the nominal scale.'
    )
    axis_error: float = Field(
        0.06, ge=0.0, lt=0.5, description='Largest deviation of the x or y scale from their mean.'
    )
    any_angle: float = Field(
        0.4, ge=0.0, le=1.0, description='Share drawn at any angle, others at multiples of 90°.'
    )
    cut: float = Field(
        0.0, ge=0.0, le=1.0, description='Share of drawings that show only part of the storey.'
    )
    cut_m: Range = Field((14.0, 30.0), description='Side lengths of a partial drawing.')
    style: StyleConfig = StyleConfig()


class BuildingConfig(Section):
    """Properties of the real building that its drawing does not show."""

    furnished: float = Field(0.8, ge=0.0, le=1.0, description='Share of furnished buildings.')
    closed_doors: Range = Field((0.0, 0.15), description='Share of doors that are closed.')
    moved_doors: float = Field(
        0.04, ge=0.0, le=1.0, description='Share of doors that are displaced along their wall.'
    )
    moved_walls: float = Field(
        0.2, ge=0.0, le=1.0, description='Share of buildings with displaced inner walls.'
    )
    removed_walls: float = Field(
        0.3, ge=0.0, le=1.0, description='Share of buildings with removed inner walls.'
    )
    added_walls: float = Field(
        0.3, ge=0.0, le=1.0, description='Share of buildings with partitions added to rooms.'
    )
    glass: Range = Field((0.0, 0.05), description='Share of wall length made of glass.')


class ScanConfig(Section):
    """A robot's tour and its scanner."""

    planar: float = Field(
        0.4, ge=0.0, le=1.0, description='Share of planar scanners; others measure at all heights.'
    )
    max_range_m: Range = Field((12.0, 20.0), description='Maximum range of a ray.')
    narrow: float = Field(
        0.5, ge=0.0, le=1.0, description='Share of planar scanners with a narrow field of view.'
    )
    noise_m: Range = Field((0.0, 0.03), description='Standard deviation of the range noise.')
    rays: int = Field(540, ge=90, le=4096, description='Rays per turn of the scanner.')
    pose_spacing_m: Range = Field((0.5, 1.0), description='Path length between two scans.')
    tiny_tours: float = Field(
        0.3, ge=0.0, le=1.0, description='Share of tours that visit one to four rooms.'
    )
    large_tours: float = Field(
        0.25, ge=0.0, le=1.0, description='Share of tours through more than half of the rooms.'
    )
    yaw_drift_rad: Range = Field(
        (0.0, 0.0006), description='Heading random walk per square root of a metre.'
    )
    jitter_m: Range = Field(
        (0.0, 0.015), description="Standard deviation of a single scan's position."
    )
    jitter_rad: Range = Field(
        (0.0, 0.004), description="Standard deviation of a single scan's heading."
    )
    length_drift: float = Field(
        0.004, ge=0.0, description='Largest relative error of odometry distances.'
    )
    warp: Range = Field((0.0, 0.02), description="Largest strain of the whole map's warp.")
    resolution_m: tuple[float, ...] = Field(
        (0.05, 0.1), description='Cell edges of submaps, drawn with equal probability.'
    )


class ClipConfig(Section):
    """Robot maps clipped from the storey's own map (the paper's matching map generator)."""

    share: Range = Field((0.25, 0.9), description='Share of the reachable rooms that are kept.')
    min_rooms: int = Field(4, ge=1, description='Minimum number of rooms, if available.')
    clipped: float = Field(
        0.5, ge=0.0, le=1.0, description='Share of maps where a straight cut removes one side.'
    )
    clip_share: float = Field(
        0.3, ge=0.0, lt=1.0, description='Largest share of a map that the cut removes.'
    )
    bumps_cells: Range = Field(
        (0.0, 0.6), description='Standard deviation of wall roughness, in cells.'
    )
    specks: Range = Field((0.0, 0.002), description='Share of floor cells that become specks.')
    furnished: float = Field(0.5, ge=0.0, le=1.0, description='Share of furnished maps.')
    resolution_m: tuple[float, ...] = Field(
        (0.05, 0.1), description='Cell edges of maps of generated storeys.'
    )


class SimConfig(Section):
    """Configuration of matching-pair generation."""

    robot_map: Literal['tour', 'clip'] = Field(
        'tour', description='Ray-cast robot tours, or clips of the map as in the paper.'
    )
    families: tuple[str, ...] = Field(
        (), description='Layout families of generated storeys; empty means all.'
    )

    pairs_per_plan: int = Field(8, ge=1, description='Number of pairs per storey.')
    pairs_per_drawing: int = Field(
        4, ge=1, description='Consecutive pairs of a storey that share one drawing.'
    )
    min_rooms: int = Field(8, ge=2, description='Minimum number of rooms per storey.')
    max_rooms: int = Field(64, ge=2, description='Maximum number of rooms per storey.')
    drawing: DrawingConfig = DrawingConfig()
    building: BuildingConfig = BuildingConfig()
    scan: ScanConfig = ScanConfig()
    clip: ClipConfig = ClipConfig()
    segmentation: SegmentationConfig = SegmentationConfig()

    @model_validator(mode='after')
    def _is_consistent(self) -> Self:
        if self.pairs_per_plan % self.pairs_per_drawing:
            raise ValueError('pairs_per_plan must be a multiple of pairs_per_drawing')
        if self.min_rooms > self.max_rooms:
            raise ValueError('min_rooms must not exceed max_rooms')
        return self
