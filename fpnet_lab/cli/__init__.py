# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The lab's subcommands of ``fpnet``; :mod:`fpnet.cli` finds them by entry point."""

from fpnet.cli import Subcommand


def _lab(module: str, summary: str) -> Subcommand:
    return Subcommand(f'fpnet_lab.cli.{module}', summary, extra='lab')


COMMANDS = {
    'bench': _lab('bench', 'Compare methods on the same inputs.'),
    'demo': _lab('demo', 'Localise a simulated robot on a floorplan, all parts running.'),
    'finetune': _lab('finetune', 'Adapt the matching network to one building.'),
    'simulate': _lab('simulate', 'Generate floorplans, matching pairs and lidar recordings.'),
    'train': _lab('train', 'Train the matching network.'),
    'train-covariance': _lab('train_covariance', 'Fit how far a pose may be off.'),
    'train-doors': _lab('train_doors', 'Train what tells doors from lines inside of rooms.'),
    'train-doubts': _lab('train_doubts', 'Fit what tells a drawing that was read wrongly.'),
    'train-evidence': _lab('train_evidence', "Fit what judges the matcher's placements."),
    'train-judge': _lab('train_judge', 'Train the judge of placements.'),
    'train-scale': _lab('train_scale', 'Train what tells the scale of a drawing or a map.'),
    'train-parser': _lab('train_parser', 'Train the network that parses pictures.'),
}
