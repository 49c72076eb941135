# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Configuration tree of the core, the command line and the nodes.

Each field has its unit in its name, a range and a one-line description, which is also the
descriptor of the ROS parameter and the text of the parameter reference. ``config/fpnet.yaml`` is
a ROS parameter file; :func:`load_config` unwraps ``ros__parameters``, so a node and the command
line read the same file.
"""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches
from pathlib import Path
import reprlib
from typing import Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from fpnet_core.arguments import checked
from fpnet_core.errors import ConfigError
from fpnet_core.plain_yaml import read_yaml

ScalePolicy = Literal['unknown', 'approximate', 'trusted']
"""Prior on the scale of a floorplan; see :mod:`fpnet_core.localizer.scale`."""

ScanStamp = Literal['auto', 'start', 'middle', 'end']
"""Time within a sweep that a cloud's stamp refers to; see :mod:`fpnet_core.io.sweep_stamps`."""

OdometryChoice = Literal['kiss', 'robot', 'both']
"""
Source of odometry: KISS-ICP, the robot, or KISS-ICP with the robot's as initial guess.
"""


class Section(BaseModel):
    """Base of every section: frozen; unknown keys are errors."""

    model_config = ConfigDict(extra='forbid', frozen=True)


class SubmapConfig(Section):
    """Submap raster built from registered scans (see :mod:`fpnet_core.submaps`)."""

    resolution_m: float = Field(0.05, ge=0.02, le=0.2, description='Cell size of the submap.')
    min_range_m: float = Field(0.3, ge=0.0, description='Returns closer than this are dropped.')
    max_range_m: float = Field(15.0, gt=0.5, description='Maximum range of the rays in use.')
    max_rays: int = Field(10000, ge=100, description='Maximum rays per scan, evenly subsampled.')
    sensor_height_m: float = Field(
        0.9, gt=0.0, lt=3.0, description='Sensor height above the floor until a floor is detected.'
    )
    body_low_m: float = Field(
        0.3, ge=0.0, description='Lower limit of body height above the floor.'
    )
    body_high_m: float = Field(
        1.8, gt=0.3, description='Upper limit of body height above the floor.'
    )


class SegmentationConfig(Section):
    """Segmentation of maps into rooms and doors (see :mod:`fpnet_core.segmentation`)."""

    method: Literal['default', 'morphological', 'distance'] = Field(
        'default', description='Segmentation of floorplans; submaps always use the default.'
    )


class MatcherConfig(Section):
    """Matcher weights and graded match thresholds (see :mod:`fpnet_core.matching`)."""

    weights: str = Field('', description='Checkpoint (.safetensors); empty: packaged weights.')
    grade_regions: tuple[float, ...] = Field(
        (4.0, 10.0), description='Region counts at which a submap moves up one grade.'
    )
    grade_area_m2: tuple[float, ...] = Field(
        (30.0, 120.0), description='Explored areas at which a submap moves up one grade.'
    )
    grade_thresholds: tuple[float, ...] = Field(
        (0.15, 0.2, 0.3), description='Minimum match probability per grade, small submaps first.'
    )

    @model_validator(mode='after')
    def _grades_agree(self) -> Self:
        for bounds in (self.grade_regions, self.grade_area_m2):
            if len(bounds) != len(self.grade_thresholds) - 1 or list(bounds) != sorted(bounds):
                raise ValueError('grade bounds must ascend and be one fewer than the thresholds')
        if not all(0.0 <= threshold < 1.0 for threshold in self.grade_thresholds):
            raise ValueError('grade_thresholds must be in [0, 1)')
        return self


class PoseConfig(Section):
    """Pose hypotheses from region pairs and their verification (see :mod:`fpnet_core.pose`)."""

    scale_tolerance: float = Field(
        0.1, ge=0.0, le=0.5, description='Relative error of the plan scale to allow for.'
    )
    anisotropy_sigma: float = Field(
        0.03, gt=0.0, le=0.2, description='Standard deviation of the plan scale, x against y.'
    )


