"""Studies and curves as tables and JSON: the numbers of their arrays, under their names."""

import json

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.studies.regulation.speed_changes import SettlingStudy

pandas = pytest.importorskip("pandas")


def test_a_speed_curve_is_a_table_over_its_coordinate(tmp_path):
    curve = gm.speed_curve("watt_improved", points=20, resistance="40 N")
    table = curve.to_dataframe()
    assert table.index.name == curve.coordinate_name
    np.testing.assert_array_equal(table.index, curve.coordinate)
    for name in ("speed", "stiffness", "stable"):
        np.testing.assert_array_equal(table[name], getattr(curve, name))
    np.testing.assert_array_equal(table["rising_speed"], curve.insensitivity_band.rising_speed)
    record = json.loads(curve.save_json(tmp_path / "curve.json").read_text(encoding="utf-8"))
    assert record["speed"] == curve.speed.tolist()
    assert record["insensitivity_band"]["against"] == "sleeve_lift"


def test_a_controlling_force_is_a_table_with_the_names_of_its_readings():
    curve = gm.controlling_force("porter", points=5)
    table = curve.to_dataframe()
    assert {"ball_radius", "sleeve_lift", "force"} <= set(table.columns)
    np.testing.assert_array_equal(table["ball_radius"], curve.radius)


def test_a_sweep_is_a_table_of_its_rows(tmp_path):
    sweep = gm.sweep("porter", {"dimensions.arm": ["280 mm", "300 mm"]}, ["max arm_angle"])
    table = sweep.to_dataframe()
    assert table["dimensions.arm"].tolist() == [0.28, 0.3]
    np.testing.assert_array_equal(table["max arm_angle"], sweep.column("max arm_angle"))
    assert table.attrs["units"] == {"dimensions.arm": "m", "max arm_angle": "rad"}
    assert json.loads(sweep.save_json(tmp_path / "sweep.json").read_text(encoding="utf-8"))["scene"] == "porter.toml"


def test_a_stability_map_is_a_table_of_its_points():
    keys = ("part.engine.dimensions.inertia", "part.governor.effects.dashpot.sleeve")
    study = gm.stability_map("governed_engine_mean_torque", [f"{keys[0]}=400:1600:3", f"{keys[1]}=100:400:2"], border_points=0)
    table = study.to_dataframe()
    assert table.shape == (6, 6)
    for k, row in table.iterrows():
        assert row[keys[0]] == study.x.values[k % 3]
        assert row[keys[1]] == study.y.values[k // 3]
        assert row["growth_rate"] == study.growth_rates[k // 3, k % 3]


def test_a_load_change_is_a_table_over_time(tmp_path):
    study = gm.load_change_study("governed_engine_mean_torque")
    table = study.to_dataframe()
    assert table["speed"].iloc[-1] == study.mean_speeds[2]
    assert table.attrs["units"]["speed"] == "rad/s"
    assert json.loads(study.save_json(tmp_path / "study.json").read_text(encoding="utf-8"))["verdict"] == study.verdict


def test_kinematics_have_the_readings_of_a_run_that_positions_determine():
    """The forces of a run at a position are those of the kinematics there, which know nothing of its motion."""
    run = gm.run("hartung_dubois")
    rows = slice(None, None, 100)
    motion = gm.kinematics(run.scene, over="lever_angle", values=run.readings["lever_angle"][rows])
    for name in ("spring_force", "static_sleeve_force", "regulating_force"):
        # The joints of both are closed to 1e-15 m; the springs have some 1e5 N/m.
        np.testing.assert_allclose(motion.readings[name], run.readings[name][rows], rtol=1e-12, atol=1e-9)
    assert {"spring_force", "rate of sleeve_lift", "acceleration of sleeve_lift"} <= set(motion.to_dataframe().columns)


def test_kinematics_of_an_engine_have_pressures_and_the_speed_of_the_shaft():
    run = gm.run("air_engine")
    rows = slice(None, 300, 10)
    motion = gm.kinematics(run.scene, over="crank_angle", values=run.readings["crank_angle"][rows], rate=2.5)
    np.testing.assert_array_equal(motion.readings["shaft_speed"], 2.5)
    for name in ("expansion_pressure", "suction_pressure", "delivery_pressure"):
        np.testing.assert_allclose(motion.readings[name], run.readings[name][rows], rtol=1e-12)  # rounding of the positions


def test_events_of_a_valve_and_rows_of_a_check_are_tables():
    timing = gm.valve_timing("slide_valve_30")
    assert timing.to_dataframe()["exact"].tolist() == [event.exact for event in timing.rows]
    report = gm.crosscheck("slider_crank")
    assert report.to_dataframe()["difference"].tolist() == [row.difference for row in report.rows]


def test_valve_gears_are_a_table_of_their_positions():
    gears = gm.valve_gears(["gooch"], 3)
    table = gears.to_dataframe()
    assert table["position"].tolist() == [1.0, 0.0, -1.0]
    np.testing.assert_array_equal(table[["crank_end_cut_off", "head_end_cut_off"]], gears.gears[0].cut_offs)


def test_modes_are_the_rows_of_linearised_equations():
    linearisation = gm.linearise("porter_dashpot")
    table = linearisation.to_dataframe()
    assert table["growth_rate"].tolist() == [mode.eigenvalue.real for mode in linearisation.modes]
    assert linearisation.as_json()["stability"] == "stable"


def test_a_design_is_a_row_with_the_names_of_its_values():
    table = gm.design_hartnell().to_dataframe()
    assert table["textbook.rate"][0] == gm.design_hartnell().textbook.rate
    assert table["inputs.ball_mass"][0] == 2.5


def test_a_study_is_a_table_of_its_arrays_and_what_is_not_finite_is_left_out_of_json():
    times = np.array([np.inf, 2.5])
    study = SettlingStudy(title="study", damping_coefficients=np.array([10.0, 20.0]), settling_times=times, best=(20.0, 2.5))
    table = study.to_dataframe()
    assert table.columns.tolist() == ["damping_coefficients", "settling_times"]
    np.testing.assert_array_equal(table["settling_times"], times)
    assert table.attrs["best"] == [20.0, 2.5]
    assert study.as_json()["settling_times"] == [None, 2.5]


def test_kinematics_are_read_by_the_names_of_the_crosscheck():
    scene = gm.load("hartung_dubois")
    motion = gm.kinematics(scene, over="lever_angle", values=[0.0, 0.1], rate=2.0)
    assert motion["static_sleeve_force"] is motion.readings["static_sleeve_force"]
    assert motion["rate_of_sleeve_lift"] is motion.rates["sleeve_lift"]
    assert motion["acceleration_of_weight_radius"] is motion.reading_accelerations["weight_radius"]
    np.testing.assert_allclose(motion["rate_of_lever_angle"], 2.0, rtol=1e-14)
    assert all(len(motion[name]) == 2 for name in motion)
    assert "rate_of_sleeve_lift" in motion
    assert "rate_of_sleeve_lft" not in motion
    with pytest.raises(KeyError, match="Did you mean 'sleeve_lift'"):
        motion["rate_of_sleeve_lft"]
