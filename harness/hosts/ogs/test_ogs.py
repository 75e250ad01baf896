"""OpenGeoSys with libasperity_generic: run by `make hosts`, which installs its packages first."""

from __future__ import annotations

import re
import shutil
import subprocess
import sysconfig
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, Pattern, contract, hosts
from asperity.installed import generic_library

pytest.importorskip("ogs", reason="ogs is not installed")

import exported
import meshio
import ogs_run
import triplet
from ogs_run import Floats, Run, changed, values

MATERIAL = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, kc=20.0)
RT = Interface(MATERIAL, Pattern.regular(2, theta=30.0))
PRESSURE = 1.0
PRELOAD_STEPS = 10
WIDTH = 10.0
THIN = 1.0e-4
"""Thickness, mm: the error of free side faces is of second order in thickness over width, 1e-10 here."""

EXACT = 1.0e-8
"""Difference from the driver over strength and s_f: tolerances of both programs, and the layer."""

OF_STRAINS = 1.0e-9
"""Difference of the law on separations from that on strains: the rounding of the strains."""

STEPS = "/*/time_loop/processes/process/time_stepping"


def box(
    folder: Path, interface: Interface, *changes: tuple[str, str, str], h: float = THIN, r: float = 0.0,
    fails: bool = False,
) -> Run:  # fmt: skip
    """Run the layer of the kit, a square of the side WIDTH, with changes of the project."""
    for file in ogs_run.PROJECT.parent.glob("*.vtu"):
        mesh = meshio.read(file)
        mesh.points *= [WIDTH, WIDTH, h / hosts.of("ogs", "kit").options["h"]]
        mesh.write(folder / file.name)
    return ogs_run.run(folder, interface.card("ogs", h=h, r=r), changed(*changes), fails=fails)


def path(run: Run) -> tuple[Floats, Floats, list[dict[str, Floats]]]:
    """Separation and traction (T, 3) from the end of the preload on, means over the face, and the fields."""
    _, steps = run.steps()
    steps = steps[PRELOAD_STEPS:]
    separation = np.array([step["displacement"][4:].mean(axis=0)[[2, 0, 1]] for step in steps])
    # components xx, yy, zz, xy, yz, xz
    traction = np.array([step["sigma"].mean(axis=0)[[2, 5, 4]] for step in steps])
    return separation, traction, steps


def assert_is_the_driver(run: Run, interface: Interface = RT) -> None:
    """Rise and shear traction at the slips of the run are those of the driver's solver."""
    separation, traction, _ = path(run)
    expected = interface.confined_slip(0.0, separation[:, 1], -PRESSURE)
    rise = np.abs(separation[:, 0] - expected.separation[:, 0]).max()
    shear = np.abs(traction[:, 1] - expected.traction[:, 1]).max()
    print(f"{len(separation)} steps, at most {max(run.iterations)} iterations; "
          f"difference of rise {rise:.1e} mm, of shear {shear:.1e} MPa")  # fmt: skip
    assert np.abs(traction[:, 0] + PRESSURE).max() <= EXACT * MATERIAL.sigma0
    assert rise <= EXACT * MATERIAL.s_f
    assert shear <= EXACT * MATERIAL.sigma0


