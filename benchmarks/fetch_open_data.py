# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Download the public files of the open benchmark's track ``real``.

Run: python benchmarks/fetch_open_data.py [--out out/open_data] [--manifest JSON]; then
fpnet bench open make --track real --data out/open_data --out out/real

Prints address and licence of each file before it downloads it, and keeps a file only if its
SHA-256 is that of the manifest. Intact files are kept as they are.
"""

import argparse
import hashlib
from pathlib import Path
import sys
from urllib.error import URLError
from urllib.request import urlopen

from fpnet_core.errors import FpnetError
from fpnet_core.io.atomic import replaced
from fpnet_lab.evaluation.open_benchmark.real import Manifest

TIMEOUT_S = 60.0


def fetch(file, folder):
    """Download a file; return what went wrong, empty for nothing."""
    if not file.fault(folder):
        return ''
    print(f'{file.name}: {file.url}\n  licence: {file.licence}', flush=True)
    try:
        with urlopen(file.url, timeout=TIMEOUT_S) as answer:  # noqa: S310 - of the manifest
            content = answer.read()
    except (URLError, OSError, ValueError) as error:
        return f'{file.name}: cannot download {file.url}: {error}'
    found = hashlib.sha256(content).hexdigest()
    if found != file.sha256:
        return f'{file.name}: {file.url} has changed: expected SHA-256 {file.sha256}, got {found}'
    with replaced(folder / file.name) as partial:
        partial.write_bytes(content)
    return ''


def main():
    """Download what is missing; exit with 1 if a file could not be had."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--out', type=Path, default=Path('out/open_data'), metavar='DIR')
    parser.add_argument('--manifest', type=Path, metavar='JSON', help='default: packaged')
    arguments = parser.parse_args()
    try:
        files = Manifest.read(arguments.manifest).files.values()
    except FpnetError as error:
        sys.exit(str(error))
    faults = [fault for file in files if (fault := fetch(file, arguments.out))]
    sys.exit('\n'.join(faults) or None)


if __name__ == '__main__':
    main()
