# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Files that a localizer node writes; errors are logged once and do not stop the node."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from fpnet_core.errors import FpnetError, StateError
from fpnet_core.io.atomic import remove_partials
from fpnet_core.io.runs import write_output
from fpnet_core.localizer import Localizer
from fpnet_core.types import LocalizerOutput
from fpnet_ros.logs import NodeLog, one_line
from fpnet_ros.robot_odometry import OdometryRun

_RESTARTED = 'odometry was restarted since the state was saved'
_UNKNOWN = 'it is unknown whether odometry was restarted since the state was saved'
_KEPT = 'starting a new submap; floorplan, scale and last place are the first guess'


class StateFile:
    """
    Saves and restores one localizer, never into another odometry frame.

    An empty ``path`` saves nothing; ``odometry`` returns the current run of the odometry.
    """

    def __init__(
        self, path: str, localizer: Localizer, odometry: Callable[[], OdometryRun], logger: Any
    ) -> None:
        self._path, self._localizer, self._odometry = path, localizer, odometry
        self._logger, self._log = logger, NodeLog(logger)
        self._run = OdometryRun()
        self._saved_run: OdometryRun | None = None  # until a scan shows whether it goes on

    def save(self) -> str:
        """Write the state, if there is a path; return the error message, empty on success."""
        if not self._path:
            return ''
        try:
            self._localizer.save_state(self._path, self._run.as_text())
        except StateError as error:
            self._log.fail('save', error)
            return one_line(error)
        self._log.succeed('save')
        return ''

    def restore(self) -> None:
        """Restore a saved state; log an unusable one and start without it."""
        if not self._path:
            return
        remove_partials(Path(self._path))
        try:
            if not Path(self._path).exists():
                return
            saved_with = self._localizer.load_state(self._path)
        except (OSError, StateError) as error:
            self._logger.error(f'{one_line(error)}; starting anew')
            return
        self._saved_run = OdometryRun.from_text(saved_with)
        self._logger.info(f'restored the state from {self._path}')

    def follow_odometry(self) -> None:
        """Update the current run of the odometry; called periodically."""
        if self._path:
            self._run = self._odometry()

    def before_scan(self) -> None:
        """Compare the restored run with the first scan's: another run has another frame."""
        saved, self._saved_run = self._saved_run, None
        if saved is not None or not self._run.publishers:
            # Publishers are known before their first message, which has the number.
            self.follow_odometry()
        if saved is not None and not (goes_on := self._run.goes_on_from(saved)):
            why = _UNKNOWN if goes_on is None else _RESTARTED
            self._logger.warning(f'{why}: {_KEPT}')
            self._localizer.restart_odometry()


class RunFolder:
    """Folder for a file per update, none if ``path`` is empty; failures are logged once."""

    def __init__(self, path: str, logger: Any) -> None:
        self._path, self._log = path, NodeLog(logger)

    def write(self, name: str, output: LocalizerOutput) -> None:
        """Write an update."""
        if not self._path:
            return
        try:
            write_output(Path(self._path) / name, output)
        except FpnetError as error:
            self._log.fail('write', FpnetError(f'parameter run_dir: {one_line(error)}'))
        else:
            self._log.succeed('write')