class LocalizerConfig(Section):
    """Update rate and acceptance thresholds (see :mod:`fpnet_core.localizer`)."""

    update_period_s: float = Field(1.0, gt=0.0, description='Time between two updates.')
    min_explored_m2: float = Field(
        12.0, ge=0.0, description='Observed free area required for the first update.'
    )
    scale_policy: ScalePolicy = Field(
        'approximate',
        description='Prior on the plan scale: trusted; approximate, within pose.scale_tolerance '
        'unless a scale beyond fits better; or unknown.',
    )
    search_every_updates: int = Field(
        30, ge=1, description='Updates between searches of the whole plan while localized.'
    )
    mirror_check_updates: int = Field(
        5, ge=1, description='Updates between checks of the mirrored plan while not localized.'
    )
    plan_prior: float = Field(
        0.99,
        gt=0.0,
        lt=1.0,
        description='Prior probability that the given plan is of the building the robot is in.',
    )
    scorer_weights: str = Field(
        '', description='Trained placement scorer (.safetensors); empty: packaged weights.'
    )
    # A robot can wait for more evidence: on simulated sheets, poses accepted at 0.95 or 0.97 were
    # wrong once in a hundred, at 0.99 never (benchmarks/sheet_drives.py).
    accept_probability: float = Field(
        0.99, gt=0.5, lt=1.0, description='Probability at which the best placement is accepted.'
    )
    # Fitted: on held-out buildings, a wrong placement was accepted in 0.3 % of the trials on the
    # correct plan at 0.95, and a placement on another building's plan in 0.15 %
    # (fpnet train scorer, notes/localizer.md).
    match_probability: float = Field(
        0.95, gt=0.5, lt=1.0, description='Probability at which two whole maps count as matched.'
    )
    release_probability: float = Field(
        0.6, gt=0.0, lt=1.0, description='Probability below which the pose is withdrawn.'
    )
    confirm_updates: int = Field(
        2, ge=1, description='Consecutive updates that a placement must win to be accepted.'
    )
    drift_support: float = Field(
        0.1,
        ge=0.0,
        le=1.0,
        description='The pose follows the walls near the robot if this much more of them fits '
        'than with the placement of the whole submap; 1: never, for odometry without drift.',
    )
    drift_m_per_m: float = Field(0.05, ge=0.0, description='Position drift of odometry [m/m].')
    drift_deg_per_m: float = Field(1.0, ge=0.0, description='Heading drift of odometry [deg/m].')
    doubt_probability: float = Field(
        0.8,
        gt=0.0,
        le=1.0,
        description='The pose is withheld while the newest scans put the robot elsewhere with '
        'more than this probability, for example after kidnapping; 1: never.',
    )
    doubt_updates: int = Field(
        3, ge=1, description='Consecutive such updates that start a new submap.'
    )
    max_speed_mps: float = Field(
        10.0,
        gt=0.0,
        description='Maximum speed of the robot; faster motion counts as an odometry reset '
        'unless walls confirm it.',
    )
    stale_scans_before_restart: int = Field(
        20, ge=1, description='Consecutive scans with old stamps that count as a clock reset.'
    )


class ScansConfig(Section):
    """Time stamps of the sensor's clouds (see :mod:`fpnet_core.io.sweep_stamps`)."""

    stamp: ScanStamp = Field(
        'auto',
        description='Time within a sweep that the stamp of its cloud refers to; auto: by the '
        'times of its points, else the middle.',
    )


class OdometryConfig(Section):
    """KISS-ICP settings, named as in its ROS node."""

    max_range: float = Field(20.0, gt=1.0, description='Points farther away are dropped [m].')
    min_range: float = Field(0.5, ge=0.0, description='Points closer than this are dropped [m].')
    voxel_size: float = Field(
        0.4, gt=0.0, description='Map voxel size [m]; half the size costs four times the CPU.'
    )
    planar_voxel_size: float = Field(
        0.1, gt=0.0, description='Voxel size for planar scanners, which see few points [m].'
    )
    deskew: bool = Field(
        True, description='Deskew sweeps by the times of their points, or else by their order.'
    )


