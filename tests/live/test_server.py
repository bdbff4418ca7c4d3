"""The local server: it answers its own page, and refuses everything else."""

import json
import re
import signal
import socket
import subprocess
import sys
import threading
import tomllib
from base64 import b64decode
from contextlib import closing
from http.client import HTTPConnection
from urllib.parse import urljoin, urlsplit

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

import governor_mechanism as gm
from governor_mechanism.live.conversation import parse_message
from governor_mechanism.live.server import HOST, MAX_WAITING, Workbench, serve
from governor_mechanism.live.session import Session
from workbench_server import WAITING_TIME
from workbench_server import serve as run_server

TOKEN = "token-of-the-test"


@pytest.fixture(scope="module")
def port():
    """A server of one scene."""
    session = Session(gm.load("scott_russell").replace({"run.duration": "0.2 s"}))
    with run_server(Workbench(TOKEN, {"mine": session})) as number:
        yield number


def ask(port: int, path: str, **headers: str):
    with closing(HTTPConnection(HOST, port, timeout=WAITING_TIME)) as connection:
        connection.request("GET", path, headers=headers)
        answer = connection.getresponse()
        return answer, answer.read()


def talk(port: int, **settings):
    return connect(f"ws://{HOST}:{port}/{TOKEN}/mine/live", origin=f"http://{HOST}:{port}", max_size=None, **settings)


def next_answer(connection, is_meant) -> dict:
    """The first answer that is meant."""
    while not is_meant(answer := json.loads(connection.recv(timeout=WAITING_TIME))):
        pass
    return answer


def next_state(connection, number: int) -> dict:
    """The first answer to a change of a number, or to a later one."""
    return next_answer(connection, lambda answer: answer.get("number", -1) >= number)


def next_refusal(connection) -> str:
    return next_answer(connection, lambda answer: "refused" in answer)["refused"]


def send(connection, action: str, **message) -> None:
    connection.send(json.dumps({"action": action, **message}))


def export(connection, ending: str) -> bytes:
    """The content of a file that the browser saves."""
    send(connection, "export", ending=ending)
    file = next_answer(connection, lambda answer: "file" in answer)["file"]
    assert file["name"] == f"scene.{ending}"
    return b64decode(file["content"])


def value_of(state: dict, key: str) -> float:
    return {one["key"]: one["value"] for one in state["quantities"]}[key]


def test_the_page_and_the_list_are_served(port):
    for path, expected in ((f"/{TOKEN}/mine/", b"connect-src 'self'"), (f"/{TOKEN}/", b'href="jansen/"')):
        answer, text = ask(port, path)
        assert answer.status == 200
        assert expected in text


def test_two_scenes_stand_beside_each_other(port):
    answer, text = ask(port, f"/{TOKEN}/beside/mine/jansen/")
    assert answer.status == 200
    for name in ("mine", "jansen"):
        (address,) = re.findall(rf'src="((?:\.\./)+{name}/)"', text.decode())
        assert urljoin(f"/{TOKEN}/beside/mine/jansen/", address) == f"/{TOKEN}/{name}/"
    assert b"frame-src 'self'" in text


@pytest.mark.parametrize(
    "path",
    [f"/{TOKEN}/beside/mine/", f"/{TOKEN}/beside/mine/nothing/", "/", "/wrong/", f"/{TOKEN}/nothing/", f"/{TOKEN}/mine/../../etc/passwd"],
)
def test_a_wrong_token_or_path_is_not_found(port, path):
    assert ask(port, path)[0].status == 404


@pytest.mark.parametrize("headers", [{"Host": "evil.example"}, {"Origin": "http://evil.example"}, {"Origin": "null"}])
def test_a_foreign_page_is_refused(port, headers):
    assert ask(port, f"/{TOKEN}/mine/", **headers)[0].status == 403


@pytest.mark.parametrize("origin", ["http://evil.example", None])
def test_a_foreign_page_cannot_connect(port, origin):
    with pytest.raises(InvalidStatus), connect(f"ws://{HOST}:{port}/{TOKEN}/mine/live", origin=origin):
        pass
    for path in ("wrong/mine", f"{TOKEN}/nothing"):
        with pytest.raises(InvalidStatus), connect(f"ws://{HOST}:{port}/{path}/live", origin=f"http://{HOST}:{port}"):
            pass


def test_a_change_is_answered_in_all_tabs_and_saved(port):
    with talk(port) as first, talk(port) as second:
        number = next_state(first, 0)["number"]
        send(first, "change", values={"dimensions.crank": 1.25})
        for connection in (first, second):
            assert value_of(next_state(connection, number + 1), "dimensions.crank") == 1.25
        assert tomllib.loads(export(first, "toml").decode())["dimensions"]["crank"] == "1.25 m"
        assert b"time,crank_angle,pen_x,pen_y" in export(first, "csv")
        assert b"<svg" in export(first, "svg")
        send(first, "reset")
        next_state(first, number + 2)


