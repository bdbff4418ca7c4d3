"""A server of the live workbench in a thread."""

import asyncio
import socket
import threading
import time
from contextlib import contextmanager

import uvicorn

from governor_mechanism.live.conversation import MAX_MESSAGE_SIZE
from governor_mechanism.live.server import HOST

WAITING_TIME = 60.0
"""Longest time (s) for an answer on a busy machine."""


@contextmanager
def serve(workbench):
    """Serve the scenes of a workbench, and give the port."""
    with socket.socket() as listener:
        listener.bind((HOST, 0))
        port = listener.getsockname()[1]
        config = uvicorn.Config(workbench.make_app(port), log_level="critical", ws="websockets-sansio", ws_max_size=MAX_MESSAGE_SIZE)
        server = uvicorn.Server(config)
        thread = threading.Thread(target=lambda: asyncio.run(server.serve(sockets=[listener])))
        thread.start()
        deadline = time.monotonic() + WAITING_TIME
        while not server.started:
            assert time.monotonic() < deadline
            time.sleep(0.01)
        yield port
        server.should_exit = True
        thread.join(WAITING_TIME)
