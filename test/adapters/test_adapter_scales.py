# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0

import pytest

from fpnet_core.errors import MapFormatError
from msg_adapters.diagnostics import diagnostics_to_msg, health_to_msg
from msg_adapters.scales import GridScale, scale_from_msg, scale_to_msg

STAMP_NS = 1_700_000_000_123_456_789


@pytest.mark.parametrize(
    ('scale', 'level'),
    [
        (GridScale(STAMP_NS, 0.8123456789, 1.3, '0.05 m per pixel (0.04 to 0.07)'), b'\x01'),
        (GridScale(STAMP_NS, said='stated by plan.yaml'), b'\x00'),
    ],
)
def test_what_is_known_of_a_scale_survives_and_an_estimate_is_a_warning(received, scale, level):
    msg = scale_to_msg(scale)
    again = scale_from_msg(received(msg))
    assert (again, again.said) == (scale, scale.said)
    assert msg.status[0].level == level
    assert msg.status[0].message == scale.said


def test_a_message_about_something_else_or_nonsense_is_refused():
    other = diagnostics_to_msg([health_to_msg('other', '', {})], STAMP_NS)
    with pytest.raises(MapFormatError, match='unreadable'):
        scale_from_msg(other)
    for low, high in ((1.2, 0.8), (0.0, 1.0), (1.0, float('inf'))):
        with pytest.raises(MapFormatError, match='out of range'):
            scale_from_msg(scale_to_msg(GridScale(STAMP_NS, low, high)))
    with pytest.raises(MapFormatError):
        scale_from_msg(scale_to_msg(GridScale(STAMP_NS, float('nan'), 1.0)))
