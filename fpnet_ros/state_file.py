# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a localizer leaves on disk: what goes wrong with it is told once, and stops nothing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from fpnet_core.errors import FpnetError, StateError
from fpnet_core.io.atomic import remove_partials
from fpnet_core.io.runs import write_output
from fpnet_core.localizer import Localizer
from fpnet_core.types import LocalizerOutput
from fpnet_ros.odometry_run import OdometryRun
from fpnet_ros.runtime import Once, one_line

_RESTARTED = 'odometry was restarted since the state was saved'
_UNKNOWN = 'whether odometry has gone on since the state was saved cannot be told'
_KEPT = 'its submap is left, floorplan, scale and last place are a first guess'


class StateFile:
    """
    Saves and restores one localizer, never into another frame of the odometry.

    Parameters
    ----------
    path
        Where; empty: nowhere.
    odometry
        Returns the run that publishes now.
    logger
        The node's.
    """

    def __init__(
        self, path: str, localizer: Localizer, odometry: Callable[[], OdometryRun], logger: Any
    ) -> None:
        self.path = path
        self._localizer, self._odometry, self._logger = localizer, odometry, logger
        self._run = OdometryRun()
        self._saved_run: OdometryRun | None = None  # until a scan tells whether that goes on
        self._errors = Once(logger.error)

    def save(self) -> str:
        """Write the state, if anywhere; returns what went wrong, empty: nothing."""
        if not self.path:
            return ''
        try:
            self._localizer.save_state(self.path, self._run.as_text())
        except StateError as error:
            self._errors.tell(one_line(error))
            return one_line(error)
        self._errors.clear()
        return ''

    def restore(self) -> None:
        """Go on from a saved state; a bad one is no reason not to start."""
        if not self.path:
            return
        remove_partials(Path(self.path))
        try:
            if not Path(self.path).exists():
                return
            saved_with = self._localizer.load_state(self.path)
        except (OSError, StateError) as error:
            self._logger.error(f'{one_line(error)}; starting anew')
            return
        self._saved_run = OdometryRun.from_text(saved_with)
        self._logger.info(f'restored the state in {self.path}')

    def follow_odometry(self) -> None:
        """See who publishes the odometry by now; called now and then while the node is alive."""
        if self.path:
            self._run = self._odometry()

    def before_scan(self) -> None:
        """Compare the restored run with the first scan's: another one has another frame."""
        saved, self._saved_run = self._saved_run, None
        if saved is not None or not self._run.publishers:
            # Publishers are known before their first message is, and with it its number.
            self.follow_odometry()
        if saved is None:
            return
        goes_on = self._run.goes_on_from(saved)
        if not goes_on:
            why = _UNKNOWN if goes_on is None else _RESTARTED
            self._logger.warning(f'{why}: {_KEPT}')
            self._localizer.restart_odometry()


class RunFolder:
    """
    A folder for every tick; one that cannot be written costs the ticks, and one line.

    Parameters
    ----------
    path
        Empty: nothing is written.
    """

    def __init__(self, path: str, logger: Any) -> None:
        self._path = path
        self._errors = Once(logger.error)

    def write(self, name: str, output: LocalizerOutput) -> None:
        """Write a tick."""
        if not self._path:
            return
        try:
            write_output(Path(self._path) / name, output)
        except FpnetError as error:
            self._errors.tell(f'parameter run_dir: {one_line(error)}')
        else:
            self._errors.clear()
