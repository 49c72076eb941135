# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What every test runs under."""

import signal

# A shell has its background jobs ignore Ctrl-C, and so would the programs that tests interrupt.
signal.signal(signal.SIGINT, signal.default_int_handler)

LONGEST = (
    *('test_sheet_drives', 'test_real_logs', 'test_ros_chain', 'test_sheets_read'),
    *('test_ros_recovery', 'test_ros_localizer_interface', 'test_localize_cli'),
)


def pytest_collection_modifyitems(items):
    """Begin with the files that take longest: at the end no worker waits for another."""
    items.sort(key=lambda item: item.path.stem not in LONGEST)
