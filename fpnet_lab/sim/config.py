# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Ranges that generated pairs are drawn from; not part of the robot's own configuration."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field, model_validator

from fpnet_core.config import Section, SegmentationConfig
from fpnet_lab.sim.drawn.styles import StyleConfig

Range = tuple[float, float]


class DrawingConfig(Section):
    """How a storey's drawing differs from the building."""

    resolution_m: Range = Field((0.05, 0.1), description='Cell edge of the drawing.')
    wall_factor: Range = Field((0.5, 1.8), description='Drawn over true wall thickness.')
    scale_error: float = Field(
        0.09, ge=0.0, lt=0.5, description='Largest error of the nominal scale.'
    )
    axis_error: float = Field(
        0.06, ge=0.0, lt=0.5, description='Largest difference of x or y scale from their mean.'
    )
    any_angle: float = Field(
        0.4, ge=0.0, le=1.0, description='Share drawn at any angle, not a multiple of 90 degrees.'
    )
    cut: float = Field(
        0.0, ge=0.0, le=1.0, description='Share of drawings that show a part of the storey only.'
    )
    cut_m: Range = Field((14.0, 30.0), description='Sides of the part that such a drawing shows.')
    style: StyleConfig = StyleConfig()


class BuildingConfig(Section):
    """What a robot meets that no drawing shows."""

    furnished: float = Field(0.8, ge=0.0, le=1.0, description='Share of furnished buildings.')
    closed_doors: Range = Field((0.0, 0.15), description='Share of doors that are shut.')
    moved_doors: float = Field(
        0.04, ge=0.0, le=1.0, description='Share of doors at another place in their wall.'
    )
    moved_walls: float = Field(
        0.2, ge=0.0, le=1.0, description='Share of buildings with displaced inner walls.'
    )
    removed_walls: float = Field(
        0.3, ge=0.0, le=1.0, description='Share of buildings that lost walls between rooms.'
    )
    added_walls: float = Field(
        0.3, ge=0.0, le=1.0, description='Share of buildings with partitions added to rooms.'
    )
    glass: Range = Field((0.0, 0.05), description='Share of wall length made of glass.')


class ScanConfig(Section):
    """A robot's tour and its scanner."""

    planar: float = Field(
        0.4, ge=0.0, le=1.0, description='Share of planar scanners; others see all heights.'
    )
    max_range_m: Range = Field((12.0, 20.0), description='Rays are used up to this range.')
    narrow: float = Field(
        0.5, ge=0.0, le=1.0, description='Share of planar scanners that only look ahead.'
    )
    noise_m: Range = Field((0.0, 0.03), description='Standard deviation of a range.')
    rays: int = Field(540, ge=90, le=4096, description='Rays per turn of the scanner.')
    pose_spacing_m: Range = Field((0.5, 1.0), description='Path between two scans.')
    tiny_tours: float = Field(
        0.3, ge=0.0, le=1.0, description='Share of tours that end after one to four rooms.'
    )
    large_tours: float = Field(
        0.25, ge=0.0, le=1.0, description='Share of tours through more than half of the rooms.'
    )
    yaw_drift_rad: Range = Field(
        (0.0, 0.0006), description='Random walk of the heading per square root of a metre.'
    )
    jitter_m: Range = Field(
        (0.0, 0.015), description='Standard deviation of the position of a single scan.'
    )
    jitter_rad: Range = Field(
        (0.0, 0.004), description='Standard deviation of the heading of a single scan.'
    )
    length_drift: float = Field(
        0.004, ge=0.0, description='Largest relative error of odometry lengths.'
    )
    warp: Range = Field((0.0, 0.02), description='Largest strain of the warp of the whole map.')
    resolution_m: tuple[float, ...] = Field(
        (0.05, 0.1), description='Cell edges of submaps, drawn with equal chance.'
    )


class ClipConfig(Section):
    """Robot maps that are parts of the storey's own map (the paper's matching map generator)."""

    share: Range = Field((0.25, 0.9), description='Share of the rooms in reach that are kept.')
    min_rooms: int = Field(4, ge=1, description='Fewest rooms, where there are so many.')
    clipped: float = Field(
        0.5, ge=0.0, le=1.0, description='Share of maps of which a straight cut removes a side.'
    )
    clip_share: float = Field(
        0.3, ge=0.0, lt=1.0, description='Largest share of a map that such a cut removes.'
    )
    bumps_cells: Range = Field(
        (0.0, 0.6), description='Standard deviation of the bumps of walls, in cells.'
    )
    specks: Range = Field((0.0, 0.002), description='Share of floor cells that are specks.')
    furnished: float = Field(0.5, ge=0.0, le=1.0, description='Share of furnished maps.')
    resolution_m: tuple[float, ...] = Field(
        (0.05, 0.1), description='Cell edges of maps of generated storeys.'
    )


class SimConfig(Section):
    """The whole of matching-pair generation."""

    robot_map: Literal['tour', 'clip'] = Field(
        'tour', description='Ray-cast tours of a robot, or clips of the map, as in the paper.'
    )
    families: tuple[str, ...] = Field(
        (), description='Layout families of generated storeys; empty: all.'
    )

    pairs_per_plan: int = Field(8, ge=1, description='Pairs of one storey.')
    pairs_per_drawing: int = Field(
        4, ge=1, description='Consecutive pairs of a storey that share one drawing of it.'
    )
    min_rooms: int = Field(8, ge=2, description='Fewest rooms of a storey.')
    max_rooms: int = Field(64, ge=2, description='Most rooms of a storey.')
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
