# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reader and writer for trajectories in text files: TUM, KITTI and BALM formats."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from fpnet_core.errors import OdometryError
from fpnet_core.geometry.rigid3d import is_rigid
from fpnet_core.io.arrays import read_array
from fpnet_core.plain_files import regular
from fpnet_core.stamps import NS_PER_S

KITTI_PERIOD_NS = 100_000_000
"""
KITTI pose files have no times: poses are assumed to be 0.1 s apart. Physical: KITTI's lidar
turns ten times a second.
"""

_TUM_COLUMNS, _KITTI_COLUMNS, _BALM_COLUMNS = 8, 12, 4  # given


@dataclass(frozen=True, eq=False)
class Trajectory:
    """
    Poses of a body over time, in one fixed frame.

    ``stamps_ns (S,) int64`` in file order and ``T_frame_body (S, 4, 4)``, rigid.
    """

    stamps_ns: NDArray[np.int64]
    T_frame_body: NDArray[np.float64]

    def __len__(self) -> int:
        """Return the number of poses."""
        return len(self.stamps_ns)

    @property
    def xy(self) -> NDArray[np.float64]:
        """Positions ``(S, 2)`` [m]."""
        return self.T_frame_body[:, :2, 3]

    @property
    def yaw(self) -> NDArray[np.float64]:
        """Headings ``(S,)`` of the body's x axis [rad], in (-pi, pi]."""
        yaw: NDArray[np.float64] = np.arctan2(
            self.T_frame_body[:, 1, 0], self.T_frame_body[:, 0, 0]
        )
        return yaw


def read_tum(path: Path | str) -> Trajectory:
    """
    Read ``t x y z qx qy qz qw`` lines (seconds, metres); ``#`` starts a comment.

    Raises
    ------
    OdometryError
        If the file is missing, has no pose, or a line is malformed.
    """
    path = Path(path)
    rows = read_rows(path)
    if rows and len(rows[0]) != _TUM_COLUMNS:
        raise OdometryError(
            f'{path}: expected TUM lines "t x y z qx qy qz qw", got {len(rows[0])} columns'
        )
    return parse_poses(rows, path)


def read_poses(path: Path | str) -> Trajectory:
    """
    Read a pose file; the number of columns determines the format.

    8 is TUM; 12 is KITTI and KISS-ICP (rows of a 3 x 4 matrix, no time); 4 is BALM (4 x 4
    matrices over four lines, with the time in place of the last element). Values are separated
    by blanks or commas. A ``.npy`` file holds an array ``(S, 4, 4)``, as KISS-ICP writes it, and
    no times.

    Raises
    ------
    OdometryError
        If the file is missing, has no pose, or matches none of the formats.
    """
    path = Path(path)
    if path.suffix.lower() == '.npy':
        return _checked(Trajectory(*_read_npy(path)), path)
    return parse_poses(read_rows(path), path)


def write_covariances(path: Path | str, stamps_ns: ArrayLike, covariances: ArrayLike) -> None:
    """
    Write pose covariances as CSV with a header: time [s] and six entries per line.

    Parameters
    ----------
    path
        File to write (CSV); its folder is created.
    stamps_ns : (S,)
        Times [ns].
    covariances : (S, 3, 3)
        Over x, y [m] and yaw [rad].
    """
    upper = np.asarray(covariances, dtype=np.float64).reshape(-1, 3, 3)[:, *np.triu_indices(3)]
    rows = zip(np.asarray(stamps_ns, dtype=np.int64).tolist(), upper.tolist(), strict=True)
    lines = [
        f'{ns // NS_PER_S}.{ns % NS_PER_S:09d},{",".join(f"{value:.6g}" for value in row)}\n'
        for ns, row in rows
    ]
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text('t,xx,xy,x_yaw,yy,y_yaw,yaw_yaw\n' + ''.join(lines), encoding='ascii')


def write_tum(
    path: Path | str, stamps_ns: ArrayLike, xy: ArrayLike, yaw: ArrayLike, z: float = 0.0
) -> None:
    """
    Write planar poses as ``t x y z qx qy qz qw`` lines, with times in full nanoseconds.

    Parameters
    ----------
    path
        File to write; its folder is created.
    stamps_ns : (S,)
        Times [ns].
    xy : (S, 2)
        Positions [m].
    yaw : (S,)
        Headings [rad].
    z
        Height of all poses [m].
    """
    path = Path(path)
    half = 0.5 * np.asarray(yaw, dtype=np.float64)
    rows = zip(
        np.asarray(stamps_ns, dtype=np.int64).tolist(),
        np.asarray(xy, dtype=np.float64).reshape(-1, 2).tolist(),
        np.sin(half).tolist(),
        np.cos(half).tolist(),
        strict=True,
    )
    lines = [
        f'{ns // NS_PER_S}.{ns % NS_PER_S:09d} {x:.6f} {y:.6f} {z:.6f} 0 0 {qz:.9f} {qw:.9f}\n'
        for ns, (x, y), qz, qw in rows
    ]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(''.join(lines), encoding='utf-8')


