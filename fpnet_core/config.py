# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
One configuration tree for core, command line and nodes.

Every field carries its unit in its name, a range and a one-line description: the same text
becomes the ROS parameter's descriptor and the parameter reference. ``config/fpnet.yaml`` is
written as a ROS parameter file; :func:`load_config` unwraps ``ros__parameters``, so a node and
the command line read the same file.
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
"""What is known of the size of a floorplan; see :mod:`fpnet_core.localizer.scale`."""

ScanStamp = Literal['auto', 'start', 'middle', 'end']
"""What of a sweep a cloud's stamp is of; see :mod:`fpnet_core.io.sweep_stamps`."""

OdometryChoice = Literal['kiss', 'robot', 'both']
"""
Who says how the robot moved: KISS-ICP, its own odometry, or KISS-ICP with that as first guess.
"""


class Section(BaseModel):
    """Base of every section: frozen, and unknown keys are errors."""

    model_config = ConfigDict(extra='forbid', frozen=True)


class SubmapConfig(Section):
    """How registered scans become a raster (see :mod:`fpnet_core.submaps`)."""

    resolution_m: float = Field(0.05, ge=0.02, le=0.2, description='Cell edge of the submap.')
    min_range_m: float = Field(0.3, ge=0.0, description='Returns nearer than this are dropped.')
    max_range_m: float = Field(15.0, gt=0.5, description='Rays are used up to this range.')
    max_rays: int = Field(10000, ge=100, description='Rays carved per scan, evenly chosen.')
    sensor_height_m: float = Field(
        0.9, gt=0.0, lt=3.0, description='Sensor above the floor, used until a floor is seen.'
    )
    body_low_m: float = Field(
        0.3, ge=0.0, description='Lower limit of body height, above the floor.'
    )
    body_high_m: float = Field(
        1.8, gt=0.3, description='Upper limit of body height, above the floor.'
    )


class SegmentationConfig(Section):
    """How a raster is cut into rooms and doors (see :mod:`fpnet_core.segmentation`)."""

    method: Literal['default', 'morphological', 'distance'] = Field(
        'default', description='How floorplans are cut; submaps are always cut by the default.'
    )