def test_a_thousand_changes_are_answered_by_few_runs(port):
    with talk(port) as connection:
        state = next_state(connection, 0)
        number, before = state["number"], value_of(state, "dimensions.crank")
        for k in range(1000):
            send(connection, "change", values={"dimensions.crank": 1.0 + k / 1000}, isLast=k == 999)
        n_answers = 1
        while next_state(connection, 0)["number"] < number + 1000:
            n_answers += 1
        assert n_answers < 500
        send(connection, "undo")
        assert value_of(next_state(connection, number + 1001), "dimensions.crank") == before


def test_too_large_a_message_closes_the_connection(port):
    with talk(port) as connection:
        connection.send("x" * 10_000_000)
        with pytest.raises(ConnectionClosed):
            next_state(connection, 10**9)


@pytest.mark.parametrize(("message", "sentence"), [
    ("{", "JSON"), ("[" * 30_000, "JSON"), ("[]", "has an action"), ('{"action": "delete"}', "has an action"),
    ('{"action": "undo", "path": "/etc"}', 'takes no "path"'),
    ('{"action": "change", "values": {}}', "numbers by key"),
    ('{"action": "change", "values": {"dimensions.crank": 1}, "isLast": 1}', "true or false"),
    ('{"action": ["change"]}', "has an action"), ('{"action": "export", "ending": "exe"}', "one of toml"),
    ('{"action": "assemble", "assembly": 0}', "whole number"),
    ('{"action": "assemble", "assembly": 1.5}', "whole number"),
    ('{"action": "save", "name": 3}', "a name is a text"),
    ('{"action": "change", "values": {"dimensions.crank": NaN}}', "NaN is no number"),
    ('{"action": "change", "values": {"dimensions.crank": 1e999}}', "finite number"),
    ('{"action": "change", "values": {"dimensions.crank": "1 m"}}', "finite number"),
    ('{"action": "change", "values": {"dimensions.crank": true}}', "finite number"),
    ('{"action": "change", "values": {"' + "x" * 300 + '": 1}}', "finite number"),
])  # fmt: skip
def test_malformed_messages_are_refused(message, sentence):
    with pytest.raises(gm.MechanismError, match=sentence):
        parse_message(message)


def test_a_refusal_is_answered_and_the_connection_goes_on(port):
    with talk(port) as connection:
        next_state(connection, 0)
        for message in ("{", '{"action": "change", "values": {"title": 1}}'):
            connection.send(message)
            assert next_refusal(connection)


def test_a_failure_of_the_program_is_a_sentence_and_the_page_goes_on(port, monkeypatch):
    with talk(port) as connection:
        number = next_state(connection, 0)["number"]

        def fail(session, snapshot):
            raise ZeroDivisionError("no length")

        with monkeypatch.context() as broken:
            broken.setattr(Session, "describe_moment", fail)
            send(connection, "change", values={"dimensions.crank": 1.1})
            assert "ZeroDivisionError: no length" in next_refusal(connection)
            next_state(connection, number + 1)
        send(connection, "reset")
        assert value_of(next_state(connection, number + 2), "dimensions.crank") == 1.0


def test_more_requests_than_can_wait_are_refused(port, monkeypatch):
    gate = threading.Event()
    monkeypatch.setattr(Session, "find_travel", lambda session: gate.wait(WAITING_TIME) and {"travel": None})
    with talk(port) as connection:
        next_state(connection, 0)
        for _ in range(MAX_WAITING + 1):
            send(connection, "travel")
        assert "wait already" in next_refusal(connection)
        gate.set()
        for _ in range(MAX_WAITING):
            assert json.loads(connection.recv(timeout=WAITING_TIME)) == {"travel": None}


def test_the_address_can_be_asked_as_soon_as_it_is_told():
    def tell(address: str) -> None:
        with socket.create_connection((HOST, urlsplit(address).port)):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        serve([], 0, opens_browser=False, tell=tell)


@pytest.mark.long
def test_an_interrupt_ends_it_with_an_open_page():
    command = [sys.executable, "-m", "governor_mechanism.cli.main", "open", "scott_russell", "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        address = urlsplit(process.stdout.readline().strip())
        with connect(f"ws://{address.netloc}{address.path}live", origin=f"http://{address.netloc}", max_size=None) as connection:
            next_state(connection, 0)
            process.send_signal(signal.SIGINT)
            _, error = process.communicate(timeout=WAITING_TIME)
    assert process.returncode == 130
    assert "Traceback" not in error


def test_a_busy_port_and_a_scene_that_cannot_run_are_sentences():
    with socket.socket() as other:
        other.bind((HOST, 0))
        other.listen()
        with pytest.raises(gm.MechanismError, match=r"port \d+ cannot be had"):
            serve([], other.getsockname()[1], opens_browser=False, tell=print)
