# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Training of the matching network; importing this package loads torch."""

from fpnet_lab.training.config import TrainingConfig, parse_training_config
from fpnet_lab.training.data import PairArrays, load_pairs, split_by_pair, split_by_plan
from fpnet_lab.training.evidence import calibrate
from fpnet_lab.training.loop import WEIGHTS_FILE, EpochRecord, Hooks, Trainer, use_threads

__all__ = [
    'WEIGHTS_FILE',
    'EpochRecord',
    'Hooks',
    'PairArrays',
    'Trainer',
    'TrainingConfig',
    'calibrate',
    'load_pairs',
    'parse_training_config',
    'split_by_pair',
    'split_by_plan',
    'use_threads',
]
