# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reader for a folder of point files, in the order of their names, with one pose file."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
import re
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fpnet.recordings.trajectories import KITTI_PERIOD_NS, Trajectory, read_poses
from fpnet_core.errors import CloudFormatError, OdometryError
from fpnet_core.io.arrays import ArrayArchive
from fpnet_core.io.clouds import CLOUD_SUFFIXES, read_cloud
from fpnet_core.io.scans import Scan

_POSE_SUFFIXES = ('.csv', '.txt', '.tum')


class FolderScans:
    """
    Scans of a folder: point files (see :mod:`fpnet_core.io.clouds`), or one ``.npz`` of arrays.

    Names are sorted in natural order (scan2 before scan10). The pose file is the ``.csv``,
    ``.txt`` or ``.tum`` file that parses as poses, one for each scan. Without one, the scans have
    no poses and are stamped 0.1 s apart.
    """

    kind: Literal['folder'] = 'folder'

    def __init__(self, path: Path) -> None:
        self._path = path
        self._files = sorted(
            (p for p in path.iterdir() if p.suffix.lower() in CLOUD_SUFFIXES), key=_natural_key
        )
        self._archive = _single_archive(path) if not self._files else None
        names = [f.name for f in self._files]
        if self._archive is not None:
            with _open_archive(self._archive) as archive:
                names = sorted(archive.names, key=_natural_key)
        self._names = names
        if not names:
            raise CloudFormatError(
                f'folder {path} has no scans; expected {", ".join(CLOUD_SUFFIXES)} files or '
                'one .npz'
            )
        self._poses = _find_poses(path)
        if self._poses is not None and len(self._poses) != len(names):
            raise OdometryError(
                f'folder {path} has {len(names)} scans but {len(self._poses)} poses; expected '
                'one pose for each scan'
            )

    @property
    def has_poses(self) -> bool:
        """Whether a pose file was found."""
        return self._poses is not None

    def __len__(self) -> int:
        """Return the number of scans."""
        return len(self._names)

    def __iter__(self) -> Iterator[Scan]:
        """Read and yield the scans in the order of their stamps."""
        stamps = (
            np.arange(len(self), dtype=np.int64) * KITTI_PERIOD_NS
            if self._poses is None
            else self._poses.stamps_ns
        )
        order = np.argsort(stamps, kind='stable').tolist()
        for index, points in zip(order, self._points(order), strict=True):
            pose = None if self._poses is None else self._poses.T_frame_body[index]
            yield Scan(int(stamps[index]), points, None, pose)

    def _points(self, order: list[int]) -> Iterator[NDArray[np.float32]]:
        if self._archive is None:
            for index in order:
                yield read_cloud(self._files[index]).astype(np.float32)
            return
        with _open_archive(self._archive) as archive:
            for index in order:
                yield _archived_points(archive, self._names[index])


def _natural_key(name: Path | str) -> list[tuple[int, str]]:
    """Return a sort key that puts scan2 before scan10."""
    parts = re.split(r'(\d+)', name.name if isinstance(name, Path) else name)
    return [(int(part), '') if part.isdecimal() else (-1, part) for part in parts]


def _single_archive(path: Path) -> Path | None:
    archives = sorted(path.glob('*.npz'))
    if len(archives) > 1:
        raise CloudFormatError(
            f'folder {path} has {len(archives)} .npz archives; expected one with all scans'
        )
    return archives[0] if archives else None


def _open_archive(path: Path) -> ArrayArchive:
    try:
        return ArrayArchive(path)
    except OSError as error:
        raise CloudFormatError(f'cannot read {path}: {error.strerror or error}') from None
    except ValueError as error:
        raise CloudFormatError(f'{path}: {error}') from None


def _archived_points(archive: ArrayArchive, name: str) -> NDArray[np.float32]:
    try:
        points = archive.read(name)
    except ValueError as error:
        raise CloudFormatError(f'scan in the .npz archive is unusable: {error}') from None
    if points.dtype.kind not in 'fiu' or points.ndim != 2 or points.shape[1] < 3:
        raise CloudFormatError(
            f'scan {name} in the .npz archive is unusable: expected numbers (P, 3), got '
            f'{points.dtype} {points.shape}'
        )
    with np.errstate(over='ignore'):
        # A float64 out of the range of float32 becomes infinite here and is dropped below.
        points = points[:, :3].astype(np.float32)
    finite: NDArray[np.float32] = points[np.isfinite(points).all(axis=1)]
    return finite


def _find_poses(path: Path) -> Trajectory | None:
    """Return the poses of the only pose file, or None; other text files are skipped."""
    found: dict[str, Trajectory] = {}
    for file in sorted(p for p in path.iterdir() if p.suffix.lower() in _POSE_SUFFIXES):
        try:
            found[file.name] = read_poses(file)
        except OdometryError:
            if 'pose' in file.name.lower() or file.suffix.lower() == '.tum':
                raise
    if len(found) > 1:
        raise OdometryError(f'folder {path} has several pose files: {", ".join(found)}; keep one')
    return next(iter(found.values()), None)
