# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Command line of a user, and the commands suggested next."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
import shlex

from fpnet_core.drawings.plan_files import picture_path
from fpnet_core.io.maps import YAML_SUFFIXES


@dataclass(frozen=True)
class Invocation:
    """
    Command line from which the next command is derived.

    ``command`` are the words without those about the drawing, ``drawing`` the file, ``options``
    its options: pairs of option and value, the value empty for a flag. ``of_bag``: odometry came
    from a bag, so scan matching can improve it.
    """

    command: tuple[str, ...] = ('fpnet', 'localize', 'INPUT', '--floorplan')
    drawing: str = 'PLAN'
    options: tuple[tuple[str, str], ...] = ()
    of_bag: bool = False

    def again(self, option: str = '', value: str = '', instead_of: tuple[str, ...] = ()) -> str:
        """Return the same command with one option added or its value replaced."""
        gone = {option, *instead_of}
        kept = [pair for pair in self.options if pair[0] not in gone]
        return self._line(*self.command, kept=[*kept, (option, value)])

    def flipped(self) -> str:
        """Return the same command with the drawing flipped, or not flipped if it was."""
        if ('--mirrored', '') not in self.options:
            return self.again('--mirrored')
        return self.again(instead_of=('--mirrored',))

    def on(self, drawing: str) -> str:
        """Return the same command with another drawing and without options for it."""
        return replace(self, drawing=drawing, options=()).again()

    def on_one_storey(self) -> str:
        """Return the same command with the floorplan of one storey instead of a site."""
        command = (*self.command[:-1], '--floorplan')
        return replace(self, command=command).on('PLAN_OF_THE_STOREY')

    def look(self, command: str, *more: str) -> str:
        """Return ``fpnet COMMAND`` on the drawing with its options."""
        return self._line('fpnet', command, kept=[*self.options], more=more)

    def look_at_reading(self) -> str:
        """Return how to view the parsed plan: in its picture, if it was written already."""
        drawing = Path(self.drawing)
        picture = picture_path(drawing)
        if drawing.suffix.lower() in YAML_SUFFIXES and picture.is_file():
            return f'look at {picture}'
        read = self.look('plan', '--out', 'out/plan.yaml')
        return f'{read} and look at out/plan_reading.png'

    def doctor(self) -> str:
        """Return the command that checks the recording, independent of the drawing."""
        return shlex.join(['fpnet', 'doctor', self.command[2]])

    def _line(self, *words: str, kept: list[tuple[str, str]], more: tuple[str, ...] = ()) -> str:
        said = [word for pair in kept for word in pair if word]
        return shlex.join([*words, self.drawing, *said, *more])
