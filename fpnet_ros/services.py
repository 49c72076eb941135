# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Services of the localizer node: its own, and AMCL's under their names."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from std_srvs.srv import Empty, Trigger

from fpnet_ros.initial_poses import InitialPoses
from fpnet_ros.lifecycle import ManagedNode
from fpnet_ros.optional_messages import NO_SERVICE, SetInitialPose


def offer_services(
    node: ManagedNode, look_again: Callable[[], None], reset: Callable[[], None]
) -> None:
    """Offer ``~/relocalize`` and ``~/reset``."""

    def on_relocalize(_: Any, response: Trigger.Response) -> Trigger.Response:
        look_again()
        return succeeded(response, 'discarded all hypotheses; the submap stays')

    def on_reset(_: Any, response: Trigger.Response) -> Trigger.Response:
        reset()
        look_again()
        return succeeded(response, 'discarded the submap and all hypotheses')

    node.add_service(Trigger, '~/relocalize', on_relocalize)
    node.add_service(Trigger, '~/reset', on_reset)


def offer_amcl_services(
    node: ManagedNode, look_again: Callable[[], None], update: Callable[[], None]
) -> None:
    """Offer AMCL's services; do not call it beside AMCL, as a service has only one server."""

    def on_reinitialize(_: Any, response: Empty.Response) -> Empty.Response:
        look_again()
        return response

    def on_nomotion_update(_: Any, response: Empty.Response) -> Empty.Response:
        update()
        return response

    node.add_service(Empty, 'reinitialize_global_localization', on_reinitialize)
    node.add_service(Empty, 'request_nomotion_update', on_nomotion_update)


def offer_set_initial_pose(node: ManagedNode, words: InitialPoses, is_amcl_there: bool) -> None:
    """Offer ``~/set_initial_pose``, and without AMCL its name too; the response is empty."""
    if SetInitialPose is None:
        node.get_logger().warning(NO_SERVICE)
        return

    def on_set(request: Any, response: Any) -> Any:
        words.on_message(request.pose, 'set_initial_pose')
        return response

    for name in ('~/set_initial_pose', *(() if is_amcl_there else ('set_initial_pose',))):
        node.add_service(SetInitialPose, name, on_set)


def offer_save_state(
    node: ManagedNode, path: Callable[[], str], save: Callable[[], Future[str] | None]
) -> None:
    """
    Offer ``~/save_state``; the response is sent once the file is written.

    ``save`` starts to save; its future has the error message, empty on success. It returns None
    if the node is not configured.
    """

    async def on_save(_: Any, response: Trigger.Response) -> Trigger.Response:
        if not path():
            response.message = 'parameter state_file is empty; set it to a path'
        elif (saved := save()) is None:
            response.message = 'the node is not configured'
        else:
            await node.finished(saved)
            error = 'the node was cleaned up' if saved.cancelled() else saved.result()
            response.success, response.message = not error, error or f'saved to {path()}'
        return response

    node.add_slow_service(Trigger, '~/save_state', on_save)


def succeeded(response: Trigger.Response, message: str) -> Trigger.Response:
    """Return the response, marked as successful."""
    response.success, response.message = True, message
    return response
