# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Shared parts of benchmarks with recordings in generated buildings: families, options, loop."""

from fpnet.cli.common import load
from fpnet_lab.cli.reports import script_parser

FAMILIES = ('bays', 'double_corridor', 'open_plan', 'suites', 'central_hall', 'racetrack')


def drives_parser(description, drives, seed):
    """Return the command line parser with the given defaults."""
    parser = script_parser(description)
    parser.add_argument('--drives', type=int, default=drives)
    parser.add_argument('--sensor', default='planar')
    parser.add_argument('--seed', type=int, default=seed)
    parser.add_argument('--set', action='append', default=[], metavar='KEY=VALUE')
    return parser


def each(arguments, drive):
    """Yield the families in turn with the results of ``drive(seed, family, sensor, config)``."""
    config = load(None, arguments.set)
    for number in range(arguments.drives):
        family = FAMILIES[number % len(FAMILIES)]
        yield family, drive(arguments.seed + number, family, arguments.sensor, config)
