# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The lab's subcommands of ``fpnet``; :mod:`fpnet.cli` finds them by entry point."""

from fpnet.cli import Subcommand


def _lab(module: str, summary: str) -> Subcommand:
    return Subcommand(f'fpnet_lab.cli.{module}', summary, extra='lab')


COMMANDS = {
    'bench': _lab('bench', 'Compare methods on the same inputs.'),
    'demo': _lab('demo', 'Localise a simulated robot on a floorplan, all parts running.'),
    'simulate': _lab('simulate', 'Generate floorplans, matching pairs and lidar recordings.'),
    'train': _lab('train', 'Train the networks and fit the models.'),
}
