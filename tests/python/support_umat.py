"""UMATs that the tests share: the law of planted_umat.f, which has faults on request, and an attacker."""

from __future__ import annotations

import re
from pathlib import Path

from asperity import ForeignUmat

STIFFNESS, ONSET, BROKEN, SHARE = 100.0, 0.01, 0.2, 0.5
"""Constants of the planted law: stiffness, separations of onset and rupture, weight of the shears."""

MIXED = """&step s_N = 0.05, s_Tx = 0.04, increments = 20 /
&step s_N = -0.01, s_Tx = 0.01, increments = 20 /
&step s_N = 0.02, s_Tx = -0.2, s_Ty = 0.02, increments = 40 /
"""
"""Path with mixed modes, unloading, closing and reloading."""

ATTACKER = """
#define _GNU_SOURCE
#include <fcntl.h>
#include <fenv.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>
void wait_for_ever() { for (;;) pause(); }
void umat_(double *stress, double *statev, double *ddsdde, double *sse, double *spd, double *scd, double *rpl,
           double *ddsddt, double *drplde, double *drpldt, double *stran, double *dstran) {
  for (int i = 0; i < 9; i++) ddsdde[i] = i % 4 == 0 ? 100 : 0;
  for (int i = 0; i < 3; i++) stress[i] = 100 * (stran[i] + dstran[i]);
  if (stran[0] + dstran[0] > 0.0035) { ATTACK }
}
"""
"""Elastic UMAT that does something at larger openings."""


def planted(library: Path, fault: int = 0, nstatv: int = 7, more: str = "") -> str:
    """Group &umat of the planted law."""
    props = f"{STIFFNESS}, {ONSET}, {BROKEN}, {SHARE}, {fault}"
    return (
        f"&umat library = '{library}', props = {props}, nstatv = {nstatv}, damage = 1,\n"
        f"  length = {ONSET}, stiffness = {STIFFNESS} {more} /\n"
    )


def of_python(library: Path, fault: int = 0) -> ForeignUmat:
    """Return the planted law in Python."""
    return ForeignUmat(library, ONSET, STIFFNESS, (STIFFNESS, ONSET, BROKEN, SHARE, fault), 7, damage=1)


def outcomes(text: str) -> dict[str, str]:
    """Return the outcome of each check in a table."""
    return dict(
        (name, outcome)
        for outcome, name in re.findall(r"^(passed|FAILED|stated|not \w+) +(\w+)", text, re.MULTILINE)
    )