class FpnetConfig(Section):
    """Whole configuration tree."""

    seed: int = Field(0, ge=0, description='Seed of all random numbers.')
    submap: SubmapConfig = SubmapConfig()
    segmentation: SegmentationConfig = SegmentationConfig()
    matcher: MatcherConfig = MatcherConfig()
    pose: PoseConfig = PoseConfig()
    localizer: LocalizerConfig = LocalizerConfig()
    scans: ScansConfig = ScansConfig()
    odometry: OdometryConfig = OdometryConfig()


def parse_config(tree: dict[str, Any], source: str = 'configuration') -> FpnetConfig:
    """Return a nested mapping as configuration; ConfigError names the bad key and the reason."""
    try:
        return FpnetConfig.model_validate(tree)
    except ValidationError as error:
        first = error.errors()[0]
        key = '.'.join(str(part) for part in first['loc']) or '(top level)'
        if first['type'] == 'extra_forbidden':
            raise ConfigError(f'{source}: {_unknown(key, first["input"])}') from None
        raise ConfigError(
            f'{source}: {key}: {first["msg"]} (got {reprlib.repr(first["input"])}); '
            'see config/fpnet.yaml for every key and its range'
        ) from None


def config_keys() -> list[str]:
    """Return all keys with their sections, e.g. ``submap.resolution_m``, in tree order."""
    return [
        f'{name}.{leaf}' if isinstance(value, Section) else name
        for name, value in FpnetConfig()
        for leaf in (type(value).model_fields if isinstance(value, Section) else [''])
    ]


def _unknown(key: str, value: Any) -> str:
    """Return a message that names an unknown key and the closest known one."""
    if isinstance(value, dict) and value:
        key = f'{key}.{next(iter(value))}'
    near = get_close_matches(key, config_keys(), n=1)
    same_leaf = [known for known in config_keys() if known.endswith(f'.{key.split(".")[-1]}')]
    meant = f'did you mean {(near or same_leaf)[0]}? ' if near or same_leaf else ''
    return f'unknown key {key}; {meant}config/fpnet.yaml has every key'


@checked
def load_config(
    path: Path | str | None = None, overrides: dict[str, Any] | None = None
) -> FpnetConfig:
    """
    Load a YAML file (plain or ROS parameter form) and apply dotted overrides.

    Parameters
    ----------
    path : the file; None: defaults
    overrides : e.g. ``{'submap.resolution_m': 0.1}``

    Raises
    ------
    ConfigError
        If the file is missing or malformed, or a key or value is not accepted.
    """
    tree = {} if path is None else _read_tree(Path(path))
    set_dotted(tree, overrides or {})
    return parse_config(tree, str(path) if path else 'configuration')


def set_dotted(tree: dict[str, Any], overrides: Mapping[str, Any]) -> None:
    """Set dotted keys in a nested mapping; ConfigError if a parent of a key is a value."""
    for dotted, value in overrides.items():
        node = tree
        *parents, leaf = dotted.split('.')
        for part in parents:
            node = node.setdefault(part, {})
            if not isinstance(node, dict):
                raise ConfigError(f'{dotted}: {part} is a value, not a section')
        node[leaf] = value


def _read_tree(path: Path) -> dict[str, Any]:
    tree = read_yaml(path, ConfigError, 'configuration')
    if tree is None:
        return {}
    if not isinstance(tree, dict):
        raise ConfigError(f'{path}: expected a mapping at the top, got {type(tree).__name__}')
    if len(tree) == 1:
        (node,) = tree.values()
        if isinstance(node, dict) and set(node) == {'ros__parameters'}:
            inner = node['ros__parameters']
            return inner if isinstance(inner, dict) else {}
    return tree
