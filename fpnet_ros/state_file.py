# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The localizer's state in a file: what goes wrong with it is told, and stops nothing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from fpnet_core.errors import StateError
from fpnet_core.localizer import Localizer
from fpnet_ros.runtime import one_line


class StateFile:
    """
    Saves and restores one localizer.

    Parameters
    ----------
    path
        Where; empty: nowhere.
    logger
        The node's.
    """

    def __init__(self, path: str, localizer: Localizer, logger: Any) -> None:
        self.path = path
        self._localizer = localizer
        self._logger = logger

    def save(self) -> str:
        """Write the state; returns what went wrong, empty: nothing."""
        try:
            self._localizer.save_state(self.path)
        except StateError as error:
            self._logger.error(one_line(error))
            return one_line(error)
        return ''

    def restore(self) -> None:
        """Go on from a saved state; a bad one is no reason not to start."""
        if not self.path or not Path(self.path).exists():
            return
        try:
            self._localizer.load_state(self.path)
        except StateError as error:
            self._logger.error(f'{one_line(error)}; starting anew')
            return
        self._logger.info(f'restored the state in {self.path}')
