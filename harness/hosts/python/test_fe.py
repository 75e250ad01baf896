"""The law in scikit-fem, compared with closed forms on small meshes. `make hosts` runs these tests."""

from __future__ import annotations

import sys
from itertools import pairwise
from pathlib import Path

import asperity
import numpy as np
import pytest
from asperity import contract

pytest.importorskip("skfem", reason="asperity[fe] is not installed")

sys.path.insert(0, str(Path(__file__).parent.parent))
import dcb
import joint
import paraview_check
import pull_out


def test_pull_out(tmp_path: Path) -> None:
    """The force ends at the residual strength, the rise at tan(theta) times the slip; Newton is quadratic.

    The files for ParaView have the tractions and states of the last accepted steps.
    """
    curve = pull_out.run(0.4, 16, 8)
    # Newton's tolerance is 1e-10 of the largest nodal force
    assert curve.force[-1] == pytest.approx(pull_out.residual_strength(), rel=1e-8)
    rise = np.diff(curve.rise[-3:]) / np.diff(curve.slip[-3:])
    assert rise == pytest.approx(np.tan(np.radians(pull_out.THETA)), rel=1e-6)
    squared = [
        after / before**2
        for norms in curve.norms
        for before, after in pairwise(norms)
        if before < 1e-3 and after > 1e-12
    ]
    assert len(squared) >= 3 and max(squared) < 1e3
    pull_out.write_paraview(tmp_path / "block.pvd", curve)
    found = paraview_check.fields(tmp_path / "block.pvd")
    assert np.array_equal(found["separation"], curve.separation)
    assert np.array_equal(found["traction"], curve.traction)
    for name in ("damage", "stored", "rupture", "friction"):
        assert np.array_equal(found[name], curve.state[:, :, contract.statev_index(name)])
    again = pull_out.INTERFACE.update(curve.separation[-1], curve.state[-2], curve.separation[-2])
    assert np.abs(again.traction - found["traction"][-1]).max() <= 1e-12 * pull_out.MATERIAL.sigma0
    assert np.abs(again.friction - found["friction"][-1]).max() <= 1e-12 * pull_out.MATERIAL.Gc
    # the files have the corners of the quadratic elements only, so that their middles are a little off
    paraview_check.places(tmp_path / "block.pvd", curve.separation.shape[1] // 8, up=1, away=0.3)


def test_pull_out_without_the_unsymmetric_part() -> None:
    """With the symmetric part of the tangent Newton needs more than twice the iterations, or diverges."""
    whole = pull_out.run(0.1, 8, 4)
    try:
        assert pull_out.run(0.1, 8, 4, symmetric=True).iterations > 2 * whole.iterations
    except joint.NotConverged as error:
        assert "residuals" in str(error)


def test_pull_out_is_that_of_kratos() -> None:
    """Two codes agree in force, rise and every separation of the base, on the same mesh, with a reversal.

    After the reversal Kratos without the adapter is far off, so the comparison depends on the history.
    """
    pytest.importorskip(
        "KratosMultiphysics.GeoMechanicsApplication", reason="asperity[kratos] is not installed"
    )
    sys.path.append(str(Path(__file__).parent.parent / "kratos"))
    import pulled_block

    both = pulled_block.compare(0.4, 16, 16, back=0.0)
    print(f"force {both.force.max():.1e} of the peak, separations {both.separation.max():.1e} mm")
    assert both.force.max() <= pulled_block.FORCE_BOUND
    assert both.separation.max() <= pulled_block.SEPARATION_BOUND
    assert both.rise.max() <= pulled_block.SEPARATION_BOUND
    # before it is pulled, the fixed face prevents the pressed block from widening
    assert both.python.force[0] < -1.0
    # unlike a material point, the joint fails from the pulled face on
    assert np.ptp(both.python.separation[:, :, 1], axis=1).max() > 0.01
    # after the reversal all points slide down their planes; Newton's tolerance is 1e-10 of some 100 N
    tangent, mu = np.tan(np.radians(pull_out.THETA)), pull_out.MATERIAL.mu
    down = (tangent - mu) / (1.0 + mu * tangent) * pull_out.PRESSURE * pull_out.LENGTH
    print(f"force on the way back {both.kratos.force[-3]:.6f}, closed form {down:.6f}")
    assert both.kratos.force[-3] == pytest.approx(down, rel=1e-8)
    forgetful = pulled_block.compare(0.4, 16, 16, back=0.0, UDSM_NAME=str(asperity.library()))
    print(f"without the adapter the force is wrong by {forgetful.force.max():.2f} of the peak")
    turn = int(forgetful.python.slip.argmax()) + 1
    assert forgetful.force[:turn].max() <= pulled_block.FORCE_BOUND  # the slip forward
    assert forgetful.force[turn:].max() > 0.5  # the slip back


def test_double_cantilever_beam() -> None:
    """While the crack grows J equals Gc to 2 % and the force that of beam theory to 1 %."""
    curve = dcb.run(1.5, 12, 0.5)
    grown = curve.opening > 1.3
    assert grown.sum() >= 2 and curve.crack[-1] > dcb.CRACK + 2
    # The cohesive zone is five or six elements long and moves by one element at a time.
    assert curve.j_integral[grown] == pytest.approx(dcb.MATERIAL.Gc, rel=0.02)
    assert curve.force[grown] == pytest.approx(dcb.growth(curve.opening[grown]), rel=0.01)
