"""Sweeps on a cluster: the same table as alone, whatever happens to its workers."""

import os
import signal
import sys
import warnings

import pytest

import governor_mechanism as gm
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.studies.sweep import workers
from refusing import refuses
from scene_documents import governor_document

DOCUMENT = governor_document(
    title="Porter",
    spindle={"speed": "120 rpm"},
    start={"arm_angle": "40 deg"},
    run={"duration": "0.2 s", "output_interval": "20 ms", "accuracy": 1e-8, "engine": "reduced"},
)
VARY = ["dimensions.arm=250mm:350mm:20", "dimensions.link=100mm,300mm"]
TAKEN = ["final arm_angle", "max sleeve_lift"]


@pytest.fixture(scope="module")
def scene():
    return parse_scene_document(DOCUMENT, "porter.toml")


@pytest.fixture
def distributed():
    """The package, imported when a test needs it: it is slow to import."""
    return pytest.importorskip("distributed", reason="the extra `cluster` (dask.distributed) is not installed")


@pytest.fixture
def local_cluster(distributed):
    """Two worker processes on this computer."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of dask, about ports and forks
        options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
        with distributed.LocalCluster(**options) as found:
            yield found


@pytest.fixture(scope="module")
def alone(scene, tmp_path_factory):
    """Files of the sweep computed in this process."""
    folder = tmp_path_factory.mktemp("alone")
    gm.sweep(scene, VARY, TAKEN, out=folder)
    return listing(folder)


def listing(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.long
def test_the_table_is_the_same_though_a_worker_is_killed_and_whoever_connects(scene, distributed, local_cluster, alone, tmp_path):
    address = local_cluster.scheduler_address
    killed = []

    def kill_one(done, total):
        if done > total / 4 and not killed:
            killed.append(local_cluster.workers[0].pid)
            os.kill(killed[0], signal.SIGKILL)

    gm.sweep(scene, VARY, TAKEN, cluster=address, out=tmp_path / "address", progress=kill_one)
    assert killed
    assert listing(tmp_path / "address") == alone
    with distributed.Client(address, set_as_default=False) as client:
        gm.sweep(scene, VARY, TAKEN, cluster=client, out=tmp_path / "client")
        assert client.status == "running"  # it belongs to the caller
    assert listing(tmp_path / "client") == alone


class _StandInClient:
    """A client whose workers have these versions."""

    scheduler_info = None

    def __init__(self, *found):
        self.found = found

    def wait_for_workers(self, n_workers, timeout):
        if not self.found:
            raise TimeoutError

    def run(self, function, on_error):
        return {f"tcp://worker-{k}": versions for k, versions in enumerate(self.found)}


def test_workers_with_other_versions_or_without_the_package_are_refused():
    own = workers.find_versions()
    workers.require_same_versions(_StandInClient(own, own))
    with pytest.raises(gm.MechanismError) as caught:
        workers.require_same_versions(_StandInClient(own | {"numpy": "1.0"}, own, ModuleNotFoundError("no such module")))
    first, second = caught.value.problems
    assert first.startswith(f"cluster: worker tcp://worker-0 has numpy 1.0 instead of {own['numpy']}; install there")
    assert second == "cluster: worker tcp://worker-2 cannot import this package (no such module); install it there"
    refuses("the scheduler has no workers", workers.require_same_versions, _StandInClient())


def test_a_wrong_cluster_is_refused_in_a_sentence(scene, monkeypatch):
    for wrong in ("host", 3, object()):
        with pytest.raises(gm.MechanismError, match="cluster must be the address of a scheduler, as tcp://host:8786"):
            gm.sweep(scene, VARY, TAKEN, cluster=wrong)
    refuses("leave one of the two out", gm.sweep, scene, VARY, TAKEN, cluster="tcp://127.0.0.1:1", workers=2)
    monkeypatch.setattr(workers, "CONNECTION_TIMEOUT", 0.2)
    with pytest.raises(gm.MechanismError, match=r"no scheduler answers at tcp://127\.0\.0\.1:1 .*start one with `dask scheduler`"):
        gm.sweep(scene, VARY, TAKEN, cluster="tcp://127.0.0.1:1")
    monkeypatch.setitem(sys.modules, "distributed", None)
    refuses(r"pip install 'governor-mechanism\[cluster\]'", gm.sweep, scene, VARY, TAKEN, cluster="tcp://127.0.0.1:1")