class MatcherConfig(Section):
    """Which matcher runs and how its threshold is graded (see :mod:`fpnet_core.matching`)."""

    weights: str = Field('', description='Checkpoint (.safetensors); empty: the packaged one.')
    grade_regions: tuple[float, ...] = Field(
        (4.0, 10.0), description='Region counts at which a submap moves up one grade.'
    )
    grade_area_m2: tuple[float, ...] = Field(
        (30.0, 120.0), description='Explored areas at which a submap moves up one grade.'
    )
    grade_thresholds: tuple[float, ...] = Field(
        (0.15, 0.2, 0.3), description='Least match probability per grade, early submaps first.'
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
    """From region pairs to verified transforms (see :mod:`fpnet_core.pose`)."""

    scale_tolerance: float = Field(
        0.1, ge=0.0, le=0.5, description='The plan may be drawn this share too large or small.'
    )
    anisotropy_sigma: float = Field(
        0.03, gt=0.0, le=0.2, description='Standard deviation of the drawing, x against y.'
    )


class LocalizerConfig(Section):
    """Cadence, and what it takes to claim a pose (see :mod:`fpnet_core.localizer`)."""

    update_period_s: float = Field(1.0, gt=0.0, description='Time between two rematches.')
    min_explored_m2: float = Field(
        12.0, ge=0.0, description='Observed free area before the first match.'
    )
    scale_policy: ScalePolicy = Field(
        'approximate',
        description='Scale of the plan: trusted; approximate, within pose.scale_tolerance unless '
        'it fits better beyond; or unknown.',
    )
    search_every_updates: int = Field(
        30, ge=1, description='While surely localized, ticks between searches of the whole plan.'
    )
    mirror_check_updates: int = Field(
        5, ge=1, description='Without a claim, so many ticks between looks at the mirrored plan.'
    )
    plan_prior: float = Field(
        0.99,
        gt=0.0,
        lt=1.0,
        description='Probability that a plan given to a robot is of its building, before looking.',
    )
    scorer_weights: str = Field(
        '', description='Trained judge of placements (.safetensors); empty: the packaged one.'
    )
    # A robot can wait: on drives on sheets, claims from 0.95 and 0.97 on were wrong once in a
    # hundred, and not from here on (benchmarks/sheet_drives.py).
    accept_probability: float = Field(
        0.99, gt=0.5, lt=1.0, description='Probability of the best placement to claim it.'
    )
    # Fitted: on buildings that were left out, claims from 0.95 on were wrong in 0.3 % of the cases
    # and fell for 0.15 % of the other plans (fpnet train judge, notes/localizer.md).
    match_probability: float = Field(
        0.95, gt=0.5, lt=1.0, description='The same to call two whole maps matched, in one look.'
    )
    release_probability: float = Field(
        0.6, gt=0.0, lt=1.0, description='A claim is withdrawn below this probability.'
    )
    confirm_updates: int = Field(
        2, ge=1, description='Ticks in a row the same placement must win.'
    )
    drift_support: float = Field(
        0.1,
        ge=0.0,
        le=1.0,
        description='The pose follows the walls around the robot where a share larger by this '
        'fits than where the whole submap puts them; 1: never, for odometry without drift.',
    )
    drift_m_per_m: float = Field(0.05, ge=0.0, description='Position odometry loses [m/m].')
    drift_deg_per_m: float = Field(1.0, ge=0.0, description='Heading odometry loses [deg/m].')
    doubt_probability: float = Field(
        0.8,
        gt=0.0,
        le=1.0,
        description='A pose is withheld where the newest scans say with more than this '
        'probability that the robot is elsewhere, as when it was carried off; 1: never.',
    )
    doubt_updates: int = Field(
        3, ge=1, description='So many such ticks in a row begin a new submap.'
    )
    max_speed_mps: float = Field(
        10.0,
        gt=0.0,
        description='Top speed of the robot: faster odometry has broken unless walls say '
        'otherwise.',
    )
    stale_scans_before_restart: int = Field(
        20, ge=1, description='Scans in a row from the past before the clock is taken as reset.'
    )


class ScansConfig(Section):
    """What the clouds of a sensor are like (see :mod:`fpnet_core.io.sweep_stamps`)."""

    stamp: ScanStamp = Field(
        'auto',
        description='What of a sweep the stamp of its cloud is of; auto: as the times of its '
        'points say, else the middle.',
    )


class OdometryConfig(Section):
    """KISS-ICP settings, named as in its own ROS node."""

    max_range: float = Field(20.0, gt=1.0, description='Points beyond are dropped [m].')
    min_range: float = Field(0.5, ge=0.0, description='Points nearer are dropped [m].')
    voxel_size: float = Field(
        0.4, gt=0.0, description='Map voxel [m]; halving it costs four times the CPU.'
    )
    planar_voxel_size: float = Field(
        0.1, gt=0.0, description='The same for planar scanners, which see few points [m].'
    )
    deskew: bool = Field(
        True, description='Undo the motion during a sweep by times of points, or by their order.'
    )


class FpnetConfig(Section):
    """The whole tree."""

    seed: int = Field(0, ge=0, description='Seed of every random choice.')
    submap: SubmapConfig = SubmapConfig()
    segmentation: SegmentationConfig = SegmentationConfig()
    matcher: MatcherConfig = MatcherConfig()
    pose: PoseConfig = PoseConfig()
    localizer: LocalizerConfig = LocalizerConfig()
    scans: ScansConfig = ScansConfig()
    odometry: OdometryConfig = OdometryConfig()


def parse_config(tree: dict[str, Any], source: str = 'configuration') -> FpnetConfig:
    """Validate a nested mapping; raises ConfigError that names the key and the reason."""
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
    """Return every key with its section, as ``submap.resolution_m``, in the order of the tree."""
    return [
        f'{name}.{leaf}' if isinstance(value, Section) else name
        for name, value in FpnetConfig()
        for leaf in (type(value).model_fields if isinstance(value, Section) else [''])
    ]


def _unknown(key: str, value: Any) -> str:
    """Name a key that does not exist, and the one that was probably meant."""
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
    Read a YAML file (plain or ROS parameter form) and apply dotted overrides.

    Parameters
    ----------
    path : the file; None takes the defaults
    overrides : ``{'submap.resolution_m': 0.1}``

    Raises
    ------
    ConfigError
        If the file is missing or malformed, or a key or value is not accepted.
    """
    tree = {} if path is None else _read_tree(Path(path))
    set_dotted(tree, overrides or {})
    return parse_config(tree, str(path) if path else 'configuration')


def set_dotted(tree: dict[str, Any], overrides: Mapping[str, Any]) -> None:
    """Set ``{'submap.resolution_m': 0.1}`` in a nested mapping; ConfigError where none may be."""
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
