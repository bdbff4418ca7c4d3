"""The local server of the live page: one page, one web socket, and downloads, on this machine alone."""

import asyncio
import json
import secrets
import socket
import webbrowser
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from threading import Lock
from typing import Any, Final
from urllib.parse import quote

import uvicorn
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.requests import HTTPConnection, Request
from starlette.responses import HTMLResponse, PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

import governor_mechanism as gm
from governor_mechanism.errors import MechanismError
from governor_mechanism.live.conversation import MAX_MESSAGE_SIZE, Answer, Later, attempt, respond
from governor_mechanism.live.page import make_beside_page, make_list_page, make_live_page
from governor_mechanism.live.session import Session
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.library import list_catalogue_entries, list_contents

HOST: Final = "127.0.0.1"
"""Only this machine can ask."""

PAGE_HEADERS: Final = {"Cache-Control": "no-store", "X-Content-Type-Options": "nosniff", "Referrer-Policy": "no-referrer"}
"""Headers of a page: it is not kept, and its address is not passed on."""

MAX_SESSIONS: Final = 20
"""Largest number of scenes that are open at once."""

MAX_BESIDE: Final = 4
"""Largest number of scenes beside each other."""

MAX_WAITING: Final = 20
"""Largest number of requests of a page that wait for answers which take long."""

HELD_PAUSE: Final = 0.3
"""Time, s, for which a hand does not move before the whole run is sent, and not only one moment of it."""

LAST_PAUSE: Final = 0.01
"""The same after the last change of a hand."""

REFUSED: Final = 1008
"""Code with which a web socket is closed that breaks a rule."""


