# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Put a trained checkpoint into the package, with its figures on held-back pairs.

Usage, after ``fpnet train --out RUN`` and
``fpnet bench matching --weights RUN/matcher.safetensors --data HELD_BACK --json REPORT``::

    python tools/package_weights.py RUN REPORT
"""

import json
from pathlib import Path
import sys

from fpnet_core.io.weights import PACKAGED_NAME, read_weights, write_weights
from fpnet_core.types import FEATURE_SCHEMA

PACKAGE = Path(__file__).parents[1] / 'fpnet_core' / 'weights'


def main(run: Path, report: Path) -> None:
    """Copy the best checkpoint of ``run``; refuses one that loses to nearest neighbour."""
    figures = json.loads(report.read_text(encoding='utf-8'))
    learned, nearest = (figures['methods'][name] for name in ('fpnet', 'nearest_neighbor'))
    if learned['match_f1'] <= nearest['match_f1']:
        raise SystemExit(f'F1 {learned["match_f1"]:.3f} does not beat nearest neighbour')
    weights = read_weights(run / 'matcher.safetensors', FEATURE_SCHEMA)
    facts = {key: weights.manifest[key] for key in ('network', 'training', 'figures')}
    facts['figures'] = {**facts['figures'], 'held_back': figures}
    write_weights(PACKAGE / PACKAGED_NAME, weights.tensors, FEATURE_SCHEMA, facts)


if __name__ == '__main__':
    main(Path(sys.argv[1]), Path(sys.argv[2]))
