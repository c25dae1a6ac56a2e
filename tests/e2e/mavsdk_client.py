"""MAVSDK as a client: a session with a vehicle, and the updates of its streams."""

import asyncio
import contextlib

from mavsdk import ComponentType, LogLevel, log_subscribe
from mavsdk.asyncio.mavsdk import Configuration, Mavsdk

from programs import PATIENCE_S


def session(url, work):
    """`work` with the first autopilot at a URL: what came of it, and what MAVSDK has complained of (a list that goes on)."""
    complaints = []

    def log(level, message, _file, _line):
        if level >= LogLevel.WARN:
            complaints.append(message)
        return True

    async def with_autopilot():
        kind = Configuration.create_with_component_type(ComponentType.GROUND_STATION)
        async with Mavsdk(kind) as mavsdk:
            await mavsdk.add_any_connection(url)
            system = await mavsdk.first_autopilot(timeout_s=PATIENCE_S)
            assert system is not None, "no autopilot found"
            return await work(system)

    log_subscribe(log)
    return asyncio.run(with_autopilot()), complaints


async def first(stream, condition):
    """The first update that meets a condition."""
    async with asyncio.timeout(PATIENCE_S), contextlib.aclosing(stream) as updates:
        async for update in updates:
            if condition(update):
                return update


async def follow(stream, into):
    async for update in stream:
        into.append(update)