def test_exported_element(tmp_path: Path) -> None:
    """The files of `asperity export ogs` give the rows of the README."""
    cell, steps = exported.element("ogs", tmp_path)
    (tmp_path / "out").mkdir()
    command = [ogs_run.program(), "-p", "card.xml", "-p", "path.xml", "-o", "out", "single.prj"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    rows = []
    for fields in (ogs_run.fields(tmp_path / "out" / f"layer_{number}.vtu") for number in steps):
        slip, _, opening = fields["displacement"][4:].mean(axis=0)
        rows.append([slip, opening, fields["sigma"][:, 5].mean(), fields["damage"].mean()])
    exported.assert_same(cell, rows, EXACT * 1e3)


# --- MGIS -------------------------------------------------------------------


def test_mgis_loads_every_behaviour(tmp_path: Path) -> None:
    """MGIS accepts joints and layers of 1 to 33 planes, with the names and bounds of the contract."""
    compiler = shutil.which("c++")
    if compiler is None:
        pytest.skip("no C++ compiler")
    folder = Path(sysconfig.get_path("purelib")) / "lib64"
    mgis, program = folder / "libMFrontGenericInterface.so", tmp_path / "mgis_load"
    source = Path(__file__).parent / "mgis_load.cpp"
    built = [compiler, "-std=c++17", "-o", program, source, mgis, f"-Wl,-rpath,{folder}"]
    subprocess.run(built, check=True)
    of_joint = ["Tridimensional", "PlaneStrain", "Axisymmetrical", "GeneralisedPlaneStrain", "PlaneStress"]
    pairs = [
        (f"Asperity{wet}{kind}{n}", hypothesis)
        for n in range(1, 34)
        for wet in ("", "Wet")
        for kind, hypotheses in (("Joint", of_joint), ("Layer", of_joint[:-1]))
        for hypothesis in hypotheses
    ]
    arguments = [text for pair in pairs for text in pair]
    done = subprocess.run(
        [program, generic_library(), *arguments], capture_output=True, text=True, check=True
    )
    lines = [line.split() for line in done.stdout.splitlines()]
    assert [(name, hypothesis) for name, hypothesis, *_ in lines] == pairs
    for name, _, gradient, *others in lines:
        joint, n = "Joint" in name, int(re.sub(r"\D", "", name))
        assert gradient == ("OpeningDisplacement" if joint else "Strain")
        owners = ("law", "pattern", "numerics") if joint else ("law", "pattern", "host", "numerics")
        rows = [row for row in contract.owned(*owners) if row.name not in ("map", "water", "implex")]
        for row, text in zip(rows, others, strict=False):
            m = re.fullmatch(r"(\w+)(?:>=([^<]+))?(?:<=(.+))?", text)
            assert m and m[1] == row.name
            assert float(m[2] or -np.finfo(float).max) == row.lower
            assert float(m[3] or np.finfo(float).max) == row.upper
        water = ["FluidPressure"] if "Wet" in name else []
        assert others[len(rows) :] == [*contract.statev_names(n, True, True), *water]
    refused = [program, generic_library(), "AsperityLayer3", "PlaneStress"]
    assert subprocess.run(refused, capture_output=True, check=False).returncode != 0


# --- one layer --------------------------------------------------------------


@pytest.mark.parametrize("sides", [0, 2, 5, 32])
def test_shear_box_is_the_driver(sides: int, tmp_path: Path) -> None:
    """Slip at constant pressure: the path of the driver, for patterns of 1 to 33 planes."""
    joint = Interface(MATERIAL, Pattern.regular(sides, 20.0))
    assert_is_the_driver(box(tmp_path, joint), joint)


def test_cycle(tmp_path: Path) -> None:
    """Slip forward, back and forward again: the history is kept from step to step."""
    cycle = values("slip", [0.0, 0.0, 0.2, -0.2, 0.1])
    coords = ("replace", "/*/curves/curve[name='slip']/coords/text()", "0 1 2 3 4")
    held = ("replace", "/*/curves/curve[name='pressure']/coords/text()", "0 1 4")
    numbers = ("t_end", "4"), ("timesteps/pair[2]/repeat", "90"), ("timesteps/pair[2]/delta_t", repr(1 / 30))
    steps = (("replace", f"{STEPS}/{where}/text()", text) for where, text in numbers)
    run = box(tmp_path, RT, cycle, coords, held, *steps)
    assert_is_the_driver(run)
    separation, _, fields = path(run)
    assert separation[:, 1].min() == pytest.approx(-0.2) and separation[-1, 1] == pytest.approx(0.1)
    assert fields[-1]["friction"].mean() > MATERIAL.Gc


def test_cracked_planes(tmp_path: Path) -> None:
    """Damage by initial_values: residual strength at once, no rupture energy."""
    variables = "".join(f'<state_variable name="alpha_{k}" parameter="cracked"/>' for k in (1, 2, 3))
    where = "/*/processes/process/constitutive_relation[@id='1']"
    start = ("add", where, f"<initial_values>{variables}</initial_values>")
    parameter = "<parameter><name>cracked</name><type>Constant</type><value>1</value></parameter>"
    run = box(tmp_path, RT, start, ("add", "/*/parameters", parameter))
    _, traction, fields = path(run)
    residual = MATERIAL.residual_strength(30.0) * PRESSURE
    print(f"largest shear {traction[:, 1].max():.10f}, closed form {residual:.10f}")
    assert traction[:, 1].max() == pytest.approx(residual, abs=EXACT * MATERIAL.sigma0)
    assert fields[0]["damage"] == pytest.approx(1.0, abs=1e-12)


def test_initial_stress(tmp_path: Path) -> None:
    """initial_stress is the traction of the first call: with its loads the layer does not move."""
    stress = "<parameter><name>s0</name><type>Constant</type><values>0 0 -1 0 0 0.3</values></parameter>"
    initial_stress = ("add", "/*/processes/process", "<initial_stress>s0</initial_stress>")
    loaded = values("pressure", [-PRESSURE, -PRESSURE, -PRESSURE])
    run = box(tmp_path, RT, initial_stress, ("add", "/*/parameters", stress), loaded)
    separation, traction, _ = path(run)
    assert traction[0] == pytest.approx([-1.0, 0.3, 0.0], abs=1e-7)
    assert np.abs(separation[0]).max() < 1e-9


def test_without_axes_the_normal_is_x(tmp_path: Path) -> None:
    """Smallest case of a wrong project: without local_coordinate_system there is no message.

    With r = 1 the other components have the stiffness of the bond.  The slip along x is then an opening and
    a slip of a joint with the normal x, and the pressure is carried elastically.
    """
    h = 0.1
    gone = ("remove", "/*/local_coordinate_system", "")
    run = box(tmp_path, RT, gone, h=h, r=1.0)
    separation, traction, _ = path(run)
    right = path(box(tmp_path, RT, h=h, r=1.0))
    assert separation[0, 0] == pytest.approx(-PRESSURE / MATERIAL.K, rel=1e-3)
    assert np.abs(right[0][:, 0] - separation[:, 0]).max() > 0.1 * MATERIAL.s_f
    assert np.abs(right[1][:, 1] - traction[:, 1]).max() > 0.1 * MATERIAL.sigma0


def test_a_wet_layer_is_refused(tmp_path: Path) -> None:
    """OpenGeoSys passes no other external state variable than the temperature, and says so at once."""
    card = RT.card("ogs", h=THIN).replace("AsperityLayer3", "AsperityWetLayer3")
    for file in ogs_run.PROJECT.parent.glob("*.vtu"):
        shutil.copy(file, tmp_path)
    run = ogs_run.run(tmp_path, card, fails=True)
    assert "Only temperature is supported as external state variable" in run.output


# --- refused calls ----------------------------------------------------------


ADAPTIVE = (
    "<type>IterationNumberBasedTimeStepping</type><t_initial>0</t_initial><t_end>2</t_end>"
    "<initial_dt>0.25</initial_dt><minimum_dt>1e-4</minimum_dt><maximum_dt>0.25</maximum_dt>"
    "<number_iterations>1 10 20</number_iterations><multiplier>1.2 1.0 0.5</multiplier>"
)
"""Adaptive time steps."""


def refused_near(time: float) -> list[tuple[str, str, str]]:
    """Changes by which mu is out of range at one time, so that the law refuses a step that ends there."""
    name = "INTERFACE_mu"
    curve = (
        f"<curve><name>notch</name><coords>0 {time - 1e-6} {time} {time + 1e-6} 9</coords>"
        f"<values>{MATERIAL.mu} {MATERIAL.mu} -1 {MATERIAL.mu} {MATERIAL.mu}</values></curve>"
    )
    scaled = (
        f"<parameter><name>{name}</name><type>CurveScaled</type><curve>notch</curve>"
        "<parameter>one</parameter></parameter>"
    )
    where = f"/*/parameters/parameter[name='{name}']"
    return [("add", "/*/curves", curve), ("replace", where, scaled)]


def test_refused_step_is_repeated_with_a_smaller_one(tmp_path: Path) -> None:
    """Adaptive time steps: a call that the law refuses rejects the step, which is repeated from its start."""
    steps = "replace", STEPS, f"<time_stepping>{ADAPTIVE}</time_stepping>"
    run = box(tmp_path, RT, steps, *refused_near(1.25))
    assert "AsperityLayer3: PROPS(4) mu = -1: expected >= 0" in run.output
    print(f"{run.rejected} steps rejected of {len(run.iterations)}")
    assert run.rejected >= 1
    times, steps = run.steps()
    assert times[-1] == pytest.approx(2.0) and np.all(np.abs(times - 1.25) > 1e-6)
    shear = steps[-1]["sigma"][:, 5].mean()
    assert shear == pytest.approx(MATERIAL.residual_strength(30.0) * PRESSURE, abs=EXACT * MATERIAL.sigma0)


def test_refused_step_ends_a_run_with_fixed_steps(tmp_path: Path) -> None:
    """Without adaptive time steps the run ends with the message and an exit code."""
    run = box(tmp_path, RT, *refused_near(1.5), fails=True)
    assert "AsperityLayer3: PROPS(4) mu = -1: expected >= 0" in run.output


# --- a structure ------------------------------------------------------------


def test_triplet(tmp_path: Path) -> None:
    """Two joints between bricks: residual force and dilation of the closed form, a peak below the point's."""
    points = ogs_run.with_points(triplet.JOINT)
    result = triplet.run(tmp_path, 12, 3, points)
    force, _ = triplet.prediction(result.slip)
    print(f"residual force {result.force[-1]:.6f} N, of the material point {force[-1]:.6f} N")
    # the closed form of a facing plane
    strength = triplet.JOINT.material.residual_strength(triplet.THETA)
    assert force[-1] == pytest.approx(2.0 * triplet.LENGTH * triplet.PRESSURE * strength, rel=1e-9)
    assert result.force[-1] == pytest.approx(force[-1], rel=1e-8)
    slope = np.diff(result.rise[-6:]) / np.diff(result.slip[-6:])
    assert slope == pytest.approx(2.0 * np.tan(np.radians(triplet.THETA)), rel=1e-3)
    assert 0.8 * force.max() < result.force.max() < 0.99 * force.max()
    assert max(result.run.iterations) <= 8
    layered_mesh = meshio.read(tmp_path / "triplet.vtu")
    layer = np.concatenate(layered_mesh.cell_data["MaterialIDs"]) == 1
    rows = [ogs_run.of_points(s, layer, triplet.JOINT, triplet.THICKNESS) for s in result.run.steps()[1]]
    columns = zip(*rows, strict=True)
    *history, state = (np.array(column).reshape(len(rows), 4 * layer.sum(), -1) for column in columns)
    exported.assert_law(triplet.JOINT, OF_STRAINS, *history, state[..., :1])  # the damage
    pvd = tmp_path / "fields.pvd"
    ogs_run.write_paraview(pvd, tmp_path / "triplet.vtu", result.run, triplet.JOINT, triplet.THICKNESS)
    # the opening of a joint is the jump of the displacements over its cell
    joints = meshio.read(sorted((tmp_path / "fields").glob("joints_*.vtu"))[-1])
    u = joints.point_data["displacement"][joints.cells[0].data][..., 1]
    jump = np.abs(u[:, 2:].mean(axis=1) - u[:, :2].mean(axis=1))
    assert jump == pytest.approx(np.abs(joints.cell_data["separation"][0][:, 0]), abs=1e-9)


def test_water_in_the_joints(tmp_path: Path) -> None:
    """HYDRO_MECHANICS: drained joints have the strength of the effective pressure, and its dilation."""
    result = triplet.run(tmp_path, 12, 3, *triplet.with_water(1e3))
    effective = triplet.PRESSURE - triplet.WATER
    force, _ = triplet.prediction(result.slip, effective)
    print(f"force at the end {result.force[-1]:.6f} N, of the material point {force[-1]:.6f} N")
    # suction of the opening joint
    fall = triplet.suction(1e3)
    assert fall < 1e-8 and result.force[-1] == pytest.approx(force[-1], rel=1e-6)
    slope = np.diff(result.rise[-6:]) / np.diff(result.slip[-6:])
    assert slope == pytest.approx(2.0 * np.tan(np.radians(triplet.THETA)), rel=1e-3)


def test_tight_joints_that_open_suck_water(tmp_path: Path) -> None:
    """HYDRO_MECHANICS: dilation lowers the water pressure of tight joints and raises their strength.

    Pressure and force are those of steady flow into a joint that opens at a constant rate.
    """
    columns, permeability = 12, 2e-5
    result = triplet.run(tmp_path, columns, 3, *triplet.with_water(permeability))
    fall = triplet.suction(permeability)
    # mean of a parabola, interpolated between the nodes
    mean = 2.0 / 3.0 * fall * (1.0 - 1.0 / columns**2)
    strength = triplet.JOINT.material.residual_strength(triplet.THETA)
    effective = triplet.PRESSURE - triplet.WATER + mean
    expected = 2.0 * triplet.LENGTH * strength * effective
    dry = 2.0 * triplet.LENGTH * strength * triplet.PRESSURE
    print(f"pressure {result.water[-1]:.6f} MPa, closed form {triplet.WATER - fall:.6f}")
    print(f"force at the end {result.force[-1]:.4f} N, closed form {expected:.4f}, dry {dry:.4f}")
    assert result.water[-1] == pytest.approx(triplet.WATER - fall, abs=1e-3 * fall)
    assert result.force[-1] == pytest.approx(expected, rel=1e-3)
