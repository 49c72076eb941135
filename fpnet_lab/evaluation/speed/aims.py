# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a large storey may cost: apart from what measures it, so that pages can say it, too."""

# Given: aims on the storey of 20,000 m2, a searching tick by the clock, memory at its peak.
AIM_M2, AIM_TICK_S, AIM_PEAK_BYTES = 20_000, 0.5, 1.5e9
