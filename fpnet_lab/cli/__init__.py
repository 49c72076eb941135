# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The lab's subcommands of ``fpnet``, found by :mod:`fpnet.cli` through an entry point."""

from fpnet.cli import Subcommand


def _lab(module: str, summary: str) -> Subcommand:
    return Subcommand(f'fpnet_lab.cli.{module}', summary, extra='lab')


COMMANDS = {
    'bench': _lab('bench', 'Compare methods on the same inputs.'),
    'demo': _lab('demo', 'Localize a simulated robot on a floorplan with all nodes running.'),
    'simulate': _lab('simulate', 'Generate floorplans, matching pairs and lidar recordings.'),
    'train': _lab('train', 'Train the networks and fit the models.'),
}
