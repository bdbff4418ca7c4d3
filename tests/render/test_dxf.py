"""Drawings in DXF have the pins and paths of the run, in millimetres."""

import sys

import numpy as np
import pytest

import governor_mechanism as gm


@pytest.fixture(scope="module")
def leg():
    return gm.run("jansen", certify=False)


def test_pins_and_paths_stand_where_the_run_has_them(leg, tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    path = leg.save_dxf(tmp_path / "leg.dxf", time="1.4 s")
    document = ezdxf.readfile(path)
    assert document.header["$INSUNITS"] == 4  # millimetres
    space = document.modelspace()
    pins = np.array([tuple(circle.dxf.center)[:2] for circle in space.query('CIRCLE[layer=="pins"]')])
    for name in ("knee", "crank.end", "shank.end", "foot"):
        assert np.hypot(*(pins - 1e3 * leg.paths[name][140]).T).min() < 1e-6
    (curve,) = space.query('LWPOLYLINE[layer=="paths"]')
    np.testing.assert_allclose(np.array(curve.get_points("xy")), 1e3 * leg.paths["foot"], atol=1e-9)
    assert len(space.query('LWPOLYLINE[layer=="parts"]')) > 5
    assert len(space.query('*[layer=="ground"]')) > 2
    assert not document.audit().errors


@pytest.mark.parametrize(("options", "sentence"), [
    ({"path": "leg.svg"}, "a drawing's name must end in .dxf; got 'leg.svg'"),
    ({"time": 5.0}, r"time of a drawing must lie within the run, 0..4 s; got 5 s"),
    ({"paths": ["fot"]}, r"no point has this name.*Did you mean 'foot'"),
    ({"part": "leg"}, "the scene has no part 'leg'"),
])  # fmt: skip
def test_wrong_arguments_are_refused(leg, tmp_path, options, sentence):
    with pytest.raises(gm.MechanismError, match=sentence):
        leg.save_dxf(**{"path": tmp_path / "leg.dxf", **options})
    assert not list(tmp_path.iterdir())


def test_without_the_package_the_extra_is_named(leg, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "ezdxf", None)
    with pytest.raises(gm.MechanismError, match=r"needs ezdxf: pip install 'governor-mechanism\[dxf\]'"):
        leg.save_dxf(tmp_path / "leg.dxf")
    assert not list(tmp_path.iterdir())


def test_a_scene_of_several_parts_needs_the_name_of_one(tmp_path):
    run = gm.run("governed_engine", times=np.linspace(0.0, 0.1, 3), certify=False)
    with pytest.raises(gm.MechanismError, match=r"a drawing shows one part; the scene has .*choose one by part"):
        run.save_dxf(tmp_path / "engine.dxf")