class OnlyThisMachine:
    """Refuses requests that name another host or come from the page of another: a foreign page must not reach the server."""

    def __init__(self, app: ASGIApp, port: int) -> None:
        self.app = app
        self.hosts = {f"{name}:{port}" for name in (HOST, "localhost")}
        self.origins = {f"http://{host}" for host in self.hosts}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or refuse it."""
        if scope["type"] in ("http", "websocket"):
            headers = HTTPConnection(scope).headers
            origin = headers.get("origin")
            is_socket = scope["type"] == "websocket"
            is_foreign = origin not in self.origins and (is_socket or origin is not None)
            if is_foreign or headers.get("host") not in self.hosts:
                if is_socket:
                    await send({"type": "websocket.close", "code": REFUSED})
                else:
                    await PlainTextResponse("this server answers its own page alone\n", status_code=403)(scope, receive, send)
                return
        await self.app(scope, receive, send)


class Workbench:
    """The application: a list of scenes, and a page for each, which all its tabs share."""

    def __init__(self, token: str, opened: Mapping[str, Session]) -> None:
        self.token = token
        self.sessions = dict(opened)
        self.starting = Lock()

    def make_app(self, port: int) -> ASGIApp:
        """Return the application."""
        scene = f"/{self.token}/{{name}}"
        routes = [
            Route(f"/{self.token}/", self.list_scenes),
            Route(f"/{self.token}/beside/{{names:path}}/", self.show_beside),
            Route(f"{scene}/", self.show_page),
            WebSocketRoute(f"{scene}/live", self.talk),
        ]
        return OnlyThisMachine(Starlette(routes=routes), port)

    async def find_session(self, connection: HTTPConnection) -> Session:
        """Return the session of a scene; the first call starts it. Raise HTTPException if there is no such scene."""

        def find() -> Session:
            name = connection.path_params["name"]
            with self.starting:
                if name not in self.sessions:
                    if not self._is_known(name) or len(self.sessions) >= MAX_SESSIONS:
                        raise HTTPException(404, f"there is no scene {name!r} here, or too many are open")
                    self.sessions[name] = Session(gm.load(name))
                return self.sessions[name]

        return await run_in_threadpool(find)

    async def list_scenes(self, request: Request) -> Response:
        """Answer with the list of the shipped scenes."""
        return HTMLResponse(await run_in_threadpool(make_list_page), headers=PAGE_HEADERS)

    async def show_page(self, request: Request) -> Response:
        """Answer with the page of a scene."""
        session = await self.find_session(request)
        return HTMLResponse(await run_in_threadpool(make_live_page, session), headers=PAGE_HEADERS)

    async def show_beside(self, request: Request) -> Response:
        """Answer with the pages of several scenes beside each other."""
        names = request.path_params["names"].split("/")
        if not 1 < len(names) <= MAX_BESIDE or not all(map(self._is_known, names)):
            raise HTTPException(404, f"2 to {MAX_BESIDE} scenes stand beside each other")
        return HTMLResponse(make_beside_page(names), headers=PAGE_HEADERS)

    def _is_known(self, name: str) -> bool:
        """Return whether a scene is open, or comes with the package."""
        return name in self.sessions or name in {*list_contents(), *list_catalogue_entries(None)}

    async def talk(self, socket: WebSocket) -> None:
        """Answer the changes of one page until it closes: each answer is that to the newest state."""
        session = await self.find_session(socket)
        await socket.accept()
        changed, loop = asyncio.Event(), asyncio.get_running_loop()

        def hear() -> None:
            loop.call_soon_threadsafe(changed.set)

        changed.set()
        session.listeners.add(hear)
        answering = asyncio.create_task(_answer(socket, session, changed))
        later: list[asyncio.Task[None]] = []
        try:
            while True:
                message = await socket.receive_text()
                later = [task for task in later if not task.done()]
                answer = await _compute(partial(respond, session, message))
                if not callable(answer):
                    await _send(socket, answer)
                elif len(later) < MAX_WAITING:
                    later.append(asyncio.create_task(_send_later(socket, answer)))
                else:
                    await _send(socket, {"refused": f"{MAX_WAITING} requests wait already for their answers"})
        except (WebSocketDisconnect, KeyError):  # closed, or a message of bytes
            pass
        finally:
            session.listeners.discard(hear)
            for task in (answering, *later):
                task.cancel()
            await asyncio.gather(answering, *later, return_exceptions=True)


async def _answer(socket: WebSocket, session: Session, changed: asyncio.Event) -> None:
    """Send the state whenever it has changed: first the drawing at one moment, and all of it once no newer change waits."""
    is_first = True
    while True:
        await changed.wait()
        changed.clear()
        if not is_first:
            await _send(socket, await _compute(lambda: session.describe_moment(session.solve(is_brief=True))))
            with suppress(TimeoutError):
                await asyncio.wait_for(changed.wait(), HELD_PAUSE if session.is_held else LAST_PAUSE)
        if not changed.is_set():
            await _send(socket, await _compute(lambda: session.describe(session.solve())))
        is_first = False


async def _compute(compute: Callable[[], Answer | Later | None]) -> Answer | Later | None:
    """Return an answer, computed while the server goes on."""
    return await run_in_threadpool(attempt, compute)


async def _send(socket: WebSocket, answer: Answer | Later | None) -> None:
    """Send an answer, if there is one."""
    if answer is not None:
        await socket.send_text(json.dumps(answer, allow_nan=False))


async def _send_later(socket: WebSocket, compute: Later) -> None:
    """Send an answer that takes long; the page may be closed before."""
    answer = await _compute(compute)
    with suppress(RuntimeError, WebSocketDisconnect):
        await _send(socket, answer)


def serve(scenes: Sequence[Scene], port: int, *, opens_browser: bool, tell: Callable[[str], None]) -> None:
    """Serve scenes, alone, beside each other or listed, until interrupted, `tell` the address; MechanismError if that is impossible."""
    if len(scenes) > MAX_BESIDE:
        raise MechanismError(f"at most {MAX_BESIDE} scenes stand beside each other; found {len(scenes)}")
    opened: dict[str, Session] = {}
    for scene in scenes:
        stem = Path(scene.source).stem or "scene"
        name = next(one for one in (stem, *(f"{stem}-{number}" for number in range(2, MAX_BESIDE + 1))) if one not in opened)
        opened[name] = Session(scene)
    with socket.socket() as listener:
        try:
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listener.bind((HOST, port))
            listener.listen()  # from now on a browser may ask, which waits until the server runs
        except OSError as error:
            text = f"port {port} cannot be had ({error.strerror}); give another with --port, or none for any free one"
            raise MechanismError(text) from None
        taken = listener.getsockname()[1]
        workbench = Workbench(secrets.token_urlsafe(16), opened)
        beside = "beside/" if len(opened) > 1 else ""
        address = f"http://{HOST}:{taken}/{workbench.token}/{beside}{''.join(f'{quote(name)}/' for name in opened)}"
        tell(address)
        if opens_browser:
            webbrowser.open(address)
        settings: dict[str, Any] = {"log_level": "error", "ws": "websockets-sansio", "ws_max_size": MAX_MESSAGE_SIZE}
        app = workbench.make_app(taken)
        uvicorn.Server(uvicorn.Config(app, timeout_graceful_shutdown=1, **settings)).run(sockets=[listener])
