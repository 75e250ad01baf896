"""A glued strip that is pulled at one end: its force beside the closed form, and its energies."""

import numpy as np
from asperity import Interface, Material, Pattern
from scipy.linalg import solve_banded

STRIP, LENGTH, BARS, STEPS, END = 194.79e3, 300.0, 300, 200, 0.5


def pulled(joint: Interface) -> tuple[float, float, float, float, float]:
    """Largest force, its work, and the energies of strip, bond and rupture at the end, per width."""
    part, stiff = np.full(BARS + 1, LENGTH / BARS), STRIP * BARS / LENGTH
    part[[0, -1]] *= 0.5
    s, state, forces = np.zeros((BARS + 1, 3)), np.zeros((BARS + 1, joint.nstatv)), [0.0]
    for target in np.linspace(0.0, END, STEPS + 1)[1:]:
        old = s.copy()
        s[-1, 1] = target
        for _ in range(30):
            end, u = joint.update(s, state, old), s[:, 1]
            out = part * end.traction[:, 1] + stiff * (np.diff(u, prepend=u[0]) - np.diff(u, append=u[-1]))
            if np.abs(out[:-1]).max() < 1e-9 * forces[-1] + 1e-9:
                break
            bands = np.zeros((3, BARS))
            bands[1] = part[:-1] * end.tangent[:-1, 1, 1] + stiff * np.append(1.0, np.full(BARS - 1, 2.0))
            bands[0, 1:] = bands[2, :-1] = -stiff
            s[:-1, 1] -= solve_banded((1, 1), bands, out[:-1])
        else:
            raise RuntimeError(f"no equilibrium at {target:g}")
        state = end.state
        forces.append(float(out[-1]))
    work = float(np.trapezoid(forces, dx=END / STEPS))
    elastic = 0.5 * stiff * float(np.sum(np.diff(s[:, 1]) ** 2))
    bond = 0.5 * float(part @ (end.traction[:, 1] * s[:, 1]))
    return max(forces), work, elastic, bond, float(part @ end.rupture)


for name, material in (
    ("exact", Material(sigma0=5.2, Gc=0.676, eta=1.0 - 0.045 / 0.26, mu=0.0)),
    ("Gc2", Material(sigma0=1.0, Gc=0.1, sigma02=5.2, Gc2=0.676, eta=1.0 - 0.045 / 0.26, mu=0.0)),
):
    force, work, *parts = pulled(Interface(material, Pattern.regular(0, 0.0)))
    closed = np.sqrt(2.0 * STRIP * 0.676)
    print(f"{name:6} {force:.2f} of {closed:.2f} N/mm; work {work:.2f} N: strip {parts[0]:.2f}", end="")
    print(f", bond {parts[1]:.2f}, rupture {parts[2]:.2f}, sum {sum(parts):.2f}")