def read_rows(path: Path) -> list[list[str]]:
    """Return the words of each line; raise OdometryError if the file cannot be read as text."""
    try:
        text = regular(path).read_text(encoding='utf-8')
    except OSError as error:
        raise OdometryError(f'cannot read poses {path}: {error.strerror}') from None
    except UnicodeDecodeError:
        raise OdometryError(f'{path} is not a pose file: it is not text') from None
    lines = (line.split('#', 1)[0].replace(',', ' ').split() for line in text.splitlines())
    return [line for line in lines if line]


def parse_poses(rows: list[list[str]], path: Path) -> Trajectory:
    """Return the poses in the rows of ``path``; raises as :func:`read_poses`."""
    if not rows:
        raise OdometryError(f'{path} holds no pose')
    columns = len(rows[0])
    for number, row in enumerate(rows, start=1):
        if len(row) != columns:
            raise OdometryError(
                f'{path}: pose line {number} has {len(row)} values, expected {columns}'
            )
    parsers = {_TUM_COLUMNS: _from_tum, _KITTI_COLUMNS: _from_kitti, _BALM_COLUMNS: _from_balm}
    if columns not in parsers:
        raise OdometryError(
            f'{path}: expected 8 (TUM), 12 (KITTI) or 4 (4 x 4 blocks) columns, got {columns}'
        )
    try:
        trajectory = parsers[columns](rows)
    except (ValueError, OverflowError, InvalidOperation) as error:
        raise OdometryError(f'{path}: {error or "a value is not a number"}') from None
    return _checked(trajectory, path)


def _checked(trajectory: Trajectory, path: Path) -> Trajectory:
    for index, T_frame_body in enumerate(trajectory.T_frame_body):
        if not is_rigid(T_frame_body):
            raise OdometryError(f'{path}: pose {index} is not a rigid transform')
    return trajectory


def _read_npy(path: Path) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    try:
        poses = read_array(path)
    except OSError as error:
        raise OdometryError(f'cannot read poses {path}: {error.strerror or error}') from None
    except ValueError as error:
        raise OdometryError(f'{path} is not an array of poses: {error}') from None
    if poses.dtype.kind not in 'fiu' or poses.ndim != 3 or poses.shape[1:] != (4, 4):
        raise OdometryError(
            f'{path}: expected poses (S, 4, 4) as numbers, got {poses.dtype} {poses.shape}'
        )
    if not len(poses):
        raise OdometryError(f'{path} holds no pose')
    return np.arange(len(poses), dtype=np.int64) * KITTI_PERIOD_NS, poses.astype(np.float64)


def _from_tum(rows: list[list[str]]) -> Trajectory:
    values = _as_floats([row[1:] for row in rows])
    poses = _identities(len(rows))
    poses[:, :3, :3] = Rotation.from_quat(values[:, 3:]).as_matrix()
    poses[:, :3, 3] = values[:, :3]
    return Trajectory(_stamps([row[0] for row in rows]), poses)


def _from_kitti(rows: list[list[str]]) -> Trajectory:
    poses = _identities(len(rows))
    poses[:, :3, :] = _as_floats(rows).reshape(-1, 3, 4)
    return Trajectory(np.arange(len(rows), dtype=np.int64) * KITTI_PERIOD_NS, poses)


def _from_balm(rows: list[list[str]]) -> Trajectory:
    if len(rows) % 4:
        raise ValueError(f'expected blocks of four lines, got {len(rows)} lines')
    poses = _as_floats(rows).reshape(-1, 4, 4)
    poses[:, 3, 3] = 1.0
    return Trajectory(_stamps([row[3] for row in rows[3::4]]), poses)


def _identities(count: int) -> NDArray[np.float64]:
    return np.tile(np.eye(4), (count, 1, 1))


def _as_floats(rows: list[list[str]]) -> NDArray[np.float64]:
    values = np.array(rows, dtype=np.float64)
    if not np.isfinite(values).all():
        raise ValueError('a pose contains NaN or infinity')
    return values


def _stamps(texts: list[str]) -> NDArray[np.int64]:
    # A double cannot hold seconds since 1970 with nanoseconds: at 1.6e9 s its step is 200 ns.
    seconds = [Decimal(text) for text in texts]
    if not all(second.is_finite() for second in seconds):
        raise ValueError('a time is not finite')
    return np.array([int(second * NS_PER_S) for second in seconds], dtype=np.int64)
