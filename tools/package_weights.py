# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Add a trained checkpoint to the package, with its figures and the commands that made it.

Usage, after ``fpnet train matcher --out RUN`` and
``fpnet bench matching --weights RUN/matcher.safetensors --json REPORT``::

    python tools/package_weights.py RUN REPORT --command 'fpnet train matcher ...' [--name paper]
"""

import argparse
import json
from pathlib import Path

from fpnet_core.io.weights import PACKAGED_NAME, read_weights, write_weights
from fpnet_core.types import FEATURE_SCHEMA

PACKAGE = Path(__file__).parents[1] / 'fpnet_core' / 'weights'


def main() -> None:
    """Copy the best checkpoint of a run; exit if it does not beat nearest neighbour."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('run', type=Path)
    parser.add_argument('report', type=Path)
    parser.add_argument('--command', action='append', required=True)
    parser.add_argument('--name', default=Path(PACKAGED_NAME).stem)
    arguments = parser.parse_args()
    figures = json.loads(arguments.report.read_text(encoding='utf-8'))
    learned, nearest = (figures['methods'][name] for name in ('fpnet', 'nearest_neighbor'))
    if learned['match_f1'] <= nearest['match_f1']:
        raise SystemExit(f'F1 {learned["match_f1"]:.3f} does not beat nearest neighbour')
    weights = read_weights(arguments.run / 'matcher.safetensors', FEATURE_SCHEMA)
    kept = ('network', 'evidence', 'training', 'figures')
    facts = {key: weights.manifest[key] for key in kept if key in weights.manifest}
    facts['training'] = {**facts['training'], 'commands': arguments.command}
    facts['figures'] = {**facts['figures'], 'held_back': figures}
    target = PACKAGE / f'{arguments.name}.safetensors'
    write_weights(target, weights.tensors, FEATURE_SCHEMA, facts)


if __name__ == '__main__':
    main()
